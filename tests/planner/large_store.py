"""A store of any size with one errand a sample, written down without a search: long sequences at once."""

from dataclasses import dataclass
from math import dist

from planner import Fact, GroundAction, KnowledgeBase, PlanningProblem
from tests.planner.store import Points, inside


@dataclass(frozen=True, slots=True, kw_only=True)
class LargeStore:
    """As many aisles as yard robots; one store robot and one interchange an aisle; a door and a bay a sample.

    Every robot drives home after each leg, so all can use the same interchanges one after the other.
    """

    aisles: int
    samples: int

    @property
    def bays(self) -> list[tuple[int, int]]:
        """Each sample's aisle and place in it; spread so that yard robots meet at interchanges."""
        return [((n * 5 + n // self.aisles) % self.aisles, n // self.aisles) for n in range(self.samples)]

    def points(self) -> tuple[Points, list[Points]]:
        """The yard's places and each aisle's, metres."""
        yard: Points = {f"door_{n}": (0.5 * n, 0.0) for n in range(self.samples)}
        yard |= {f"home_yard_{n}": (2.0 * n, 2.0) for n in range(self.aisles)}
        interchanges = {f"interchange_{n}": (3.0 * n, 6.0) for n in range(self.aisles)}
        aisles: list[Points] = [
            {f"interchange_{n}": interchanges[f"interchange_{n}"], f"home_store_{n}": (3.0 * n, 7.0)}
            for n in range(self.aisles)
        ]
        for sample, (aisle, place) in enumerate(self.bays):
            aisles[aisle][f"bay_{sample}"] = (3.0 * aisle, 8.0 + place)
        return yard | interchanges, aisles

    def problem(self) -> PlanningProblem:
        """Every sample from its door to its bay."""
        yard, aisles = self.points()
        stations = [(f"yard_{n}", yard, "yard") for n in range(self.aisles)]
        stations += [(f"store_{n}", aisle, f"aisle_{n}") for n, aisle in enumerate(aisles)]
        objects = {place: "location" for _, places, _ in stations for place in places}
        objects |= {area: "area" for _, _, area in stations} | {robot: "robot" for robot, _, _ in stations}
        objects |= {f"sample_{n}": "object" for n in range(self.samples)}
        facts = {inside(f"sample_{n}", f"door_{n}") for n in range(self.samples)}
        facts |= {Fact("vacant", (place,)) for place in objects if place.startswith(("bay", "interchange"))}
        functions: dict[tuple[str, tuple[str, ...]], float] = {}
        for robot, places, area in stations:
            facts |= {
                Fact("robot_position", (robot, "near", f"home_{robot}")),
                Fact("in_area", (robot, area)),
            }
            facts |= {Fact("robot_attribute", (robot, "gripper", "empty"))}
            facts |= {Fact("can", (robot, tag)) for tag in ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2")}
            facts |= {Fact("reaches", (robot, place)) for place in places}
            facts |= {Fact("clear", (place, area)) for place in places if not place.startswith("home")}
            functions["speed_m_s", (robot,)] = 0.5
        for places in (yard, *aisles):
            functions |= {
                ("distance_m", (a, b)): dist(p, q)
                for a, p in places.items()
                for b, q in places.items()
                if a != b
            }
        return PlanningProblem(
            objects=objects, facts=frozenset(facts), goals=self.goals(), functions=functions
        )

    def goals(self) -> tuple[Fact, ...]:
        return tuple(inside(f"sample_{n}", f"bay_{n}") for n in range(self.samples))

    def sequence(self, problem: PlanningProblem, base: KnowledgeBase) -> list[GroundAction]:
        """The errands one after the other: ten actions a sample."""
        steps: list[tuple[str, dict[str, str]]] = []
        for sample, (aisle, _) in enumerate(self.bays):
            interchange = f"interchange_{aisle}"
            yard = f"yard_{sample % self.aisles}"
            steps += _leg(yard, "yard", f"sample_{sample}", f"door_{sample}", interchange)
            steps += _leg(
                f"store_{aisle}", f"aisle_{aisle}", f"sample_{sample}", interchange, f"bay_{sample}"
            )
        return [
            base.ground(tag, arguments, problem.functions, objects=problem.objects)
            for tag, arguments in steps
        ]


def _leg(robot: str, area: str, sample: str, start: str, end: str) -> list[tuple[str, dict[str, str]]]:
    home = f"home_{robot}"
    drive = {"robots": robot, "rel1": "near", "rel2": "near", "area": area}
    load = {"object": sample, "robots": robot, "rel1": "at", "ref1": start, "rel2": "near", "ref2": end}
    return [
        ("NAVIGATE", {**drive, "ref1": home, "ref2": start}),
        ("DOCK", {"object": sample, "robots": robot, "rel1": "near", "ref1": start}),
        ("TRANSPORT", {**load, "area": area}),
        ("RELEASE2", load),
        ("NAVIGATE", {**drive, "ref1": end, "ref2": home}),
    ]
