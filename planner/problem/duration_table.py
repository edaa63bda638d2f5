"""An operator's durations as a table over objects, for planners without arithmetic."""

from collections.abc import Iterator

from planner.knowledge import KnowledgeBase, Operator
from planner.problem.interface import PlanningProblem

Row = tuple[str, ...]


def duration_parameters(op: Operator) -> tuple[str, ...]:
    """The operator's parameters its duration depends on, teams spelt out."""
    used: dict[str, None] = {}
    for _, terms in op.duration.calls:
        for term in terms:
            used |= dict.fromkeys(op.teams.get(term, (term,)))
    return tuple(used)


def duration_table(
    op: Operator, problem: PlanningProblem, base: KnowledgeBase
) -> Iterator[tuple[Row, float]]:
    """The values of the duration's parameters for which it is defined and the statics hold, with its seconds.

    A join over the functions' tables and the static pre-conditions, so that it grows with what is connected.
    """
    used = duration_parameters(op)
    distinct = [pair for pair in op.distinct if set(pair) <= set(used)]
    for binding in _bindings(op, problem, base):
        seconds = op.duration_s(binding, problem.functions)
        if seconds is not None and all(binding[one] != binding[other] for one, other in distinct):
            yield tuple(binding[name] for name in used), seconds


def _bindings(op: Operator, problem: PlanningProblem, base: KnowledgeBase) -> list[dict[str, str]]:
    tables: list[tuple[Row, set[Row]]] = []
    for name, terms in op.duration.calls:
        rows = {args for (function, args) in problem.functions if function == name}
        tables += [(tuple(member.get(term, term) for term in terms), rows) for member in op.members]
    used = set(duration_parameters(op))
    for literal in op.preconditions:
        if literal.predicate not in base.fluents and used.issuperset(set(literal.terms) & set(op.parameters)):
            rows = {fact.args for fact in problem.facts if fact.predicate == literal.predicate}
            tables.append((literal.terms, rows))
    bindings: list[dict[str, str]] = [{}]
    for terms, rows in sorted(tables, key=lambda table: len(table[1])):
        bindings = [
            joined
            for binding in bindings
            for row in sorted(rows)
            if (joined := op.extended(binding, terms, row)) is not None
        ]
    return bindings
