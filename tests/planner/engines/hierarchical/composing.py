"""Parts of the scheduling side of the engine, put together for one problem."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner import Fact, GroundAction, KnowledgeBase, PlanningProblem
from planner.engines.hierarchical.composition import Composition
from planner.engines.hierarchical.fragments.fragment import Fragments
from planner.engines.hierarchical.legs.leg import FactClassifier, Leg, legs_of
from planner.engines.hierarchical.legs.setups import FactTable, Setups
from planner.engines.hierarchical.legs.stops import Stops
from planner.engines.hierarchical.scheduling_problem import SchedulingProblemBuilder, Task
from planner.problem.robot_classes import AgentClasses
from tests.planner.engines.hierarchical.checks import fragments_of

MAKESPAN_ONLY = np.array((1.0, 0.0, 0.0, 0.0, 1e-4))

Sequenced = tuple[GroundAction, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ProblemSetup:
    """A problem with its vocabulary."""

    base: KnowledgeBase
    problem: PlanningProblem
    classes: AgentClasses
    classifier: FactClassifier

    @classmethod
    def of(cls, base: KnowledgeBase, problem: PlanningProblem) -> "ProblemSetup":
        classes = AgentClasses(base, problem)
        return cls(
            base=base, problem=problem, classes=classes, classifier=FactClassifier(base, problem, classes)
        )

    def quickest(self, goal: Fact) -> Sequenced:
        return fragments_of(Fragments(self.base), self.problem, [goal])[0].actions

    def legs(self, *goals: Fact) -> tuple[Leg, ...]:
        return legs_of(self.quickest(goals[0]), goals, self.problem.facts, self.classifier)

    def setups(self, agent: str) -> Setups:
        statics = FactTable(fact for fact in self.problem.facts if not self.classifier.is_fluent(fact))
        return Setups(self.base, self.problem, self.classifier, statics, agent)

    def stops(self) -> Stops:
        return Stops(
            knowledge_base=self.base, problem=self.problem, classes=self.classes, classifier=self.classifier
        )

    def composition(self, fragments: Sequence[Sequence[Sequenced]], *, seed: int = 0) -> Composition:
        """Of tasks for the problem's goals, one each."""
        tasks = self._tasks(fragments)
        return Composition(
            self.base, self.problem, self.classes, self.classifier, tasks, MAKESPAN_ONLY, seed=seed
        )

    def builder(self, fragments: Sequence[Sequence[Sequenced]]) -> SchedulingProblemBuilder:
        """The scheduling problem of the same tasks."""
        tasks = self._tasks(fragments)
        return SchedulingProblemBuilder(self.base, self.problem, self.classes, self.classifier, tasks)

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
