"""The numbers that plans keep within limits, as numeric fluents of PDDL (2.1, level 3), for the form `NUMERIC`.

What lowers a number does so at the action's start, what raises it at its end; limits are asked for before and after
the change, so that they hold at the same points as in the course of a number (`planner.problem.number_courses`). How
much an action changes a number is a table over its parameters. An action that is there for a number brings it `to` a
level (`planner.interchange.pddl.levels`).

A number that is not known is stated at the worst that plans let it have, and nothing lowers it. One that is outside of
what is kept from the start is only asked to stay in its range (`least_battery`) until it is brought back, by actions
that bring about what the actions that are there for it need (NAVIGATE).

Not expressed: what waiting drains, as PDDL has no change between actions; and that an action which is there for a
number lasts for its `duration` at least.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from planner.interchange.pddl.levels import (
    AIM,
    aim_of,
    aim_parameter,
    has_levels,
    kept_quantities,
    level_object,
    level_type,
    levels,
)
from planner.interchange.pddl.vocabulary import Vocabulary
from planner.knowledge import GroundAction, Operator, Phase
from planner.knowledge.comparison import Term
from planner.knowledge.literal import Literal
from planner.knowledge.schema import QuantitySpec
from planner.problem.duration_table import duration_parameters, duration_table
from planner.problem.interface import PlanningProblem
from planner.problem.number_courses import ROUNDING, excess_of

LARGE = 1_000_000
"""Stands for no limit, of numbers and of seconds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """One side of what plans keep: the number is `sign` `kept`, and while it is excused `sign` `possible`."""

    word: str
    sign: str
    kept: float
    possible: float


def number_predicates(words: Vocabulary) -> Iterator[str]:
    """The predicates that say for which objects an action that is there for a number changes it."""
    for op in words.steps:
        if (aim := aim_of(op, words)) is not None:
            yield words.declared(words.word(op.name, f"has_{aim[0]}_rate"), _typed(op))


def number_functions(words: Vocabulary) -> Iterator[str]:
    """The numbers, their limits and levels, and the tables of how actions change them."""
    for quantity, spec in kept_quantities(words).items():
        yield words.declared(words.word(quantity), spec.arguments)
        if has_levels(quantity, words):
            for limit in _limits(spec):
                yield words.declared(words.word(quantity, limit.word), spec.arguments)
            yield f"({words.word(quantity, 'level')} ?{AIM} - {level_type(quantity, words)})"
    for op in words.steps:
        for number, _ in enumerate(changed_terms(op, words)):
            yield words.declared(_table(op, number, words), _typed(op))


def number_conditions(op: Operator, words: Vocabulary) -> Iterator[str]:
    """That the numbers which the operator changes are kept, before and after."""
    aim = aim_of(op, words)
    for number, term in enumerate(changed_terms(op, words)):
        now = words.atom(words.word(term[0]), term[1], op)
        amount = words.atom(_table(op, number, words), _typed(op), op)
        yield from (f"(at start {one})" for one in _bounds(now, term, op, words))
        if term == aim and op.until is not None:
            level = f"({words.word(term[0], 'level')} {aim_parameter(op)})"
            yield f"(at start ({op.until[0].sign} {level} {_written(op.until[0].number)}))"
            yield f"(at start {words.atom(words.word(op.name, f'has_{term[0]}_rate'), _typed(op), op)})"
        elif _is_raised(op, term):
            yield from (f"(at end {one})" for one in _bounds(f"(+ {now} {amount})", term, op, words))
        else:
            yield from (f"(over all {one})" for one in _bounds(now, term, op, words))


def number_effects(op: Operator, words: Vocabulary) -> Iterator[str]:
    """The operator's changes of numbers."""
    aim = aim_of(op, words)
    for number, term in enumerate(changed_terms(op, words)):
        quantity, terms = term
        now = words.atom(words.word(quantity), terms, op)
        amount = words.atom(_table(op, number, words), _typed(op), op)
        if term == aim:
            yield f"(at end (assign {now} ({words.word(quantity, 'level')} {aim_parameter(op)})))"
            for limit in _limits(words.base.quantities[quantity]):
                restored = words.atom(words.word(quantity, limit.word), terms, op)
                yield f"(at end (assign {restored} {_written(limit.kept)}))"
        elif _is_raised(op, term):
            yield f"(at end (increase {now} {amount}))"
        else:
            yield f"(at start (decrease {now} {amount}))"


def aimed_duration(op: Operator, words: Vocabulary) -> str | None:
    """How long an operator lasts that is there for a number; None for any other."""
    aim = aim_of(op, words)
    if aim is None:
        return None
    rate = words.atom(_table(op, changed_terms(op, words).index(aim), words), _typed(op), op)
    left = f"(- ({words.word(aim[0], 'level')} {aim_parameter(op)}) {words.atom(words.word(aim[0]), aim[1], op)})"
    return f"(and (>= ?duration (/ {left} {rate})) (<= ?duration {LARGE}))"


def initial_numbers(words: Vocabulary, problem: PlanningProblem) -> Iterator[str]:
    """The numbers' values and limits, the levels', and the tables."""
    for quantity, spec in kept_quantities(words).items():
        is_aimed = has_levels(quantity, words)
        for args in product(*(_objects(kind, words, problem) for kind in spec.arguments.values())):
            value = problem.numbers.get((quantity, args))
            value = _worst(quantity, words) if value is None else value
            yield f"(= {words.atom(words.word(quantity), args)} {_written(value)})"
            for limit in _limits(spec) if is_aimed else ():
                least = limit.kept if excess_of(value, spec.kept) <= ROUNDING else limit.possible
                yield f"(= {words.atom(words.word(quantity, limit.word), args)} {_written(least)})"
        for level in levels(quantity, words):
            named = level_object(quantity, level, words)
            yield f"(= ({words.word(quantity, 'level')} {named}) {_written(level)})"
    for op in words.steps:
        if changed_terms(op, words):
            yield from _tables(op, words, problem)


def changed_terms(op: Operator, words: Vocabulary) -> list[Term]:
    """The numbers that an operator changes, by the names of its parameters."""
    is_a = words.base.file.is_a
    found: dict[Term, None] = {}
    for quantity, spec in kept_quantities(words).items():
        if spec.used != "0":
            (kind,) = spec.arguments.values()
            agents = (agent for agent in op.agents if is_a(op.parameters[agent], kind))
            found |= {(quantity, (agent,)): None for agent in agents}
        for change in _whole(op).changes:
            if change.quantity == quantity:
                names = ({**op.chosen, **member} for member in op.members)
                found |= {(quantity, tuple(own.get(t, t) for t in change.terms)): None for own in names}
    return list(found)


def _tables(op: Operator, words: Vocabulary, problem: PlanningProblem) -> Iterator[str]:
    """By how much an operator changes numbers, or an action that is there for one does in a second."""
    aim, terms, names = aim_of(op, words), changed_terms(op, words), tuple(_typed(op))
    tables = [_table(op, number, words) for number, _ in enumerate(terms)]
    for row, action in _actions(op, words, problem):
        binding = dict(zip(names, row, strict=True))
        changed = words.base.changed_numbers(action, problem.functions)
        for table, term in zip(tables, terms, strict=True):
            key = term[0], tuple(binding.get(name, name) for name in term[1])
            amount = changed.get(key, 0.0)
            if term == aim:
                amount = amount / action.duration_s if action.duration_s else 0.0
                if not amount:
                    continue
                yield words.atom(words.word(op.name, f"has_{term[0]}_rate"), row)
            elif key not in problem.numbers:
                amount = 0.0
            elif not _is_raised(op, term):
                amount = -amount
            yield f"(= {words.atom(table, row)} {_written(amount)})"


def _actions(
    op: Operator, words: Vocabulary, problem: PlanningProblem
) -> Iterator[tuple[tuple[str, ...], GroundAction]]:
    """The operator's ground actions by the values of what their changes depend on; the other parameters stay open."""
    names = tuple(_typed(op))
    open_names = {name: name for name in op.parameters}
    distinct = [pair for pair in op.distinct if set(pair) <= set(names)]
    for timed, _ in duration_table(op, problem, words.base):
        told = dict(zip(duration_parameters(op), timed, strict=True))
        choices = [
            [told[name]] if name in told else _objects(op.parameters[name], words, problem) for name in names
        ]
        for row in product(*choices):
            binding = {**open_names, **dict(zip(names, row, strict=True))}
            action = op.ground(binding, problem.functions)
            if action is not None and all(binding[one] != binding[other] for one, other in distinct):
                yield row, action


def _typed(op: Operator) -> dict[str, str]:
    """The parameters that the operator's changes of numbers depend on, teams spelt out, with their types."""
    used = dict.fromkeys((*duration_parameters(op), *op.agents))
    named = [terms for one in (op.distance, op.energy) for _, terms in one.calls]
    for change in _whole(op).changes:
        named += [change.terms, *(terms for _, terms in change.amount.calls)]
    for term in (term for terms in named for term in terms):
        used |= dict.fromkeys(op.teams.get(term, (term,)))
    return {name: op.parameters[name] for name in used if name in op.parameters}


def _bounds(value: str, term: Term, op: Operator, words: Vocabulary) -> Iterator[str]:
    """That a value is within what is kept, or within what is possible if the term's number is excused."""
    for limit in _limits(words.base.quantities[term[0]]):
        excused = words.atom(words.word(term[0], limit.word), term[1], op)
        yield f"({limit.sign} {value} {excused if _is_way(op, term[0], words) else _written(limit.kept)})"


def _is_way(op: Operator, quantity: str, words: Vocabulary) -> bool:
    """True of actions that are there for the quantity, and of those that bring about what these need."""
    aimed = [one for one in words.steps if (aim := aim_of(one, words)) is not None and aim[0] == quantity]
    fluents = words.base.fluents
    return op in aimed or any(
        need.predicate in fluents and _may_be(effect, op, need, one)
        for one in aimed
        for need in one.preconditions
        for effect in _whole(op).intended_effects
    )


def _may_be(literal: Literal, op: Operator, other: Literal, of: Operator) -> bool:
    """Whether two operators' literals may be of one fact."""
    return literal.predicate == other.predicate and all(
        mine == theirs or mine in op.parameters or theirs in of.parameters
        for mine, theirs in zip(literal.terms, other.terms, strict=True)
    )


def _is_raised(op: Operator, term: Term) -> bool:
    return any(change.sign > 0 and change.quantity == term[0] for change in _whole(op).changes)


def _whole(op: Operator) -> Operator:
    return op.whole if isinstance(op, Phase) else op


def _limits(spec: QuantitySpec) -> Iterator[Limit]:
    (least, most), (lowest, highest) = spec.kept, spec.range
    if least is not None:
        possible = -LARGE if lowest is None else lowest
        yield Limit(word="least", sign=">=", kept=least, possible=possible)
    if most is not None:
        possible = LARGE if highest is None else highest
        yield Limit(word="most", sign="<=", kept=most, possible=possible)


def _worst(quantity: str, words: Vocabulary) -> float:
    """What is taken for a number that is not known: the worst that plans let it have."""
    return next(limit.kept for limit in _limits(words.base.quantities[quantity]))


def _table(op: Operator, number: int, words: Vocabulary) -> str:
    """The function that says by how much an operator changes the number of that place in `changed_terms`."""
    terms = changed_terms(op, words)
    quantity = terms[number][0]
    alike = [term for term in terms if term[0] == quantity]
    place = f"_{alike.index(terms[number]) + 1}" if len(alike) > 1 else ""
    kind = "rate" if terms[number] == aim_of(op, words) else "change"
    return words.word(op.name, f"{quantity}_{kind}{place}")


def _objects(kind: str, words: Vocabulary, problem: PlanningProblem) -> list[str]:
    known = {**words.base.constants, **problem.objects}
    return [name for name, own in sorted(known.items()) if words.base.file.is_a(own, kind)]


def _written(value: float) -> str:
    """As a decimal: PDDL readers may not accept an exponent."""
    return f"{value + 0.0:.12f}".rstrip("0").rstrip(".")
