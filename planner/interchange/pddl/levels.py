"""What actions that are there for a number bring it to, as constants of the form `NUMERIC`: `battery_0_9`.

PDDL's readers know no change by `?duration`, and PDDL no limit at which a change stops. So such an action has a level
as a parameter beside its own, and lasts at least for as long as the way to it takes.
"""

from collections.abc import Iterator
from math import floor

from planner.interchange.pddl.vocabulary import Vocabulary
from planner.knowledge import Operator
from planner.knowledge.comparison import Comparison, Term, number_words
from planner.knowledge.schema import QuantitySpec
from planner.problem.number_courses import ROUNDING

STEP = 0.001
"""How far levels lie apart, as a share of the quantity's span (our choice)."""
AIM = "to"
"""The parameter that says to which level an action brings a number."""


def kept_quantities(words: Vocabulary) -> dict[str, QuantitySpec]:
    """By name, the quantities that are written."""
    if not words.has_numbers:
        return {}
    return {name: spec for name, spec in words.base.quantities.items() if spec.is_kept}


def aim_of(op: Operator, words: Vocabulary) -> Term | None:
    """The number that the operator is there for, by the names of its parameters."""
    if op.until is None or op.until[0].quantity not in kept_quantities(words):
        return None
    return op.until[0].quantity, op.until[1]


def aimed_parameters(op: Operator, words: Vocabulary) -> Iterator[str]:
    """The parameter that an operator which is there for a number has beside its own."""
    aim = aim_of(op, words)
    if aim is not None:
        yield f"{aim_parameter(op)} - {level_type(aim[0], words)}"


def aim_parameter(op: Operator) -> str:
    """That parameter, by a name that none of the operator's own has."""
    name = AIM
    while name in op.parameters:
        name += "_"
    return f"?{name}"


def level_named(op: Operator, words: Vocabulary, value: float) -> str:
    """The object that stands for the farthest level that an operator reaches if it brings its number to a value.

    :raises ValueError: if the operator is there for no number.
    """
    aim = aim_of(op, words)
    if aim is None or op.until is None:
        raise ValueError(f"{op.name} is there for no number")
    sign = _direction(op.until[0])
    known = sorted(levels(aim[0], words), key=lambda level: sign * level)
    reached = [level for level in known if sign * (value - level) >= -ROUNDING]
    return level_object(aim[0], reached[-1] if reached else known[0], words)


def levels(quantity: str, words: Vocabulary) -> Iterator[float]:
    """What actions that are there for the quantity bring it to: from what is to be kept to their limits."""
    spec = words.base.quantities[quantity]
    step = STEP * spec.span
    found = set()
    for op in words.steps:
        if op.until is not None and op.until[0].quantity == quantity:
            limit, sign = op.until[0].number, _direction(op.until[0])
            kept = spec.kept[0 if sign > 0 else 1]
            steps = 0 if kept is None else floor(sign * (limit - kept) / step + ROUNDING)
            found |= {round(limit - sign * number * step, 9) for number in range(max(0, steps) + 1)}
    yield from sorted(found)


def has_levels(quantity: str, words: Vocabulary) -> bool:
    """True if there are actions for the quantity."""
    return any(True for _ in levels(quantity, words))


def level_constants(words: Vocabulary) -> Iterator[str]:
    """The levels as constants with their types."""
    for quantity in kept_quantities(words):
        for level in levels(quantity, words):
            yield f"{level_object(quantity, level, words)} - {level_type(quantity, words)}"


def level_types(words: Vocabulary) -> Iterator[str]:
    """The types of levels."""
    for quantity in kept_quantities(words):
        if has_levels(quantity, words):
            yield f"{level_type(quantity, words)} - object"


def level_object(quantity: str, level: float, words: Vocabulary) -> str:
    """The object that stands for a level."""
    return words.objects.add(f"{quantity}_{number_words(level)}")


def level_type(quantity: str, words: Vocabulary) -> str:
    """The type of a quantity's levels."""
    return words.types.add(f"{quantity}_level")


def _direction(until: Comparison) -> int:
    """1 if an action raises its number up to this, -1 if it lowers it."""
    return 1 if until.sign in ("<=", "<") else -1
