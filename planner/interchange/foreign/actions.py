"""One action of unified-planning's model taken apart: conditions, changes, duration, as literals and text."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from keyword import kwlist
from typing import Any

from planner.errors import Unsupported
from planner.interchange.foreign.features import unsupported_feature
from planner.interchange.pddl.names import Names
from planner.knowledge.literal import Literal

PYTHON_KEYWORDS = frozenset(kwlist)
"""Durations are read as Python reads expressions, so that no name in them may be one of these."""


@dataclass(frozen=True, slots=True)
class Condition:
    """A literal that must hold, or must not."""

    literal: Literal
    negated: bool = False


@dataclass(slots=True, kw_only=True)
class ReadAction:
    """`up_parameters` maps our parameters to unified-planning's; `constants` are the objects it names."""

    up_action: Any
    up_parameters: dict[str, Any]
    conditions: list[Condition] = field(default_factory=list)
    adds: list[Literal] = field(default_factory=list)
    deletes: list[Literal] = field(default_factory=list)
    distinct: list[tuple[str, str]] = field(default_factory=list)
    duration: str = "1"
    constants: set[str] = field(default_factory=set)


class ActionReader:
    """Reads actions of one problem, with its names for fluents and objects."""

    def __init__(self, fluents: Names, objects: Names) -> None:
        self._fluents = fluents
        self._objects = objects

    def read(self, up_action: Any, cost: Any) -> ReadAction:
        """:param cost: the action's cost as an expression, None for 1; durative actions have their duration.
        :raises Unsupported: for what is no literal, no static duration, or needs another action meanwhile.
        """
        names = Names((p.name for p in up_action.parameters), (self._objects,), reserved=PYTHON_KEYWORDS)
        read = ReadAction(up_action=up_action, up_parameters={names[p.name]: p for p in up_action.parameters})
        is_durative = hasattr(up_action, "duration")
        for expression in _conditions(up_action):
            read.conditions += self.conditions(expression, read, up_action.name)
        for at_start, effect in _effects(up_action):
            self._change(read, effect, at_start=at_start and is_durative)
        _check_concurrency(read, up_action)
        if is_durative:
            if up_action.duration.is_left_open():
                raise unsupported_feature("OPEN_DURATION_INTERVAL", f"action {up_action.name}")
            cost = up_action.duration.lower
        if cost is not None:
            read.duration = self._number(cost, read, up_action.name)
        return read

    def conditions(self, expression: Any, read: ReadAction | None, where: str) -> Iterator[Condition]:
        """The literals of a conjunction; inequalities go into `read.distinct`."""
        if expression.is_and():
            for part in expression.args:
                yield from self.conditions(part, read, where)
        elif expression.is_fluent_exp():
            yield Condition(self._literal(expression, read, where))
        elif expression.is_not() and expression.arg(0).is_fluent_exp():
            yield Condition(self._literal(expression.arg(0), read, where), negated=True)
        elif expression.is_not() and expression.arg(0).is_equals() and read is not None:
            pair = [self._term(part, read, where) for part in expression.arg(0).args]
            if not set(pair) <= read.up_parameters.keys():
                raise unsupported_feature("INEQUALITY_WITH_A_CONSTANT", f"action {where}")
            read.distinct.append((pair[0], pair[1]))
        elif not expression.is_true():
            raise unsupported_feature(_feature(expression), f"{'action ' if read else ''}{where}")

    def _literal(self, expression: Any, read: ReadAction | None, where: str) -> Literal:
        terms = tuple(self._term(part, read, where) for part in expression.args)
        return Literal(self._fluents[expression.fluent().name], terms)

    def _term(self, expression: Any, read: ReadAction | None, where: str) -> str:
        if expression.is_parameter_exp() and read is not None:
            name = expression.parameter().name
            return next(ours for ours, theirs in read.up_parameters.items() if theirs.name == name)
        if expression.is_object_exp():
            name = self._objects[expression.object().name]
            if read is not None:
                read.constants.add(name)
            return name
        raise unsupported_feature("NESTED_FLUENTS", f"{'action ' if read else ''}{where}")

    def _change(self, read: ReadAction, effect: Any, *, at_start: bool) -> None:
        where = f"action {read.up_action.name}"
        if effect.is_forall():
            raise unsupported_feature("FORALL_EFFECTS", where)
        if effect.is_conditional():
            raise unsupported_feature("CONDITIONAL_EFFECTS", where)
        if not effect.is_assignment() or not effect.value.is_bool_constant():
            raise unsupported_feature("NUMERIC_ASSIGNMENTS", where)
        literal = self._literal(effect.fluent, read, read.up_action.name)
        is_added = effect.value.bool_constant_value()
        (read.adds if is_added else read.deletes).append(literal)

    def _number(self, expression: Any, read: ReadAction, where: str) -> str:
        """The expression as the knowledge base writes durations."""
        if expression.is_int_constant() or expression.is_real_constant():
            value = Fraction(expression.constant_value())
            return (
                str(float(value)) if value.denominator == 1 else f"({value.numerator} / {value.denominator})"
            )
        signs = {"is_plus": " + ", "is_minus": " - ", "is_times": " * ", "is_div": " / "}
        for test, sign in signs.items():
            if getattr(expression, test)():
                return f"({sign.join(self._number(part, read, where) for part in expression.args)})"
        if expression.is_fluent_exp():
            literal = self._literal(expression, read, where)
            if set(literal.terms) <= read.up_parameters.keys():
                return str(literal)
            raise unsupported_feature("CONSTANTS_IN_DURATIONS", f"action {where}")
        raise unsupported_feature("NUMERIC_EXPRESSIONS", f"action {where}")


def _conditions(up_action: Any) -> Iterator[Any]:
    if hasattr(up_action, "duration"):
        for interval, expressions in up_action.conditions.items():
            if interval.lower.delay or interval.upper.delay:
                raise unsupported_feature("INTERMEDIATE_CONDITIONS_AND_EFFECTS", f"action {up_action.name}")
            yield from expressions
    else:
        yield from up_action.preconditions


def _effects(up_action: Any) -> Iterator[tuple[bool, Any]]:
    """Each effect, and whether it happens at the start."""
    if hasattr(up_action, "duration"):
        for timing, effects in up_action.effects.items():
            if timing.delay:
                raise unsupported_feature("INTERMEDIATE_CONDITIONS_AND_EFFECTS", f"action {up_action.name}")
            yield from ((timing.is_from_start(), effect) for effect in effects)
    else:
        yield from ((False, effect) for effect in up_action.effects)


def _check_concurrency(read: ReadAction, up_action: Any) -> None:
    """Refuse what holds only while the action runs: others would have to run meanwhile."""
    timed = [(start, str(e.fluent), e.value.bool_constant_value()) for start, e in _effects(up_action)]
    for start, fluent, value in timed:
        if start and value and (False, fluent, False) in timed and hasattr(up_action, "duration"):
            raise Unsupported(
                f"action {up_action.name}: {fluent} holds only while it runs, so that other actions would have to "
                "run meanwhile; plan-net actions follow each other: let it hold until a further action ends it"
            )


def _feature(expression: Any) -> str:
    """The feature's name in unified-planning."""
    if expression.is_exists():
        return "EXISTENTIAL_CONDITIONS"
    if expression.is_forall():
        return "UNIVERSAL_CONDITIONS"
    if expression.is_equals():
        return "EQUALITIES"
    if expression.is_or() or expression.is_implies() or expression.is_iff() or expression.is_not():
        return "DISJUNCTIVE_CONDITIONS"
    return "NUMERIC_CONDITIONS"
