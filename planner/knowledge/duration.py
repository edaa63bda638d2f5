"""Durations: small arithmetic over functions and constants, written as data."""

import ast
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from planner.errors import KnowledgeBaseError

Functions = Mapping[tuple[str, tuple[str, ...]], float]

_OPERATIONS: Mapping[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


@dataclass(frozen=True, slots=True)
class Duration:
    """An expression such as `distance_m(ref1, ref2) / speed_m_s(robots) + 4`, in seconds."""

    text: str
    tree: ast.expr
    calls: tuple[tuple[str, tuple[str, ...]], ...]
    """The function terms in it: name and parameters."""

    @classmethod
    def parse(cls, text: str) -> "Duration":
        """:raises KnowledgeBaseError: if it is more than + - * / over numbers and function(parameter, …)."""
        try:
            tree = ast.parse(text, mode="eval").body
        except SyntaxError as error:
            raise KnowledgeBaseError(f"duration {text!r} is not an expression") from error
        return cls(text, tree, tuple(dict.fromkeys(_calls(tree, text))))

    def seconds(self, binding: Mapping[str, str], functions: Functions) -> float | None:
        """The duration under the binding; None where a function has no value there (not connected)."""
        values: dict[tuple[str, tuple[str, ...]], float] = {}
        for name, terms in self.calls:
            value = functions.get((name, tuple(binding[term] for term in terms)))
            if value is None:
                return None
            values[name, terms] = value
        return _evaluate(self.tree, values)


def _calls(tree: ast.expr, text: str) -> list[tuple[str, tuple[str, ...]]]:
    match tree:
        case ast.Constant(value=int() | float()):
            return []
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATIONS:
            return _calls(left, text) + _calls(right, text)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            terms = [argument.id for argument in arguments if isinstance(argument, ast.Name)]
            if len(terms) == len(arguments):
                return [(name, tuple(terms))]
    raise KnowledgeBaseError(
        f"duration {text!r}: {ast.unparse(tree)!r} is not allowed; "
        "choices: numbers, + - * /, function(parameter, …)"
    )


def _evaluate(tree: ast.expr, values: Mapping[tuple[str, tuple[str, ...]], float]) -> float:
    match tree:
        case ast.Constant(value=int() | float() as number):
            return float(number)
        case ast.BinOp(left=left, op=op, right=right):
            return _OPERATIONS[type(op)](_evaluate(left, values), _evaluate(right, values))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return values[
                name, tuple(argument.id for argument in arguments if isinstance(argument, ast.Name))
            ]
    raise AssertionError(ast.dump(tree))
