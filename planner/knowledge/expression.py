"""Numbers of an action, such as its duration: small arithmetic over functions and constants, written as data."""

import ast
import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

from planner.errors import KnowledgeBaseError

MAX_LENGTH = 300
"""Of an expression, in characters; a longer one could be nested deeper than it can be read."""

Functions = Mapping[tuple[str, tuple[str, ...]], float]

NOTHING_KNOWN: Functions = {}

_OPERATIONS = (ast.Add, ast.Sub, ast.Mult, ast.Div)


@dataclass(frozen=True, slots=True)
class Expression:
    """An expression such as `distance_m(ref1, ref2) / speed_m_s(robots) + 4`."""

    text: str
    tree: ast.expr
    calls: tuple[tuple[str, tuple[str, ...]], ...]
    """The function terms in it: name and parameters."""
    compute: Callable[[Sequence[float]], float] = field(compare=False, repr=False)
    """The number, from the values of `calls`."""

    @classmethod
    def parse(cls, text: str) -> "Expression":
        """:raises KnowledgeBaseError: if it is more than + - * / over numbers and function(parameter, …)."""
        if len(text) > MAX_LENGTH:
            raise KnowledgeBaseError(f"{text[:40]!r}… is longer than {MAX_LENGTH} characters")
        try:
            tree = ast.parse(text, mode="eval").body
        except SyntaxError as error:
            raise KnowledgeBaseError(f"{text!r} is not an expression") from error
        calls = tuple(dict.fromkeys(_calls(tree, text)))
        compute = _compiled(tree, calls)
        if not calls and _evaluate(compute, ()) is None:
            raise KnowledgeBaseError(f"{text!r} divides by 0")
        return cls(text, tree, calls, compute)

    def __reduce__(self) -> tuple[object, ...]:
        """From its text: knowledge bases are sent to planning processes, compiled functions cannot be."""
        return Expression.parse, (self.text,)

    def value(
        self, binding: Mapping[str, str], functions: Functions, known: Functions = NOTHING_KNOWN
    ) -> float | None:
        """The number under the binding; None where a function has no value there (not connected) or is a
        divisor of 0.

        :param known: values of terms that are not the world's functions, as they stand in the expression.
        """
        values: list[float] = []
        for call in self.calls:
            name, terms = call
            value = known.get(call) if known else None
            if value is None:
                value = functions.get((name, tuple([binding[term] for term in terms])))
            if value is None:
                return None
            values.append(value)
        return _evaluate(self.compute, values)


def _calls(tree: ast.expr, text: str) -> list[tuple[str, tuple[str, ...]]]:
    match tree:
        case ast.Constant(value=int() | float()):
            return []
        case ast.BinOp(left=left, op=op, right=right) if isinstance(op, _OPERATIONS):
            return _calls(left, text) + _calls(right, text)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            terms = [argument.id for argument in arguments if isinstance(argument, ast.Name)]
            if len(terms) == len(arguments):
                return [(name, tuple(terms))]
    raise KnowledgeBaseError(
        f"{text!r}: {ast.unparse(tree)!r} is not allowed; choices: numbers, + - * /, function(parameter, …)"
    )


def _evaluate(compute: Callable[[Sequence[float]], float], values: Sequence[float]) -> float | None:
    try:
        return float(compute(values))
    except ZeroDivisionError:
        return None


def _compiled(
    tree: ast.expr, calls: Sequence[tuple[str, tuple[str, ...]]]
) -> Callable[[Sequence[float]], float]:
    """The checked expression as a function: grounding evaluates it thousands of times."""
    code = ast.parse("lambda values: 0", mode="eval")
    assert isinstance(code.body, ast.Lambda)
    code.body.body = _OfValues(calls).visit(copy.deepcopy(tree))
    made = eval(
        compile(ast.fix_missing_locations(code), "<expression>", "eval")
    )  # arithmetic and nothing else
    return cast("Callable[[Sequence[float]], float]", made)


class _OfValues(ast.NodeTransformer):
    """Puts `values[n]` for the n-th function term."""

    def __init__(self, calls: Sequence[tuple[str, tuple[str, ...]]]) -> None:
        self._calls = calls

    def visit_Call(self, node: ast.Call) -> ast.expr:
        assert isinstance(node.func, ast.Name)
        term = node.func.id, tuple(argument.id for argument in node.args if isinstance(argument, ast.Name))
        index = ast.Constant(self._calls.index(term))
        return ast.Subscript(ast.Name("values", ast.Load()), index, ast.Load())


DURATION_SCALE = "duration_scale"
"""A function every knowledge base has: by action and team size, what its durations are multiplied by."""


def scale_term(action: str, team: int) -> tuple[str, tuple[str, ...]]:
    """The function term of the factor for an action done by `team` robots; without a value it is 1."""
    return DURATION_SCALE, (action, str(team))
