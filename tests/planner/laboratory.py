"""A laboratory with a long object that takes two robots and a compact one, without a world file."""

from math import dist

from planner import Fact, PlanningProblem

GOAL = Fact("object_position", ("rock_sample", "in", "lander"))
HOME = tuple(Fact("robot_position", (robot, "near", f"home_{robot}")) for robot in ("fred", "ginger"))
TAGS = ("NAVIGATE", "DOCK", "DOCK2", "TRANSPORT", "RELEASE1", "RELEASE2", "TRACK")
POINTS = {
    "quarry": (2.0, 5.5),
    "basket": (4.0, 5.5),
    "lander": (8.0, 1.5),
    "home_fred": (1.0, 1.0),
    "home_ginger": (1.0, 3.0),
}


def laboratory(*goals: Fact, robots: tuple[str, ...] = ("fred", "ginger")) -> PlanningProblem:
    """The rock sample lies in the quarry, a pebble in the basket; the rock sample to the lander unless told."""
    points = {**POINTS, **{f"{robot}_spot": POINTS[f"home_{robot}"] for robot in robots}}
    objects = dict.fromkeys(points, "location") | dict.fromkeys(robots, "robot")
    objects |= {"lab": "area", "rock_sample": "long_object", "pebble": "object"}
    shared = ("quarry", "basket", "lander")
    facts = {Fact("clear", (place, "lab")) for place in shared} | {Fact("vacant", ("lander",))}
    facts |= {Fact("object_position", ("rock_sample", "in", "quarry"))}
    facts |= {Fact("object_position", ("pebble", "in", "basket"))}
    for robot in robots:
        home = f"home_{robot}"
        facts |= {Fact("robot_position", (robot, "near", home)), Fact("in_area", (robot, "lab"))}
        facts |= {Fact("robot_attribute", (robot, "gripper", "empty"))}
        facts |= {Fact("own_spot", (robot, f"{robot}_spot"))}
        facts |= {Fact("reaches", (robot, place)) for place in (*shared, home)}
        facts |= {Fact("can", (robot, tag)) for tag in TAGS} | {Fact("solid", (robot,))}
    functions: dict[tuple[str, tuple[str, ...]], float] = {("speed_m_s", (robot,)): 0.5 for robot in robots}
    functions |= {
        ("distance_m", (one, other)): round(dist(here, there), 3)
        for one, here in points.items()
        for other, there in points.items()
        if one != other
    }
    return PlanningProblem(
        objects=objects, facts=frozenset(facts), goals=goals or (GOAL,), functions=functions
    )
