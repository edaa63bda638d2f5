"""Stores of any size, straight as planning problems."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import dist

from planner import Fact, PlanningProblem
from tests.planner.store import Points, inside

TAGS = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2", "TRACK")


@dataclass(frozen=True, slots=True, kw_only=True)
class Store:
    """A yard with doors, and aisles with bays; each aisle has its robots and its interchanges with the yard.

    Every robot has a home of its own; only the yard's robots reach the doors.
    """

    aisles: int = 2
    yard_robots: int = 2
    store_robots: int = 1
    interchanges: int = 1
    doors: int = 2
    bays: int = 6

    def problem(
        self,
        goals: Iterable[Fact],
        samples: Mapping[str, str],
        *,
        robots_at: Mapping[str, str] | None = None,
    ) -> PlanningProblem:
        """:param samples: each sample's place. :param robots_at: robots that do not stand at home."""
        standing = dict(robots_at or {})
        lying = set(samples.values())
        yard: Points = {f"door_{n}": (2.0 * n, 0.0) for n in range(self.doors)}
        objects = dict.fromkeys(samples, "object")
        facts = {inside(sample, place) for sample, place in samples.items()}
        functions: dict[tuple[str, tuple[str, ...]], float] = {}
        teams = []
        for aisle in range(self.aisles):
            border = {f"interchange_{aisle}_{n}": (4.0 * aisle + n, 4.0) for n in range(self.interchanges)}
            bays = {f"bay_{aisle}_{n}": (4.0 * aisle, 6.0 + n) for n in range(self.bays)}
            yard |= border
            teams.append((f"store_{aisle}", f"aisle_{aisle}", self.store_robots, border | bays, 8.0))
        for team, area, count, places, depth in [("yard", "yard", self.yard_robots, yard, 2.0), *teams]:
            homes: Points = {f"home_{team}_{n}": (1.0 * n, depth) for n in range(count)}
            robots = {f"{team}_{n}": f"home_{team}_{n}" for n in range(count)}
            objects |= dict.fromkeys((*places, *homes), "location") | dict.fromkeys(robots, "robot")
            objects[area] = "area"
            at = {robot: standing.get(robot, home) for robot, home in robots.items()}
            for robot, home in robots.items():
                facts |= {Fact("robot_position", (robot, "near", at[robot])), Fact("in_area", (robot, area))}
                facts |= {Fact("robot_attribute", (robot, "gripper", "empty"))}
                facts |= {Fact("can", (robot, tag)) for tag in TAGS}
                facts |= {Fact("reaches", (robot, place)) for place in (*places, home)}
                functions["speed_m_s", (robot,)] = 0.5
            facts |= {Fact("clear", (place, area)) for place in places | homes if place not in at.values()}
            facts |= {Fact("vacant", (place,)) for place in places if place not in lying}
            functions |= {
                ("distance_m", (a, b)): dist(p, q)
                for a, p in (places | homes).items()
                for b, q in (places | homes).items()
                if a != b
            }
        return PlanningProblem(
            objects=objects, facts=frozenset(facts), goals=tuple(goals), functions=functions
        )
