"""A mission's life cycle: its states, the allowed transitions, and the only code that assigns them.

A paused mission keeps the state that it resumes to. Transitions during the pause change that state, by the same table.
"""

from collections.abc import Mapping
from enum import StrEnum
from typing import Protocol

from app.domain.errors import IllegalTransition
from app.domain.lifecycles.transitions import Stateful, change_state, check_transition
from robots.wire import FailureCategory

OVERDUE = "its deadline has passed"


class MissionState(StrEnum):
    """The state of a mission between the approval of its plan and its end."""

    PENDING = "pending"
    """Its plan is approved; its scripts are not made yet."""
    DISPATCHING = "dispatching"
    """Its scripts are on their way to the robots; none is known to be at work."""
    RUNNING = "running"
    """At least one robot is at work."""
    PAUSED = "paused"
    """An operator has stopped it for a while; it keeps the state that it resumes to."""
    UNKNOWN = "unknown"
    """A robot has not answered for longer than its radio explains, or reports implausibly."""
    RECOVERING = "recovering"
    """Something has gone wrong, or an operator asks: its robots are made safe and its plan is made again."""
    COMPLETED = "completed"
    """Over: all its goals are believed true."""
    PARTIALLY_COMPLETED = "partially_completed"
    """Over: some goal is not true, though some robot has finished its script."""
    FAILED = "failed"
    """Over: no robot has finished its script, or the mission's world or workflow failed."""
    CANCELLED = "cancelled"
    """Over: an operator has cancelled it, and its robots have stopped."""

    @property
    def ended(self) -> bool:
        return self in ENDED


ENDED = frozenset(
    {
        MissionState.COMPLETED,
        MissionState.PARTIALLY_COMPLETED,
        MissionState.FAILED,
        MissionState.CANCELLED,
    }
)
OPEN = tuple(state for state in MissionState if state not in ENDED)
"""The states of a mission that is not over; queries name them, because an index finds no rows by `not in`."""

_TRANSITIONS: Mapping[MissionState, frozenset[MissionState]] = {
    MissionState.PENDING: frozenset(
        {MissionState.DISPATCHING, MissionState.PAUSED, MissionState.FAILED, MissionState.CANCELLED}
    ),
    MissionState.DISPATCHING: ENDED
    | {
        MissionState.DISPATCHING,  # the scripts of a repaired plan are made
        MissionState.RUNNING,
        MissionState.PAUSED,
        MissionState.UNKNOWN,
        MissionState.RECOVERING,
    },
    MissionState.RUNNING: ENDED | {MissionState.PAUSED, MissionState.UNKNOWN, MissionState.RECOVERING},
    MissionState.PAUSED: ENDED
    | {
        MissionState.PENDING,
        MissionState.DISPATCHING,
        MissionState.RUNNING,
        MissionState.UNKNOWN,
        MissionState.RECOVERING,
    },
    MissionState.UNKNOWN: ENDED
    | {
        MissionState.DISPATCHING,  # all robots have answered, and none has begun
        MissionState.RUNNING,
        MissionState.PAUSED,
        MissionState.RECOVERING,
    },
    MissionState.RECOVERING: ENDED
    | {
        MissionState.DISPATCHING,  # with a repaired plan
        MissionState.PAUSED,
        MissionState.UNKNOWN,  # a robot does not answer the order to stop
    },
    MissionState.COMPLETED: frozenset(),
    MissionState.PARTIALLY_COMPLETED: frozenset(),
    MissionState.FAILED: frozenset(),
    MissionState.CANCELLED: frozenset(),
}


class Mission(Stateful, Protocol):
    """The fields of a mission that its life cycle assigns.

    `resume_to` is set while it is paused; `reason` says why it is in its state, but not that it is overdue.
    """

    resume_to: str | None
    reason: str
    failure: str | None
    is_overdue: bool
    ended_at_s: float | None


def has_ended(mission: Stateful) -> bool:
    return mission.state in ENDED


def is_paused(mission: Stateful) -> bool:
    return mission.state == MissionState.PAUSED


def active_state(mission: Mission) -> MissionState:
    """The mission's state; of a paused one the state that it resumes to."""
    if is_paused(mission):
        return MissionState(mission.resume_to or MissionState.RUNNING)
    return MissionState(mission.state)


def full_reason(mission: Mission) -> str:
    """Why the mission is in its state, in words; while it runs, also that it is overdue."""
    return with_overdue(mission.reason, is_overdue=mission.is_overdue and not has_ended(mission))


def with_overdue(reason: str, *, is_overdue: bool) -> str:
    return "; ".join(filter(None, (reason, OVERDUE if is_overdue else "")))


def dispatch(mission: Mission) -> None:
    """Have the scripts of the mission's current plan written and delivered."""
    _change(mission, MissionState.DISPATCHING)
    mission.reason = ""
    mission.failure = None


def begin_work(mission: Mission) -> bool:
    """Note that a robot is at work; True if the mission was not running before."""
    if mission.state != MissionState.DISPATCHING:
        return False
    _change(mission, MissionState.RUNNING)
    return True


def assess(
    mission: Mission, state: MissionState, *, reason: str, failure: FailureCategory | None, is_overdue: bool
) -> None:
    """Record the monitor's assessment of the mission; `paused` leaves its state unchanged."""
    if state not in (MissionState.PAUSED, active_state(mission)):
        _change(mission, state)
    mission.reason = reason
    mission.failure = failure
    mission.is_overdue = mission.is_overdue or is_overdue


def pause(mission: Mission) -> None:
    before = mission.state
    change_state(mission, MissionState.PAUSED, _TRANSITIONS, what="mission")
    mission.resume_to = before


def resume(mission: Mission) -> None:
    if not is_paused(mission):
        raise IllegalTransition(f"a mission that is {mission.state} cannot be resumed")
    change_state(mission, active_state(mission), _TRANSITIONS, what="mission")
    mission.resume_to = None


def end(
    mission: Mission, state: MissionState, *, reason: str, failure: FailureCategory | None, ended_at_s: float
) -> None:
    """End the mission.

    :param ended_at_s: world's clock.
    """
    change_state(mission, state, _TRANSITIONS, what="mission")
    mission.resume_to = None
    mission.reason = reason
    mission.failure = failure
    mission.ended_at_s = ended_at_s


def _change(mission: Mission, target: MissionState) -> None:
    if is_paused(mission):
        check_transition(active_state(mission), target, _TRANSITIONS, what="paused mission")
        mission.resume_to = target
    else:
        change_state(mission, target, _TRANSITIONS, what="mission")
