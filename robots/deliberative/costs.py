"""What a plan costs, in seconds or whatever its file counts in: numbers, bound variables, and measures of the robot."""

from collections.abc import Callable, Iterator, Mapping

from robots.deliberative.terms import Bindings, Term, Value, shown, substitute

SUM = "+"
PRODUCT = "*"
WAY = "way"
BATTERY = "battery"
LASTS = "lasts"
MEASURES: Mapping[str, int] = {WAY: 1, BATTERY: 0, LASTS: 1}
"""By name, the number of arguments: `way(place)`, seconds straight there at full speed; `battery`, its share;
`lasts(TAG)`, seconds that such packets have taken.
"""
Measure = Callable[[str, tuple[str, ...]], float | None]
"""Measures the robot now; None for what is not known."""


def cost_of(cost: Value, bindings: Bindings, measure: Measure) -> float | None:
    """The value of a cost; None if a part of it is not known, or is no number."""
    if isinstance(cost, Term) and cost.functor in (SUM, PRODUCT):
        left, right = (cost_of(one, bindings, measure) for one in cost.args)
        if left is None or right is None:
            return None
        return left + right if cost.functor == SUM else left * right
    value = substitute(cost, bindings)
    if isinstance(value, float | int):
        return float(value)
    # NOTE: what a variable is bound to is no measure, even if it is called like one.
    if isinstance(cost, Term) and isinstance(value, Term) and MEASURES.get(cost.functor) == len(value.args):
        return measure(
            value.functor, tuple(one if isinstance(one, str) else shown(one) for one in value.args)
        )
    return measure(cost, ()) if isinstance(cost, str) and MEASURES.get(cost) == 0 else None


def packets_in(cost: Value) -> Iterator[str]:
    """The packets whose duration a cost has."""
    if not isinstance(cost, Term):
        return
    if cost.functor == LASTS and len(cost.args) == 1 and isinstance(cost.args[0], str):
        yield cost.args[0]
    elif cost.functor in (SUM, PRODUCT):
        for one in cost.args:
            yield from packets_in(one)
