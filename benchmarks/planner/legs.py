"""The sample-store domain as a job shop: what each sample's way is made of, and how long each part takes.

A *leg* is one robot's part of a sample's way: fetch it at one place, deliver it at another. Robots of one area are
alike but for where they stand.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from planner import Fact, GroundAction, KnowledgeBase, PlanningProblem

MILLISECONDS = 1000
ELSEWHERE = "elsewhere"
"""A fictitious place: as near to each place as that one's nearest neighbour, always clear. For bounds."""


class NotModelled(ValueError):
    """Raised when an instance is beyond the exact model; says why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """`step`: the leg's number among those of the sample."""

    sample: str
    step: int
    area: str
    fetch: str
    deliver: str


class Shop:
    """The instance's areas, robots, legs and durations.

    :raises NotModelled: if a goal is not `object_position(sample, in, place)`, or a sample has several ways.
    """

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self._base = knowledge_base
        self._problem = problem
        facts: dict[str, list[tuple[str, ...]]] = defaultdict(list)
        for fact in sorted(problem.facts):
            facts[fact.predicate].append(fact.args)
        self.area_of = {args[0]: args[1] for args in facts["in_area"]}
        self.robots: Mapping[str, list[str]] = defaultdict(list)
        for robot, area in self.area_of.items():
            self.robots[area].append(robot)
        self.stands = {robot: place for robot, _, place in facts["robot_position"]}
        self.lies = {sample: place for sample, _, place in facts["object_position"]}
        self.reach: Mapping[str, set[str]] = defaultdict(set)
        for robot, place in facts["reaches"]:
            self.reach[robot].add(place)
        self._areas_at: Mapping[str, set[str]] = defaultdict(set)
        for robot, places in self.reach.items():
            for place in places:
                self._areas_at[place].add(self.area_of[robot])
        self.legs = tuple(leg for goal in problem.goals for leg in self._way(goal))
        if set(self.lies) != {leg.sample for leg in self.legs}:
            raise NotModelled("a sample without a goal may be in the way")

    def ground(self, tag: str, robot: str, **arguments: str) -> GroundAction:
        named = {"area": self.area_of[robot], "robots": robot, **arguments}
        given = {
            parameter.name: named[parameter.name]
            for parameter in self._base.actions[tag].parameters
            if parameter.name in named
        }
        return self._base.ground(tag, given, self._problem.functions, objects=self._problem.objects)

    # Milliseconds. Robots of one area are alike, so any that reaches the places represents all.
    def robot(self, area: str, *places: str) -> str:
        return next(r for r in self.robots[area] if all(self.reaches(r, place) for place in places))

    def places(self, area: str) -> list[str]:
        return sorted(set().union(*(self.reach[robot] for robot in self.robots[area])))

    def reaches(self, robot: str, place: str) -> bool:
        return place == ELSEWHERE or place in self.reach[robot]

    def drive(self, robot: str, one: str, other: str) -> int:
        """To or from the nearest place if one of the two is ELSEWHERE."""
        if ELSEWHERE not in (one, other):
            return in_ms(self.navigate(robot, one, other))
        known = other if one == ELSEWHERE else one
        return min(self.drive(r, known, place) for r, place in self._beside(self.area_of[robot], known))

    def haul(self, leg: Leg, one: str, other: str) -> int:
        if ELSEWHERE not in (one, other):
            return in_ms(self.transport(self.robot(leg.area, one, other), leg, "near", one, other))
        known = other if one == ELSEWHERE else one
        return min(self.haul(leg, known, place) for _, place in self._beside(leg.area, known))

    def _beside(self, area: str, place: str) -> list[tuple[str, str]]:
        """Each robot of the area that reaches a place, with each other place it reaches."""
        able = [robot for robot in self.robots[area] if self.reaches(robot, place)]
        return [(robot, other) for robot in able for other in sorted(self.reach[robot]) if other != place]

    def docking(self, leg: Leg) -> int:
        return in_ms(self.dock(self.robot(leg.area), leg))

    def releasing(self, leg: Leg) -> int:
        return in_ms(self.release(self.robot(leg.area), leg, "at", leg.fetch))

    def way(self, robot: str, origin: str, leg: Leg) -> int:
        """To where the leg begins."""
        return 0 if origin == leg.fetch else self.drive(robot, origin, leg.fetch)

    def work(self, leg: Leg) -> int:
        """From docking to the end of releasing, at least."""
        return self.docking(leg) + self.haul(leg, leg.fetch, leg.deliver) + self.releasing(leg)

    def longest(self, leg: Leg) -> int:
        """What a leg takes in the schedule of one leg after the other, each robot going home in between."""
        robot = self.robots[leg.area][0]
        return 2 * max(self.way(robot, place, leg) for place in self.reach[robot]) + self.work(leg)

    def head(self, leg: Leg) -> int:
        """The earliest a leg's docking can start, because of the sample's legs before."""
        before = [other for other in self.legs if other.sample == leg.sample and other.step < leg.step]
        ways = [self.way(r, self.stands[r], first) for first in before[:1] for r in self.robots[first.area]]
        return min(ways, default=0) + sum(map(self.work, before))

    def tail(self, leg: Leg) -> int:
        """What a sample's later legs take, at least."""
        return sum(self.work(o) for o in self.legs if o.sample == leg.sample and o.step > leg.step)

    def navigate(self, robot: str, one: str, other: str) -> GroundAction:
        return self.ground("NAVIGATE", robot, rel1="near", ref1=one, rel2="near", ref2=other)

    def dock(self, robot: str, leg: Leg) -> GroundAction:
        return self.ground("DOCK", robot, object=leg.sample, rel1="near", ref1=leg.fetch)

    def transport(self, robot: str, leg: Leg, rel: str, one: str, other: str) -> GroundAction:
        return self.ground("TRANSPORT", robot, object=leg.sample, rel1=rel, ref1=one, rel2="near", ref2=other)

    def release(self, robot: str, leg: Leg, rel: str, last: str) -> GroundAction:
        return self.ground(
            "RELEASE2", robot, object=leg.sample, rel1=rel, ref1=last, rel2="near", ref2=leg.deliver
        )

    def _way(self, goal: Fact) -> Iterator[Leg]:
        if goal.predicate != "object_position" or goal.args[1] != "in":
            raise NotModelled(f"{goal} is no goal for a sample")
        sample, _, end = goal.args
        chains = self._chains(self.lies[sample], end)
        if len(chains) != 1:
            raise NotModelled(f"{sample} has {len(chains)} shortest ways")
        for step, (area, fetch, deliver) in enumerate(chains[0]):
            yield Leg(sample=sample, step=step, area=area, fetch=fetch, deliver=deliver)

    def _chains(self, start: str, end: str) -> list[list[tuple[str, str, str]]]:
        """The shortest chains of areas from place to place: (area, from, to) each."""
        chains: list[list[tuple[str, str, str]]] = [[]]
        joints = {place for place, areas in self._areas_at.items() if len(areas) > 1}
        seen = {start}
        while chains:
            at = {(chain[-1][2] if chain else start): None for chain in chains}
            seen.update(at)
            longer = [
                [*chain, (area, place, other)]
                for chain in chains
                for place in [chain[-1][2] if chain else start]
                for area in sorted(self._areas_at[place])
                for other in sorted(joints | {end})
                if other not in seen and area in self._areas_at[other]
            ]
            done = [chain for chain in longer if chain[-1][2] == end]
            if done:
                return done
            chains = longer
        return []


def in_ms(action: GroundAction) -> int:
    return round(action.duration_s * MILLISECONDS)
