"""What the facts that no action changes say about robots: who reaches what, who can do what, who is like
whom."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from planner.engine import PlanningProblem
from planner.fact import Fact
from planner.knowledge import KnowledgeBase

ROBOT = "robot"


@dataclass(frozen=True, slots=True, kw_only=True)
class Restriction:
    """Robots left out, and places kept from robots, so that the scripts' orders of events become safe."""

    without: frozenset[str] = frozenset()
    kept_from: frozenset[tuple[str, str]] = frozenset()

    def __str__(self) -> str:
        parts = [f"without {robot}" for robot in sorted(self.without)]
        return ", ".join(parts + [f"{robot} not at {place}" for robot, place in sorted(self.kept_from)])


class Statics:
    """The static facts of a problem, by robot."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self._problem = problem
        self.facts = frozenset(fact for fact in problem.facts if fact.predicate not in knowledge_base.fluents)
        self.robots = tuple(
            name for name, kind in sorted(problem.objects.items()) if knowledge_base.file.is_a(kind, ROBOT)
        )
        self._related: Mapping[str, frozenset[str]] = {
            robot: frozenset(
                arg for fact in self.facts if robot in fact.args for arg in fact.args if arg != robot
            )
            for robot in self.robots
        }

    def related(self, robot: str) -> frozenset[str]:
        """Everything some static fact names together with the robot: places, tags, its area."""
        return self._related.get(robot, frozenset())

    def holds_for(self, robot: str, facts: Iterable[Fact], instead_of: str) -> bool:
        """True if the static ones among the facts also hold with `robot` in the other's place."""
        exchanged = (
            Fact(fact.predicate, tuple(robot if arg == instead_of else arg for arg in fact.args))
            for fact in facts
            if fact in self.facts and instead_of in fact.args
        )
        return all(fact in self.facts for fact in exchanged)

    def restricted(self, restriction: Restriction) -> PlanningProblem:
        """The problem without the static facts the restriction forbids."""
        gone = {
            fact
            for fact in self.facts
            if restriction.without & set(fact.args)
            or any(robot in fact.args and place in fact.args for robot, place in restriction.kept_from)
        }
        return replace(self._problem, facts=self._problem.facts - gone)

    def lean(self, problem: PlanningProblem) -> PlanningProblem:
        """The problem without bystanders: objects that no goal, static fact or function names."""
        named = {arg for fact in (*self.facts, *problem.goals) for arg in fact.args}
        named |= {arg for _, args in problem.functions for arg in args}
        bystanders = problem.objects.keys() - named - set(self.robots)
        return replace(
            problem,
            objects={name: kind for name, kind in problem.objects.items() if name not in bystanders},
            facts=frozenset(fact for fact in problem.facts if bystanders.isdisjoint(fact.args)),
        )

    def lean_for(self, problem: PlanningProblem, goal: Fact, achieved: Iterable[Fact]) -> PlanningProblem:
        """The lean problem of one goal that keeps those goals already achieved which it could undo."""
        lean = self.lean(replace(problem, goals=(goal,)))
        bystanders = problem.objects.keys() - lean.objects.keys()
        kept = tuple(fact for fact in achieved if bystanders.isdisjoint(fact.args))
        return replace(lean, goals=(*kept, goal))

    def peers(self, robots: Iterable[str], place: str) -> tuple[str, str] | None:
        """The two of the robots that are most alike among those that have to do with the place."""
        there = sorted(robot for robot in robots if place in self.related(robot))
        pairs = [(one, other) for i, one in enumerate(there) for other in there[i + 1 :]]
        return max(pairs, key=lambda pair: len(self.related(pair[0]) & self.related(pair[1])), default=None)
