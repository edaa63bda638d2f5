"""Terms and values as JSON data, without loss: a name is a string, a number a number, `f(a, 1)` is `["f", ["a", 1]]`.

A rule file's text cannot write every term: the content of a message may hold any name.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from robots.deliberative.matching import Key
from robots.deliberative.terms import Term, Value, Variable
from robots.errors import RuleError


def stored(value: Value) -> Any:
    """A value as JSON data."""
    if isinstance(value, Term):
        return [value.functor, [stored(one) for one in value.args]]
    if isinstance(value, Variable):
        return {"variable": value.name}
    return value


def restored(data: Any) -> Value:
    """The value that the data hold.

    :raises RuleError: if they hold none.
    """
    match data:
        case bool():
            pass
        case str() | float() | int():
            return data
        case [str() as functor, list() | tuple() as args]:
            return Term(functor, tuple(restored(one) for one in args))
        case {"variable": str() as name}:
            return Variable(name)
    raise RuleError(f"{data!r} is no stored value")


def restored_term(data: Any) -> Term:
    """:raises RuleError: if the data hold no term."""
    value = restored(data)
    if not isinstance(value, Term):
        raise RuleError(f"{data!r} is no stored term")
    return value


def stored_key(key: Sequence[Value]) -> tuple[Any, ...]:
    """The values of a rule's variables as JSON data."""
    return tuple(stored(one) for one in key)


def restored_key(data: Sequence[Any]) -> Key:
    """:raises RuleError: if they hold none."""
    return tuple(restored(one) for one in data)


def stored_bindings(bindings: Mapping[str, Value]) -> dict[str, Any]:
    return {name: stored(value) for name, value in bindings.items()}


def restored_bindings(data: Mapping[str, Any]) -> dict[str, Value]:
    """:raises RuleError: if they hold none."""
    return {name: restored(value) for name, value in data.items()}
