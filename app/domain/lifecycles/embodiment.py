"""The life cycle of a move of a robot's mind into another body, from the request to its end."""

from collections.abc import Collection, Mapping
from enum import StrEnum
from typing import Protocol

from app.domain.lifecycles.transitions import change_state


class EmbodimentState(StrEnum):
    """How far a move is."""

    REQUESTED = "requested"
    """The robot is asked to rest at a safe point; until it does, it goes on as it is."""
    HANDING_OVER = "handing_over"
    """Its mind rests, and is handed over from one program to another, the world's simulation or the robot's own."""
    MOVING = "moving"
    """Its mind rests. The exchange of its body is recorded, and the world is told of it."""
    GOING_ON = "going_on"
    """It has the other body, and is told to go on."""
    EMBODIED = "embodied"
    """It goes on in the other body. An end."""
    RETURNING = "returning"
    """It stays in its former body, and is told to go on."""
    RETURNED = "returned"
    """It goes on in its former body. An end."""
    REFUSED = "refused"
    """The robot does not come to rest, and goes on in its former body. An end."""


OPEN = (
    EmbodimentState.REQUESTED,
    EmbodimentState.HANDING_OVER,
    EmbodimentState.MOVING,
    EmbodimentState.GOING_ON,
    EmbodimentState.RETURNING,
)
ENDS = tuple(state for state in EmbodimentState if state not in OPEN)
GOES_ON_AS: Mapping[str, EmbodimentState] = {
    EmbodimentState.GOING_ON: EmbodimentState.EMBODIED,
    EmbodimentState.RETURNING: EmbodimentState.RETURNED,
}
"""By the state of a move in which the robot is told to go on, the state once it does."""
_TRANSITIONS: Mapping[EmbodimentState, Collection[EmbodimentState]] = {
    EmbodimentState.REQUESTED: (
        EmbodimentState.HANDING_OVER,
        EmbodimentState.MOVING,
        EmbodimentState.RETURNING,
        EmbodimentState.REFUSED,
    ),
    EmbodimentState.HANDING_OVER: (EmbodimentState.MOVING, EmbodimentState.RETURNING),
    EmbodimentState.MOVING: (EmbodimentState.GOING_ON, EmbodimentState.RETURNING),
    # A program that has lost the mind is handed it again.
    EmbodimentState.GOING_ON: (
        EmbodimentState.EMBODIED,
        EmbodimentState.RETURNED,
        EmbodimentState.HANDING_OVER,
    ),
    EmbodimentState.RETURNING: (EmbodimentState.RETURNED,),
}


class Move(Protocol):
    """The fields that change with the state."""

    state: str
    reason: str


def become(move: Move, state: EmbodimentState, reason: str = "") -> None:
    """:param reason: why the mind does not get the other body; empty: what was said before stays.

    :raises IllegalTransition: if it cannot become that.
    """
    change_state(move, state, _TRANSITIONS, what="move of a mind")
    move.reason = reason or move.reason


def end_anew(move: Move, *, has_body: bool, reason: str) -> None:
    """End an open move, since other software speaks for the robot, or its world has begun again.

    :param has_body: whether the robot has the other body now.
    """
    state = EmbodimentState.EMBODIED if has_body else EmbodimentState.RETURNED
    change_state(move, state, dict.fromkeys(OPEN, ENDS), what="move of a mind")
    move.reason = "" if has_body else reason


def is_open(move: Move) -> bool:
    """True until it has ended."""
    return move.state in OPEN
