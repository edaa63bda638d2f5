"""A hold's life cycle: its states, the allowed transitions, and the only code that assigns them."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Protocol

from app.domain.lifecycles.transitions import Stateful, change_state


class HoldState(StrEnum):
    """The state of a hold: places that are kept empty and facts that are kept true for some time."""

    HELD = "held"
    """Nothing is put in its places, and no plan ends its facts."""
    ENDED = "ended"
    """Over: its places, samples and robots may be used again."""


class HoldEnding(StrEnum):
    """Why a hold ended."""

    TIME = "time"
    """Its time has come."""
    MISSION = "mission"
    """The mission that it waits for has ended."""
    GOAL = "goal"
    """The goal that it waits for is over."""
    FACT = "fact"
    """The fact that it waits for has become true."""
    OPERATOR = "operator"
    """An operator has ended it."""
    NEW_RUN = "new_run"
    """Its span counts on the clock of a run of the world that is over."""
    WORLD_REMOVED = "world_removed"
    """Its world was removed."""


_TRANSITIONS: Mapping[HoldState, tuple[HoldState, ...]] = {
    HoldState.HELD: (HoldState.ENDED,),
    HoldState.ENDED: (),
}


class Hold(Stateful, Protocol):
    """The fields of a hold that its life cycle assigns."""

    ending: str | None
    ended_by: str | None
    ended_at: str | None
    comment: str


def end(hold: Hold, ending: HoldEnding, *, at: str, actor: str | None = None, comment: str = "") -> None:
    """End the hold.

    :param at: when it ended (wall clock, ISO 8601).
    :param actor: the operator who ended it; None: it ended by itself.
    """
    change_state(hold, HoldState.ENDED, _TRANSITIONS, what="hold")
    hold.ending = ending
    hold.ended_by = actor
    hold.ended_at = at
    hold.comment = comment
