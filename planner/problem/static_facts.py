"""The static facts of a problem by robot: what each reaches and can do."""

from collections.abc import Collection, Iterable
from dataclasses import replace
from functools import cached_property

from planner.fact import Fact
from planner.knowledge import KnowledgeBase, Operator
from planner.problem.access import peripherals_of
from planner.problem.interface import PlanningProblem


class StaticFacts:
    """The static facts of a problem, by robot (any agent, of whatever type)."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self._problem = problem
        self._base = knowledge_base
        self.objects = problem.objects.keys()
        self.facts = frozenset(fact for fact in problem.facts if fact.predicate not in knowledge_base.fluents)
        self.peripherals = peripherals_of(problem, knowledge_base)
        """Agents that others ask for by name, so that nobody can stand in for them."""
        agents = knowledge_base.agents_among(problem.objects)
        self.robots = tuple(agent for agent in agents if agent not in self.peripherals)

    @cached_property
    def things(self) -> frozenset[str]:
        """What is moved or worked on: objects other than robots that no function names, nor a static fact with others.

        A static fact about one object alone says what it is: a drill is moved, too.
        """
        placed = {arg for fact in self.facts if len(fact.args) > 1 for arg in fact.args}
        placed = placed.union(
            self.robots, self._problem.zones, *(args for _, args in self._problem.functions)
        )
        return frozenset(self._problem.objects.keys() - placed)

    @cached_property
    def setups(self) -> tuple[Operator, ...]:
        """The operators by which one agent only brings itself into another configuration, such as to another place.

        Not those for which the problem has no object, or only things.
        """
        is_a = self._base.file.is_a
        kinds = {kind for op in self._base.operators for kind in op.parameters.values()}
        bound = {
            kind: {name for name, own in self._problem.objects.items() if is_a(own, kind)} for kind in kinds
        }
        of_things_alone = {kind for kind, names in bound.items() if names <= self.things}
        return tuple(
            op
            for op in self._base.operators
            if len(op.agents) == 1
            and all(op.agents[0] in literal.terms for literal in op.intended_effects)
            and of_things_alone.isdisjoint(op.parameters.values())
        )

    def lets_drive(self, fact: Fact) -> bool:
        """True of a fact that lets an agent come into another configuration by itself."""
        return any(
            literal.predicate == fact.predicate and op.extended({}, literal.terms, fact.args) is not None
            for op in self.setups
            for literal in op.preconditions
        )

    def obstacle(self, robot: str, facts: Iterable[Fact], instead_of: str) -> Fact | None:
        """The first of the facts that is static and does not hold with `robot` in the other's place."""
        exchanged = (
            fact.renamed({instead_of: robot})
            for fact in facts
            if fact in self.facts and instead_of in fact.args
        )
        return next((fact for fact in exchanged if fact not in self.facts), None)

    def without(self, robots: Collection[str], *, driving: bool = False) -> PlanningProblem:
        """The problem with these robots kept from every action: the static facts that name them are withheld.

        :param driving: they may still come to other places by themselves, to make way.
        """
        named = (fact for fact in self.facts if not set(robots).isdisjoint(fact.args))
        withheld = {fact for fact in named if not (driving and self.lets_drive(fact))}
        return replace(self._problem, facts=self._problem.facts - withheld)

    def without_bystanders(self, problem: PlanningProblem) -> PlanningProblem:
        """The problem without bystanders: objects that no goal, static fact or function names."""
        named = {arg for goal in problem.goals for arg in goal.args}
        bystanders = self.things - named.union(*(fact.args for fact in self.facts))
        return replace(
            problem,
            objects={name: kind for name, kind in problem.objects.items() if name not in bystanders},
            facts=frozenset(fact for fact in problem.facts if bystanders.isdisjoint(fact.args)),
        )

    def for_goal(self, problem: PlanningProblem, goal: Fact, achieved: Iterable[Fact]) -> PlanningProblem:
        """The problem of one goal without bystanders that keeps those goals already achieved which it could undo."""
        small = self.without_bystanders(replace(problem, goals=(goal,)))
        bystanders = problem.objects.keys() - small.objects.keys()
        kept = tuple(fact for fact in achieved if bystanders.isdisjoint(fact.args))
        return replace(small, goals=(*kept, goal))
