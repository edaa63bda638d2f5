"""Room for things: shared facts that are false while a thing is somewhere and that its leaving brings about."""

from collections.abc import Iterable, Iterator, Mapping

from planner.engines.hierarchical.legs.goal_groups import Group, Groups
from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.fact import Fact
from planner.knowledge import Operator
from planner.knowledge.literal import Literal


class Rooms:
    """The rooms of one problem: derived from operators that delete a fact about a thing and add one about its place,
    where others do the reverse."""

    def __init__(self, classified: ClassifiedProblem, groups: Groups) -> None:
        self._classified = classified
        self._groups = groups
        self._operators = classified.knowledge_base.operators_among(
            frozenset(classified.problem.objects.values())
        )
        self._of: dict[Fact, frozenset[Fact]] = {}

    def held(self, group: Group) -> frozenset[Fact]:
        """The rooms that the group's things take up at first."""
        return self.of_all(self._groups.place(group))

    def wanted(self, group: Group) -> frozenset[Fact]:
        """The rooms that its goals take up."""
        return self.of_all(group.goals)

    def of_all(self, facts: Iterable[Fact]) -> frozenset[Fact]:
        return frozenset(room for fact in facts for room in self.of(fact))

    def of(self, fact: Fact) -> frozenset[Fact]:
        """The rooms that are taken while the fact holds."""
        if fact not in self._of:
            classified = self._classified
            is_about_thing = not classified.things.isdisjoint(fact.args) and not classified.agents_of(fact)
            freed = self._bound(fact, frees=True) if is_about_thing else frozenset()
            self._of[fact] = freed & self._bound(fact, frees=False) if freed else freed
        return self._of[fact]

    def _bound(self, fact: Fact, *, frees: bool) -> frozenset[Fact]:
        """Facts about its place that come about with an action that ends the fact (or end with one that begins it)."""
        found: set[Fact] = set()
        for op in self._operators:
            effects = (*op.intended_effects, *op.other_effects)
            ends, begins = (op.deletes, effects) if frees else (effects, op.deletes)
            for literal in ends:
                if literal.predicate == fact.predicate:
                    binding = op.extended({}, literal.terms, fact.args)
                    if binding is not None and self._is_fit(op, binding):
                        found.update(self._about_places(op, binding, begins))
        return frozenset(found)

    def _is_fit(self, op: Operator, binding: Mapping[str, str]) -> bool:
        """True if the objects bound are of the parameters' types."""
        is_a = self._classified.knowledge_base.file.is_a
        objects = self._classified.problem.objects
        return all(
            value not in objects or is_a(objects[value], op.parameters[name])
            for name, value in binding.items()
        )

    def _about_places(
        self, op: Operator, binding: Mapping[str, str], literals: Iterable[Literal]
    ) -> Iterator[Fact]:
        """Those of the literals that are bound and name neither thing nor agent."""
        classified = self._classified
        for literal in literals:
            if literal.predicate in classified.fluents and all(
                term in binding or term not in op.parameters for term in literal.terms
            ):
                fact = literal.ground(binding)
                if classified.things.isdisjoint(fact.args) and not classified.agents_of(fact):
                    yield fact
