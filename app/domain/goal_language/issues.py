"""What stands against a goal."""

from dataclasses import dataclass
from typing import Literal

Kind = Literal["invalid", "conflict", "note"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalIssue:
    """An issue with a goal. invalid: never possible; conflict: not in the current state; note: no obstacle."""

    code: str
    kind: Kind
    detail: str
    thing: str = ""
    choices: tuple[str, ...] = ()
