"""A robot's factsheet: what has become of it, and the only code that assigns that."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from app.domain.lifecycles.transitions import change_state
from robots.wire import FactsheetState

IN_WORLD = (FactsheetState.IN_FORCE, FactsheetState.POSTPONED)
"""States of factsheets of robots that the world has."""
OUTSIDE = (FactsheetState.ANNOUNCED, FactsheetState.REFUSED)
"""States in which an operator may admit the robot."""

_TRANSITIONS: Mapping[FactsheetState, Sequence[FactsheetState]] = {
    FactsheetState.ANNOUNCED: tuple(FactsheetState),
    FactsheetState.REFUSED: tuple(FactsheetState),  # another one may come, or an operator admits the robot
    FactsheetState.IN_FORCE: (*IN_WORLD, FactsheetState.REFUSED),
    FactsheetState.POSTPONED: (*IN_WORLD, FactsheetState.REFUSED),
}


class KeptFactsheet(Protocol):
    """The fields that change with the state."""

    state: str
    reason: str
    edition: int | None
    decided_by: str | None
    is_told: bool


def await_admission(sheet: KeptFactsheet, reason: str) -> None:
    """Let the robot wait until an operator admits it."""
    _become(sheet, FactsheetState.ANNOUNCED, reason)


def put_in_force(sheet: KeptFactsheet, *, edition: int | None, by: str | None = None) -> None:
    """Note that the robot is in the world as it says.

    :param edition: that it has made; None if the world was so already.
    :param by: the operator who admitted the robot.
    """
    _become(sheet, FactsheetState.IN_FORCE, "", by=by)
    sheet.edition = edition


def postpone(sheet: KeptFactsheet, reason: str) -> None:
    """Let it wait for the end of the mission that needs what it changes."""
    _become(sheet, FactsheetState.POSTPONED, reason)


def refuse(sheet: KeptFactsheet, reason: str, *, by: str | None = None) -> None:
    """:param by: the operator who refuses the robot; None: it does not fit the world."""
    _become(sheet, FactsheetState.REFUSED, reason, by=by)


def _become(sheet: KeptFactsheet, state: FactsheetState, reason: str, *, by: str | None = None) -> None:
    change_state(sheet, state, _TRANSITIONS, what="factsheet")
    sheet.reason = reason
    sheet.decided_by = by
    sheet.is_told = False
