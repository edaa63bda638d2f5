"""A knowledge base as a PDDL domain: exact, readable, the same text each time.

Temporal (PDDL 2.1, level 3): durative actions with the plan-net's semantics. A condition is asked for at the
start and over all, at the start only if the action deletes it or nothing does; deletes happen at the start,
effects at the end; an agent is `idle` between actions. An action with times within it is a durative action for each of
its phases, chained by `under_way_…`. Durations are expressions over the problem's functions.
Numeric: the same with the numbers that plans keep within limits (`numbers`).
Classical: instantaneous actions whose costs are durations in tenths of a second, in whole numbers.

In both an operator's parameters of one type differ, functions are asked for only where they have a value, and
goals count only if intended effects bring them about: `intended_…` twins say so (MACTA §5, table 3).
"""

import ast
from collections.abc import Iterable, Iterator, Mapping

from planner.interchange.pddl import levels, numbers
from planner.interchange.pddl.vocabulary import Vocabulary
from planner.knowledge import Operator, Phase
from planner.knowledge.literal import Literal

_SIGNS: Mapping[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


def domain_text(words: Vocabulary) -> str:
    """The knowledge base of the words as a PDDL domain."""
    features = ":durative-actions :fluents" if words.is_temporal else ":action-costs"
    if any(levels.level_types(words)):
        features += " :duration-inequalities"
    action = _durative if words.is_temporal else _instant
    sections = [
        "(define (domain macta)",
        f"  (:requirements :typing :equality :negative-preconditions {features})",
        section("types", _types(words)),
        section(
            "constants",
            [
                *(f"{words.objects[c]} - {words.types[k]}" for c, k in sorted(words.base.constants.items())),
                *levels.level_constants(words),
            ],
        ),
        section("predicates", _predicates(words)),
        section("functions", _functions(words)),
        *(action(op, words) for op in words.steps),
    ]
    return "\n\n".join(filter(None, sections)) + "\n)\n"


def section(name: str, lines: Iterable[str]) -> str:
    """`(:name …)` with a line each; nothing without lines."""
    body = "\n".join(f"    {line}" for line in lines)
    return f"  (:{name}\n{body}\n  )" if body else ""


def _types(words: Vocabulary) -> Iterator[str]:
    for name, spec in words.base.file.types.items():
        yield f"{words.types[name]} - {words.types[spec.parent] if spec.parent else 'object'}"
    yield from levels.level_types(words)


def _predicates(words: Vocabulary) -> Iterator[str]:
    base = words.base
    for name, spec in base.predicates.items():
        yield words.declared(words.word(name), spec.arguments)
        if name in words.twins:
            yield words.declared(words.word(name, "intended"), spec.arguments)
    if words.is_temporal and not words.is_simplified:
        for name, kinds in base.file.functions.items():
            if kinds:
                yield words.declared(words.word(name, "defined"), _numbered(kinds))
        for kind in words.agent_types():
            yield words.declared(words.word(kind, "idle"), {"agent": kind})
    for op in filter(words.is_tabled, words.steps):
        yield words.declared(words.word(op.name, "defined"), words.measured(op))
    yield from numbers.number_predicates(words)


def _functions(words: Vocabulary) -> Iterator[str]:
    if words.is_temporal and not words.is_simplified:
        for name, kinds in words.base.file.functions.items():
            yield words.declared(words.word(name), _numbered(kinds))
    elif not words.is_temporal:
        yield "(total-cost)"
    for op in words.steps:
        yield words.declared(words.measure(op), words.measured(op))
    yield from numbers.number_functions(words)


def _numbered(kinds: tuple[str, ...]) -> dict[str, str]:
    return {f"x{number}": kind for number, kind in enumerate(kinds, start=1)}


def _durative(op: Operator, words: Vocabulary) -> str:
    idle = [words.idle(agent, op) for agent in op.agents if not words.is_simplified]
    begins = idle if not isinstance(op, Phase) or op.number == 1 else []
    ends = idle if not isinstance(op, Phase) or op.number == op.count else []
    needs = [words.literal(need, op) for need in op.preconditions]
    lasting = [words.literal(need, op) for need in op.preconditions if _can_cease(need, op, words)]
    deletes, adds = _changes(op, words)
    at_start = [*begins, *_different(op), *words.guards(op), *needs]
    conditions = [f"(at start {atom})" for atom in at_start] + [f"(over all {atom})" for atom in lasting]
    conditions += numbers.number_conditions(op, words)
    changes = [f"(at start (not {atom}))" for atom in [*begins, *deletes]]
    changes += [f"(at end {atom})" for atom in [*adds, *ends]]
    changes += numbers.number_effects(op, words)
    duration = numbers.aimed_duration(op, words) or f"(= ?duration {_duration(op, words)})"
    slots = {"duration": duration, "condition": _all(conditions)}
    return _action("durative-action", op, words, {**slots, "effect": _all(changes)})


def _can_cease(need: Literal, op: Operator, words: Vocabulary) -> bool:
    """True if another action could end what this one needs all along."""
    return need not in op.deletes and need.predicate in words.base.fluents


def _instant(op: Operator, words: Vocabulary) -> str:
    needs = [words.literal(need, op) for need in op.preconditions]
    deletes, adds = _changes(op, words)
    changes = [f"(not {atom})" for atom in deletes if atom not in adds] + adds
    changes.append(f"(increase (total-cost) {words.atom(words.measure(op), words.measured(op), op)})")
    slots = {"precondition": _all([*_different(op), *words.guards(op), *needs]), "effect": _all(changes)}
    return _action("action", op, words, slots)


def _action(kind: str, op: Operator, words: Vocabulary, slots: Mapping[str, str]) -> str:
    own = [f"?{name} - {words.types[type_]}" for name, type_ in op.parameters.items()]
    parameters = " ".join([*own, *levels.aimed_parameters(op, words)])
    lines = [f"  (:{kind} {words.operators[op.name]}", f"    :parameters ({parameters})"]
    return "\n".join([*lines, *(f"    :{slot} {text}" for slot, text in slots.items()), "  )"])


def _changes(op: Operator, words: Vocabulary) -> tuple[list[str], list[str]]:
    """What the operator deletes and adds, twins among them."""
    deletes = [words.literal(literal, op) for literal in op.deletes]
    deletes += [words.twin(literal, op) for literal in op.deletes if literal.predicate in words.twins]
    adds = [words.literal(literal, op) for literal in dict.fromkeys(op.intended_effects + op.other_effects)]
    adds += [words.twin(literal, op) for literal in op.intended_effects if literal.predicate in words.twins]
    return deletes, adds


def _different(op: Operator) -> list[str]:
    return [f"(not (= ?{one} ?{other}))" for one, other in op.distinct]


def _all(parts: Iterable[str]) -> str:
    return "\n      ".join(["(and", *parts]) + ")"


def _duration(op: Operator, words: Vocabulary) -> str:
    measure = words.atom(words.measure(op), words.measured(op), op)
    if words.is_tabled(op):
        return measure
    return f"(* {measure} {_expression(op.duration.tree, op, words)})"


def _expression(tree: ast.expr, op: Operator, words: Vocabulary) -> str:
    """The duration's arithmetic in prefix form."""
    match tree:
        case ast.Constant(value=int() | float() as value):
            return str(value)
        case ast.BinOp(left=left, op=sign, right=right):
            operands = f"{_expression(left, op, words)} {_expression(right, op, words)}"
            return f"({_SIGNS[type(sign)]} {operands})"
        case ast.Call(func=ast.Name(id=name), args=arguments):
            terms = [argument.id for argument in arguments if isinstance(argument, ast.Name)]
            return words.atom(words.word(name), [op.members[0].get(term, term) for term in terms], op)
    raise AssertionError(ast.dump(tree))
