"""Comparisons of bound values."""

import operator
from collections.abc import Callable, Mapping
from typing import Any

from robots.deliberative.program import Guard
from robots.deliberative.terms import Bindings, substitute

ORDERED: Mapping[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def holds(guard: Guard, bindings: Bindings) -> bool:
    """Whether the comparison holds. Numbers have an order, and names that of their characters; all else has none."""
    left = substitute(guard.left, bindings)
    right = substitute(guard.right, bindings)
    if guard.operator == "==":
        return left == right
    if guard.operator == "!=":
        return left != right
    numbers = isinstance(left, float | int) and isinstance(right, float | int)
    if numbers or (isinstance(left, str) and isinstance(right, str)):
        return ORDERED[guard.operator](left, right)
    return False
