"""Parts of the scheduling side of the engine, put together for one problem."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner import Fact, GroundAction, KnowledgeBase, PlanningProblem, PlanningRequest
from planner.engines.hierarchical.composition import Composition
from planner.engines.hierarchical.fragments.fragment import Fragments
from planner.engines.hierarchical.legs.leg import ClassifiedProblem, Leg, legs_of
from planner.engines.hierarchical.legs.setups import AllSetups, Setups
from planner.engines.hierarchical.legs.stops import Stops
from planner.engines.hierarchical.scheduling_problem import SchedulingProblemBuilder, Task
from tests.planner.engines.hierarchical.checks import fragments_of

MAKESPAN_ONLY = np.array(((1.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 1e-4)))

Sequenced = tuple[GroundAction, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ProblemSetup:
    """A problem with its vocabulary."""

    base: KnowledgeBase
    problem: PlanningProblem
    classified: ClassifiedProblem

    @classmethod
    def of(cls, base: KnowledgeBase, problem: PlanningProblem) -> "ProblemSetup":
        return cls(base=base, problem=problem, classified=ClassifiedProblem(base, problem))

    def quickest(self, goal: Fact) -> Sequenced:
        return fragments_of(Fragments(self.base), self.problem, [goal])[0].actions

    def legs(self, *goals: Fact) -> tuple[Leg, ...]:
        return legs_of(self.quickest(goals[0]), goals, self.classified)

    def setups(self, agent: str) -> Setups:
        return AllSetups(self.classified).of_agent(agent)

    def stops(self) -> Stops:
        return Stops(classified=self.classified)

    def composition(self, fragments: Sequence[Sequence[Sequenced]], *, seed: int = 0) -> Composition:
        """Of tasks for the problem's goals, one each."""
        tasks = self._tasks(fragments)
        return Composition(self.classified, tasks, MAKESPAN_ONLY, PlanningRequest(seed=seed))

    def builder(self, fragments: Sequence[Sequence[Sequenced]]) -> SchedulingProblemBuilder:
        """The scheduling problem of the same tasks."""
        return SchedulingProblemBuilder(self.classified, self._tasks(fragments))

    def _tasks(self, fragments: Sequence[Sequence[Sequenced]]) -> list[Task]:
        return [
            Task(goals=(goal,), fragments=tuple(some))
            for goal, some in zip(self.problem.goals, fragments, strict=True)
        ]


def said(actions: Sequence[GroundAction]) -> list[tuple[str, ...]]:
    """Each action's tag, agents and the places it names, in the order of its parameters."""
    return [
        (action.tag, *action.agents, *(v for name, v in action.arguments.items() if name.startswith("ref")))
        for action in actions
    ]
