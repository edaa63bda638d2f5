"""Zones for one agent at a time as operators state them, for readers that ground actions themselves.

Each operator that takes one agent from a place to another becomes one for each kind of way that the problem has: free
of zones, into this one, through that one. A static fact says of what kind the way between two places is. Operators that
take several agents along have free ways only.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from planner.fact import Fact
from planner.knowledge import KnowledgeBase, Operator
from planner.knowledge.literal import Literal
from planner.knowledge.schema import KnowledgeBaseFile, PredicateSpec
from planner.problem.interface import Crossing, PlanningProblem

Kind = tuple[Crossing, ...]
Way = tuple[str, str]
FREE: Kind = ()


class StatedZones:
    """A knowledge base and a problem with their zones in operators and facts; as they are if there are none.

    `original`: the operator that each was made of, by name.
    """

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self.knowledge_base = knowledge_base
        self.problem = problem
        self.original: Mapping[str, Operator] = {op.name: op for op in knowledge_base.operators}
        if problem.crossings and knowledge_base.held:
            self._state_zones()

    def _state_zones(self) -> None:
        base = self.knowledge_base
        problem = self.problem
        ((clear, position), *_) = base.held.items()
        kinds = list(dict.fromkeys([FREE, *(problem.crossings[way] for way in sorted(problem.crossings))]))
        predicates = {kind: f"way_{number}" for number, kind in enumerate(kinds)}
        variants = [
            (variant, op)
            for op in base.operators
            for variant in _variants(op, clear=clear, position=position, predicates=predicates)
        ]
        zones = {name: problem.objects[name] for name in sorted(problem.zones)}
        place = list(base.predicates[position].arguments.values())[-1]
        named = {
            name: PredicateSpec(arguments={"start": place, "end": place}) for name in predicates.values()
        }
        self.knowledge_base = _WithOperators(
            _with_zones(base.file, zones, named), tuple([variant for variant, _ in variants])
        )
        self.original = {variant.name: op for variant, op in variants}
        places = {name for name, kind in problem.objects.items() if base.file.is_a(kind, place)}
        named_together = {args for _, args in problem.functions if len(args) == 2} | problem.crossings.keys()
        ways = (
            Fact(predicates[problem.crossings.get(way, FREE)], way)
            for way in sorted(named_together)
            if places.issuperset(way)
        )
        self.problem = replace(
            problem,
            objects={name: kind for name, kind in problem.objects.items() if name not in zones},
            facts=problem.facts.union(ways),
            crossings={},
        )


class _WithOperators(KnowledgeBase):
    """A knowledge base with other operators than its actions'."""

    def __init__(self, file: KnowledgeBaseFile, operators: tuple[Operator, ...]) -> None:
        super().__init__(file)
        self.operators = operators


def _with_zones(
    file: KnowledgeBaseFile, zones: Mapping[str, str], predicates: Mapping[str, PredicateSpec]
) -> KnowledgeBaseFile:
    """The file with the zones as constants, for operators name them."""
    types = dict(file.types)
    for name, kind in zones.items():
        types[kind] = types[kind].model_copy(update={"values": (*types[kind].values, name)})
    return file.model_copy(update={"types": types, "predicates": {**file.predicates, **predicates}})


def _variants(
    op: Operator, *, clear: str, position: str, predicates: Mapping[Kind, str]
) -> Iterator[Operator]:
    """The operator for each kind of way; itself if it takes nobody from one place to another."""
    ways = dict.fromkeys(_ways(op, position))
    moved = {agent for agent, _ in ways}
    if not moved:
        yield op
        return
    for number, (kind, predicate) in enumerate(predicates.items()):
        if kind != FREE and len(moved) > 1:
            continue
        entered = tuple(Literal(clear, (one.zone,)) for one in kind if one.enters)
        left = tuple(Literal(clear, (one.zone,)) for one in kind if one.leaves)
        along = tuple(Literal(predicate, way) for way in dict.fromkeys(way for _, way in ways))
        yield replace(
            op,
            name=f"{op.name}_way_{number}",
            preconditions=(*op.preconditions, *along, *entered),
            deletes=(*op.deletes, *entered),
            other_effects=(*op.other_effects, *left),
        )


def _ways(op: Operator, position: str) -> Iterator[tuple[str, Way]]:
    """The agents that the operator moves, and from where to where."""
    after = {one.terms[0]: one.terms[-1] for one in _effects(op) if one.predicate == position}
    for literal in op.deletes:
        agent = literal.terms[0]
        start = literal.terms[-1]
        if literal.predicate == position and agent in op.agents and after.get(agent, start) != start:
            yield agent, (start, after[agent])


def _effects(op: Operator) -> tuple[Literal, ...]:
    return (*op.intended_effects, *op.other_effects)
