"""Terms of first-order logic, and unification (Robinson 1965)."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

PLAIN_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(?:-[A-Za-z][A-Za-z0-9_]*)*")


@dataclass(frozen=True, slots=True)
class Variable:
    """`?name`. A variable whose name begins with `?` is anonymous: written `?_`, each of its own."""

    name: str

    def __str__(self) -> str:
        return "?_" if self.name.startswith("?") else f"?{self.name}"


class Term(NamedTuple):
    """`functor(args)`; a name without arguments is a term as a belief or action, and a string as an argument."""

    functor: str
    args: "tuple[Value, ...]" = ()

    def __str__(self) -> str:
        if not self.args:
            return self.functor
        return f"{self.functor}({', '.join(shown(one) for one in self.args)})"


Value = Term | Variable | str | float
"""An argument. Numbers are compared by value, names by their characters."""
Bindings = Mapping[str, Value]
"""By the variable's name."""
NOT = "not"
"""`not(t)`: sensed or known not to hold, which is more than not believed."""


def opposite(term: Term) -> Term:
    """`not(t)` of `t`, and `t` of `not(t)`."""
    if term.functor == NOT and len(term.args) == 1:
        return as_term(term.args[0])
    return Term(NOT, (as_value(term),))


def as_term(value: Value) -> Term:
    """An argument as a belief or action.

    :raises TypeError: for a number or a variable.
    """
    if isinstance(value, Term):
        return value
    if isinstance(value, str):
        return Term(value)
    raise TypeError(f"{shown(value)} is neither a name nor a term")


def as_value(term: Term) -> Value:
    """A belief or action as an argument."""
    return term if term.args else term.functor


def shown(value: Value) -> str:
    """The value as it is written in a rule file."""
    if isinstance(value, str):
        if PLAIN_NAME.fullmatch(value):
            return value
        escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
        return f'"{escaped}"'
    if isinstance(value, float | int):
        return f"{value:.12g}"
    return str(value)


def variables_in(value: Value) -> Iterator[str]:
    """The names of its variables, left to right, each as often as it occurs."""
    if isinstance(value, Variable):
        yield value.name
    elif isinstance(value, Term):
        for one in value.args:
            yield from variables_in(one)


def is_ground(value: Value) -> bool:
    """True if it has no variables."""
    return next(variables_in(value), None) is None


def substitute(value: Value, bindings: Bindings) -> Value:
    """The value with bound variables replaced, also within what they are bound to."""
    if isinstance(value, Variable):
        bound = bindings.get(value.name)
        return value if bound is None else substitute(bound, bindings)
    if isinstance(value, Term) and value.args:
        return Term(value.functor, tuple([substitute(one, bindings) for one in value.args]))
    return value


def instance(term: Term, bindings: Bindings) -> Term:
    """`substitute` of a belief or action."""
    if not term.args:
        return term
    return Term(term.functor, tuple([substitute(one, bindings) for one in term.args]))


def match(pattern: Value, ground: Value, bindings: dict[str, Value]) -> bool:
    """Bind the pattern's variables so that it equals a value without variables; False if they cannot be.

    `bindings` is extended in place, also when the answer is False.
    """
    if isinstance(pattern, Variable):
        known = bindings.setdefault(pattern.name, ground)
        return known == ground
    if not isinstance(pattern, Term):
        return pattern == ground
    if not isinstance(ground, Term) or pattern.functor != ground.functor:
        return False
    if len(pattern.args) != len(ground.args):
        return False
    return all(match(one, other, bindings) for one, other in zip(pattern.args, ground.args, strict=True))


def unify(left: Value, right: Value, bindings: Bindings | None = None) -> dict[str, Value] | None:
    """The most general bindings that make both equal, with occurs check; None if there are none."""
    found = dict(bindings or {})
    return found if _unified(left, right, found) else None


def renamed(value: Value, mark: str) -> Value:
    """The value with other variables than any that does not bear this mark."""
    if isinstance(value, Variable):
        return Variable(f"{value.name}{mark}")
    if isinstance(value, Term):
        return Term(value.functor, tuple(renamed(one, mark) for one in value.args))
    return value


def _unified(left: Value, right: Value, found: dict[str, Value]) -> bool:
    left = _followed(left, found)
    right = _followed(right, found)
    if left == right:
        return True
    if isinstance(left, Variable):
        return _bound(left, right, found)
    if isinstance(right, Variable):
        return _bound(right, left, found)
    if not isinstance(left, Term) or not isinstance(right, Term):
        return False
    if left.functor != right.functor or len(left.args) != len(right.args):
        return False
    return all(_unified(one, other, found) for one, other in zip(left.args, right.args, strict=True))


def _followed(value: Value, found: Bindings) -> Value:
    while isinstance(value, Variable) and value.name in found:
        value = found[value.name]
    return value


def _bound(variable: Variable, value: Value, found: dict[str, Value]) -> bool:
    if variable.name in variables_in(substitute(value, found)):
        return False
    found[variable.name] = value
    return True
