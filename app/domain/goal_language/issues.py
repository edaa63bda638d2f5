"""What stands against a goal."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from app.domain.goal_language.conflict_set import ConstraintConflict
from app.domain.goal_language.words import choices_for, joined, suggestions

Kind = Literal["invalid", "conflict", "note"]
TOO_TIGHT = "constraints-too-tight"
"""The code of a goal that is possible only without its constraints; the choices are what these withhold."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalIssue:
    """An issue with a goal. invalid: never possible; conflict: not in the current state; note: no obstacle.

    :param constraints: those that cannot be kept together, in words; none of them can be left out of the conflict.
    :param span: start and end in the goal's sentence of the thing; None if the sentence does not name it.
    """

    code: str
    kind: Kind
    detail: str
    thing: str = ""
    choices: tuple[str, ...] = ()
    constraints: tuple[str, ...] = ()
    span: tuple[int, int] | None = None


def unknown_name(what: str, name: str, names: Sequence[str]) -> GoalIssue:
    """The issue that the world has no sample, robot or place of that name."""
    near = suggestions(name, names)
    hint = f"; did you mean {joined(near)}?" if near else ""
    return GoalIssue(
        code=f"unknown-{what}",
        kind="invalid",
        detail=f"there is no {what} {name!r}{hint}",
        thing=name,
        choices=choices_for(name, names),
    )


def conflict_in(issues: Iterable[GoalIssue]) -> ConstraintConflict | None:
    """The constraints that the issues name as too tight together; None if there are none."""
    named = dict.fromkeys(words for issue in issues for words in issue.constraints)
    return ConstraintConflict(constraints=tuple(named), proven=True) if named else None
