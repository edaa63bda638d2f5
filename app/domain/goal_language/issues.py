"""What stands against a goal."""

from dataclasses import dataclass
from typing import Literal

Kind = Literal["invalid", "conflict", "note"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalIssue:
    """An issue with a goal. invalid: never possible; conflict: not in the current state; note: no obstacle.

    :param span: start and end in the goal's sentence of the thing; None if the sentence does not name it.
    """

    code: str
    kind: Kind
    detail: str
    thing: str = ""
    choices: tuple[str, ...] = ()
    span: tuple[int, int] | None = None
