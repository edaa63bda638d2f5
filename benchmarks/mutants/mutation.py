"""Mutants of the product's code, made by Cosmic Ray.

One operator, comparison, boolean, number, loop, decorator or exception is changed in one place. Left as they are:
annotations, decorators, `strict=True`, which states an invariant, and constants on a module's top level (limits and
waiting times that are chosen, not derived).
"""

import ast
import random
import subprocess
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import unified_diff
from hashlib import sha256
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parents[2]
PACKAGES = ("planner", "robots", "app")
LEFT_OUT = ("VariableInserter", "VariableReplacer", "NoOp", "Is_Eq", "IsNot_NotEq")
"""Operators that need settings, or change nothing: what is compared by identity is None or of an enumeration."""
Position = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutant:
    """The `occurrence`-th place in a module where an operator applies."""

    path: Path
    operator: str
    occurrence: int
    at: Position

    def __str__(self) -> str:
        return f"{self.path}:{self.at[0]} {self.operator.partition('/')[2]}"

    def code(self, checkout: Path) -> str | None:
        """The module's source with the change; None if the operator makes none there."""
        source = (checkout / self.path).read_text()
        try:
            changed = mutate_code(source, get_operator(self.operator)(), self.occurrence)
        except AttributeError:  # Cosmic Ray replaces no dotted name of an exception
            return None
        return None if changed in (None, source) else str(changed)

    def difference(self, checkout: Path) -> str:
        before = (checkout / self.path).read_text().splitlines()
        lines = list(unified_diff(before, (self.code(checkout) or "").splitlines(), lineterm="", n=0))
        return "\n".join(f"    {line}" for line in lines[3:])


def tracked(*patterns: str) -> list[Path]:
    listed = subprocess.check_output(["git", "ls-files", *patterns], text=True, cwd=ROOT)
    return [Path(line) for line in listed.splitlines()]


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Every mutant of a module but for those that are left out."""
    source = (ROOT / path).read_text()
    untouched = list(_untouched(ast.parse(source)))
    nodes = list(ast_nodes(get_ast(source)))
    for name in operator_names():
        if any(word in name for word in LEFT_OUT):
            continue
        operator, occurrence = get_operator(name)(), 0
        for node in nodes:
            for start, _ in operator.mutation_positions(node):
                if not any(first <= tuple(start) <= last for first, last in untouched):
                    yield Mutant(path=path, operator=name, occurrence=occurrence, at=tuple(start))
                occurrence += 1


def _untouched(tree: ast.Module) -> Iterator[tuple[Position, Position]]:
    """Spans of annotations, decorators, a module's constants, and of `strict=True`, which states an invariant."""
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "strict":
            yield _span(node.value)
        if isinstance(node, ast.AnnAssign | ast.arg) and node.annotation is not None:
            yield _span(node.annotation)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.returns is not None:
            yield _span(node.returns)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            for decorator in node.decorator_list:
                yield (decorator.lineno, 0), _span(decorator)[1]
    for statement in tree.body:
        if isinstance(statement, ast.Assign | ast.AnnAssign):
            yield _span(statement)


def _span(node: ast.expr | ast.stmt) -> tuple[Position, Position]:
    return (node.lineno, node.col_offset), (node.end_lineno or node.lineno, node.end_col_offset or 0)


def sample(count: int, seed: int, packages: Sequence[str]) -> list[Mutant]:
    """Mutants drawn place by place, so that an operator with many replacements counts no more than one with few.

    A place is drawn by its module, the text of its line and its column: of a sample most stays the same when other code
    changes.
    """
    places: dict[tuple[bytes, Path, Position], list[Mutant]] = defaultdict(list)
    for path in tracked(*(f"{package}/*.py" for package in packages)):
        if "migrations" not in path.parts:
            lines = (ROOT / path).read_text().splitlines()
            for mutant in mutants_of(path):
                line, column = mutant.at
                lot = sha256(f"{seed} {path} {column} {lines[line - 1]}".encode()).digest()
                places[lot, path, mutant.at].append(mutant)
    found: list[Mutant] = []
    for place in sorted(places):
        mutant = random.Random(place[0]).choice(places[place])
        if mutant.code(ROOT) is not None:
            found.append(mutant)
        if len(found) == count:
            break
    return found
