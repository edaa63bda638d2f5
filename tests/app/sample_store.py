"""The sample store as the mission logic sees it, and plan-nets for it made without a search."""

from collections.abc import Mapping, Sequence
from functools import cached_property

from app.domain.world_model import Facts, initial_facts, objects_of, planning_problem
from app.domain.world_model.senses import restricted_senses
from app.domain.world_model.vocabulary import planner_fact
from planner import Fact, KnowledgeBase, PlanNet, keep_in_step, load_knowledge_base
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from robots.wire import SymbolicFact
from robots.world import WorldFile, load_world

Step = tuple[str, Mapping[str, str]]


def said(text: str) -> SymbolicFact:
    """`in(sample_1, bay_7)` as the wire has it."""
    predicate, _, args = text.rstrip(")").partition("(")
    return SymbolicFact(predicate=predicate, args=tuple(arg.strip() for arg in args.split(",")))


class Store:
    """A world with its knowledge base and initial facts."""

    def __init__(self, world: WorldFile | None = None, base: KnowledgeBase | None = None) -> None:
        self.world = world or load_world("sample_store")
        self.base = base or load_knowledge_base()

    @cached_property
    def facts(self) -> Facts:
        return initial_facts(self.world, self.base)

    @property
    def repertoires(self) -> dict[str, tuple[str, ...]]:
        return {robot.name: tuple(robot.repertoire) for robot in self.world.robots}

    def fact(self, text: str) -> Fact:
        return planner_fact(said(text), self.base, objects_of(self.world))

    def plan(self, steps: Sequence[Step], *goals: str, facts: Facts | None = None) -> PlanNet:
        """The plan-net of a sequence of steps that is known to work, with what keeps its orderings."""
        wanted = tuple(self.fact(goal) for goal in goals)
        problem = planning_problem(self.world, self.facts if facts is None else facts, wanted)
        sequence = [
            phase
            for tag, arguments in steps
            for phase in self.base.phases_of(
                self.base.ground(tag, arguments, problem.functions, objects=problem.objects), problem.facts
            )
        ]
        plan_net = assemble(extract(sequence, problem.facts, wanted), wanted, self.base, {})
        senses = restricted_senses(self.world, self.base)
        return keep_in_step(plan_net, problem.facts, problem.objects, self.base, senses)

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

    def one_interchange_twice(self) -> PlanNet:
        """yard_1 and then yard_2 bring a sample each to interchange_1, for bays 1 and 3.

        :raises planner.InvalidPlan: unless sample_1 lies at door_1 and sample_2 at door_2.
        """
        home = {"robots": "yard_1", "rel1": "near", "ref1": "interchange_1", "rel2": "near"}
        return self.plan(
            [
                *self.carry("yard_1", "sample_1", "door_1", "interchange_1", came_from="home_yard_1"),
                *self.carry("store_1", "sample_1", "interchange_1", "bay_1", came_from="home_store_1"),
                ("NAVIGATE", {**home, "ref2": "home_yard_1", "area": "yard"}),
                *self.carry("yard_2", "sample_2", "door_2", "interchange_1", came_from="home_yard_2"),
                *self.carry("store_1", "sample_2", "interchange_1", "bay_3", came_from="bay_1"),
            ],
            "in(sample_1, bay_1)",
            "in(sample_2, bay_3)",
        )
