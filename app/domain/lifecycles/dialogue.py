"""The life cycle of a dialogue: what a person says to one robot, from the first word to how it ended."""

from collections.abc import Collection, Mapping
from enum import StrEnum
from typing import Protocol

from app.domain.lifecycles.transitions import change_state, check_transition


class DialogueState(StrEnum):
    """How far it is."""

    ASKING = "asking"
    """The person is asked which one is meant."""
    PROPOSED = "proposed"
    """A script is shown, and waits for the person's approval."""
    SAID = "said"
    """It is said to the robot, which has not answered for good."""
    AGREED = "agreed"
    """The robot has agreed, and is at it."""
    DONE = "done"
    """The robot has done it, or answered. An end."""
    REFUSED = "refused"
    """The robot, or the service for it, refuses. An end."""
    FAILED = "failed"
    """The robot has not managed it. An end."""
    NOT_UNDERSTOOD = "not_understood"
    """The robot has not understood it. An end."""
    TIMED_OUT = "timed_out"
    """The robot has not answered in time. An end."""
    WITHDRAWN = "withdrawn"
    """The person has withdrawn it. An end."""


UNDER_WAY = (DialogueState.SAID, DialogueState.AGREED)
AWAITS_PERSON = (DialogueState.ASKING, DialogueState.PROPOSED)
OPEN = (*AWAITS_PERSON, *UNDER_WAY)
_ANSWERS = (
    DialogueState.DONE,
    DialogueState.REFUSED,
    DialogueState.FAILED,
    DialogueState.NOT_UNDERSTOOD,
    DialogueState.TIMED_OUT,
    DialogueState.WITHDRAWN,
)
_UNDERSTOOD = (*OPEN[:3], DialogueState.DONE, DialogueState.REFUSED, DialogueState.WITHDRAWN)
_FIRST = _UNDERSTOOD[:5]
_TRANSITIONS: Mapping[DialogueState, Collection[DialogueState]] = {
    DialogueState.ASKING: _UNDERSTOOD,
    DialogueState.PROPOSED: _UNDERSTOOD,
    DialogueState.SAID: (DialogueState.AGREED, *_ANSWERS),
    DialogueState.AGREED: _ANSWERS,
}


class Talk(Protocol):
    """The fields that change with the state."""

    state: str
    reason: str


def begin(talk: Talk, state: DialogueState, reason: str = "") -> None:
    """Assign a new dialogue's first state.

    :raises IllegalTransition: if no dialogue begins so.
    """
    first: Mapping[DialogueState | None, Collection[DialogueState | None]] = {None: _FIRST}
    check_transition(None, state, first, what="dialogue")
    talk.state = state
    talk.reason = reason


def become(talk: Talk, state: DialogueState, reason: str = "") -> None:
    """:param reason: why it is refused or has failed; empty if it is not.

    :raises IllegalTransition: if it cannot become that.
    """
    change_state(talk, state, _TRANSITIONS, what="dialogue")
    talk.reason = reason


def is_open(talk: Talk) -> bool:
    """True until it has ended."""
    return talk.state in OPEN
