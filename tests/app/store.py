"""The sample store as the mission logic sees it, and plan-nets for it made without a search."""

from collections.abc import Mapping, Sequence
from functools import cached_property

from app.vocabulary import planner_fact
from app.world_model import Facts, initial_facts, objects_of, planning_problem
from planner import Fact, KnowledgeBase, PlanNet, load_knowledge_base
from planner.assembly import assemble
from planner.extraction import extract
from robots.wire import SymbolicFact
from robots.world import WorldFile, load_world

Step = tuple[str, Mapping[str, str]]


def said(text: str) -> SymbolicFact:
    """`in(sample_1, bay_7)` as the wire has it."""
    predicate, _, args = text.rstrip(")").partition("(")
    return SymbolicFact(predicate=predicate, args=tuple(arg.strip() for arg in args.split(",")))


class Store:
    """A world with its knowledge base and initial facts."""

    def __init__(self, world: WorldFile | None = None) -> None:
        self.world = world or load_world("sample_store")

    @cached_property
    def base(self) -> KnowledgeBase:
        return load_knowledge_base()

    @cached_property
    def facts(self) -> Facts:
        return initial_facts(self.world, self.base)

    @property
    def repertoires(self) -> dict[str, tuple[str, ...]]:
        return {robot.name: tuple(robot.repertoire) for robot in self.world.robots}

    def fact(self, text: str) -> Fact:
        return planner_fact(said(text), self.base, objects_of(self.world))

    def plan(self, steps: Sequence[Step], *goals: str, facts: Facts | None = None) -> PlanNet:
        """The plan-net of a sequence of steps that is known to work."""
        wanted = tuple(self.fact(goal) for goal in goals)
        problem = planning_problem(self.world, self.facts if facts is None else facts, wanted)
        sequence = [
            self.base.ground(tag, arguments, problem.functions, objects=problem.objects)
            for tag, arguments in steps
        ]
        return assemble(extract(sequence, problem.facts, wanted), wanted, self.base, {})

    def carry(
        self, robot: str, sample: str, start: str, end: str, *, came_from: str | None = None
    ) -> list[Step]:
        """A robot fetches a sample and puts it down elsewhere; `came_from`: where it stands if not there."""
        spec = self.world.robot(robot)
        area = self.world.area_of(spec).name
        one = {"object": sample, "robots": robot}
        leg = {"rel1": "at", "ref1": start, "rel2": "near", "ref2": end}
        way = {"robots": robot, "rel1": "near", "rel2": "near", "ref2": start, "area": area}
        steps: list[Step] = [] if came_from is None else [("NAVIGATE", {**way, "ref1": came_from})]
        return [
            *steps,
            ("DOCK", {**one, "rel1": "near", "ref1": start}),
            ("TRANSPORT", {**one, **leg, "area": area}),
            ("RELEASE2", {**one, **leg}),
        ]

    def store_sample_1(self) -> PlanNet:
        """The main job: sample_1 from door_1 to bay_7, over interchange_2."""
        return self.plan(
            [
                *self.carry("yard_1", "sample_1", "door_1", "interchange_2", came_from="home_yard_1"),
                *self.carry("store_2", "sample_1", "interchange_2", "bay_7", came_from="home_store_2"),
            ],
            "in(sample_1, bay_7)",
        )
