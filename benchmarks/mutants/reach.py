"""Which tests execute a line, as recorded by one run of the tests."""

import ast
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from coverage import Coverage, CoverageData

from benchmarks.mutants.mutation import Mutant
from benchmarks.mutants.recording import LINES, TESTS

MOST_S = 120.0
"""Of the tests that a mutant is tried with, by the time that they took when they were recorded."""
MOST_TESTS = 400
"""That a mutant is tried with."""


class Reach:
    """What `benchmarks.mutants.recording` has written."""

    def __init__(self, folder: Path, checkout: Path) -> None:
        """:param checkout: where the tests ran; its modules are read as they were then."""
        self._checkout = checkout
        self._seconds: dict[str, float] = {}
        for file in (folder / TESTS).iterdir():
            self._seconds |= json.loads(file.read_text())
        coverage = Coverage(data_file=str(folder / LINES), config_file=False)
        coverage.combine([str(folder)], keep=True)
        self._data: CoverageData = coverage.get_data()

    @property
    def tests(self) -> int:
        """How many tests passed."""
        return len(self._seconds)

    def tests_for(self, mutant: Mutant) -> list[str]:
        """Tests that execute the mutant's line: first those that mirror its room, then the others, the shortest first.

        A line that is executed by an import, or compiled, has those of all functions of its module; if all of these are
        compiled, those of its room.
        """
        source = self._checkout / mutant.path
        tests, imported = self._tests(source), _imported(source)
        lines: Iterable[int] = range(_statement(source, mutant.at[0]), mutant.at[0] + 1)
        if mutant.at[0] in imported or not any(tests.get(line) for line in lines):
            lines = tests.keys() - imported
        found = frozenset[str]().union(*(tests.get(line, ()) for line in lines))
        if not found:
            found = self._of_room(mutant.path)
        chosen: list[str] = []
        left_s = MOST_S
        room = f"tests/{mutant.path.parent}/"
        by_nearness = sorted(found, key=lambda test: (not test.startswith(room), self._seconds[test], test))
        for test in by_nearness:
            left_s -= self._seconds[test]
            if chosen and (left_s < 0 or len(chosen) == MOST_TESTS):
                break
            chosen.append(test)
        return chosen

    def _of_room(self, path: Path) -> frozenset[str]:
        """The tests that mirror a module's room, or the innermost around it that has any."""
        rooms = (f"tests/{folder}/" for folder in path.parents)
        return next(filter(None, map(self._below, rooms)), frozenset())

    def _below(self, folder: str) -> frozenset[str]:
        return frozenset(test for test in self._seconds if test.startswith(folder))

    def _tests(self, source: Path) -> dict[int, frozenset[str]]:
        """By line, the tests that passed and execute it."""
        contexts = self._data.contexts_by_lineno(str(source))
        return {line: frozenset(self._seconds.keys() & tests) for line, tests in contexts.items()}


@cache
def _tree(source: Path) -> ast.Module:
    return ast.parse(source.read_text())


def _lines(first: ast.stmt | ast.expr, last: ast.stmt | ast.expr) -> range:
    return range(first.lineno, (last.end_lineno or last.lineno) + 1)


@cache
def _imported(source: Path) -> frozenset[int]:
    """The lines of a module outside of its functions' bodies."""
    imported = {line for statement in _tree(source).body for line in _lines(statement, statement)}
    for node in ast.walk(_tree(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            imported.difference_update(_lines(node.body[0], node))
        elif isinstance(node, ast.Lambda):
            imported.difference_update(_lines(node, node))
    return frozenset(imported)


def _statement(source: Path, line: int) -> int:
    """The line on which the innermost statement around a line begins."""
    statements = (node for node in ast.walk(_tree(source)) if isinstance(node, ast.stmt))
    return max((one.lineno for one in statements if line in _lines(one, one)), default=line)
