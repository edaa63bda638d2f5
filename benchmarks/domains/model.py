"""Builds unified-planning problems, classical or durative, from one description of a domain."""

from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import Any

from unified_planning.model import (
    DurativeAction,
    EndTiming,
    Fluent,
    InstantaneousAction,
    Problem,
    StartTiming,
    TimeInterval,
)
from unified_planning.model.metrics import MinimizeMakespan, MinimizeSequentialPlanLength
from unified_planning.model.timing import ClosedTimeInterval
from unified_planning.shortcuts import BoolType, IntType, Object, UserType


class Form(StrEnum):
    """What a problem's actions are."""

    CLASSICAL = "classical"  # instantaneous; the fewest actions are asked for
    TEMPORAL = "temporal"  # with durations; the least makespan is asked for


class Model:
    """A domain and a problem of it.

    Facts are written as words, `at truck place`: a predicate, then parameters of the action or objects. A durative
    action deletes at its start and adds at its end; what it needs and does not delete must hold all the while.
    """

    def __init__(self, name: str, form: Form) -> None:
        self.form = form
        self.problem = Problem(name)
        self._types: dict[str, Any] = {}
        self._times: set[str] = set()

    def kinds(self, *names: str, of: str | None = None) -> None:
        """Types, subtypes of `of` if that is given."""
        for name in names:
            self._types[name] = UserType(name, self._types[of] if of else None)

    def predicates(self, **kinds: str) -> None:
        """Each with the types of its arguments, as words: `at="truck place"`."""
        for name, words in kinds.items():
            self.problem.add_fluent(self._fluent(name, words, BoolType()), default_initial_value=False)

    def times(self, **kinds: str) -> None:
        """Static functions that durations are given by; only durative problems have them."""
        for name, words in kinds.items():
            self._times.add(name)
            if self.form is Form.TEMPORAL:
                self.problem.add_fluent(self._fluent(name, words, IntType()), default_initial_value=0)

    def objects(self, kind: str, names: Iterable[str]) -> list[str]:
        made = list(names)
        self.problem.add_objects(Object(name, self._types[kind]) for name in made)
        return made

    def action(
        self,
        name: str,
        parameters: Mapping[str, str],
        *,
        needs: Iterable[str],
        deletes: Iterable[str] = (),
        adds: Iterable[str],
        lasts: int | str,
    ) -> None:
        """:param parameters: to their types; the first is who does it.
        :param lasts: the duration in seconds, or the function that gives it.
        """
        kinds = {parameter: self._types[kind] for parameter, kind in parameters.items()}
        deleted, added = set(deletes), set(adds)
        if self.form is Form.CLASSICAL:
            plain = InstantaneousAction(name, **kinds)
            for text in needs:
                plain.add_precondition(self._fact(text, plain))
            for text in sorted(deleted - added):
                plain.add_effect(self._fact(text, plain), False)
            for text in sorted(added):
                plain.add_effect(self._fact(text, plain), True)
            self.problem.add_action(plain)
            return
        timed = DurativeAction(name, **kinds)
        timed.set_fixed_duration(lasts if isinstance(lasts, int) else self._fact(lasts, timed))
        start, end = StartTiming(), EndTiming()
        for text in needs:
            when: Any = start if text in deleted else _throughout(start, end)
            timed.add_condition(when, self._fact(text, timed))
        for text in sorted(deleted):
            timed.add_effect(start, self._fact(text, timed), False)
        for text in sorted(added):
            timed.add_effect(end, self._fact(text, timed), True)
        self.problem.add_action(timed)

    def holds(self, *texts: str) -> None:
        """Initial facts."""
        for text in texts:
            self.problem.set_initial_value(self._fact(text, None), True)

    def takes(self, text: str, seconds: int) -> None:
        """A value of a function of durations."""
        if self.form is Form.TEMPORAL:
            self.problem.set_initial_value(self._fact(text, None), seconds)

    def wants(self, *texts: str) -> None:
        """Goals."""
        for text in texts:
            self.problem.add_goal(self._fact(text, None))

    def finished(self) -> Problem:
        """The problem with what is to be least."""
        is_timed = self.form is Form.TEMPORAL
        self.problem.add_quality_metric(MinimizeMakespan() if is_timed else MinimizeSequentialPlanLength())
        return self.problem

    def _fluent(self, name: str, words: str, kind: Any) -> Fluent:
        signature = {f"a{number}": self._types[word] for number, word in enumerate(words.split())}
        return Fluent(name, kind, **signature)

    def _fact(self, text: str, action: Any) -> Any:
        name, *words = text.split()
        own = {parameter.name: parameter for parameter in action.parameters} if action is not None else {}
        return self.problem.fluent(name)(*(own.get(word) or self.problem.object(word) for word in words))


def _throughout(start: Any, end: Any) -> TimeInterval:
    return ClosedTimeInterval(start, end)


def numbered(word: str, count: int) -> list[str]:
    """`word1`, `word2`, …"""
    return [f"{word}{number + 1}" for number in range(count)]
