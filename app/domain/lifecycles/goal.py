"""A goal's life cycle: its states, the allowed transitions, and the only code that assigns them."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Any, Protocol

from app.domain.blockers import Blockers
from app.domain.lifecycles.transitions import Stateful, change_state


class GoalState(StrEnum):
    """The state of a goal between its submission and its end."""

    SUBMITTED = "submitted"
    """Queued for planning, for the first time or, with a reason, again."""
    PLANNING = "planning"
    """A planning process works on it, or robots bid for the legs of its first plan: then the reason says so."""
    WAITING = "waiting"
    """There is no plan now; it is planned again when something in its world becomes free. The reason names it."""
    PLANNED = "planned"
    """At least one plan waits for an operator's decision."""
    UNSOLVABLE = "unsolvable"
    """Over: there is no plan, or none was found. The outcome is the planning status."""
    COMMITTED = "committed"
    """A mission carries it out."""
    FINISHED = "finished"
    """Over: its mission has ended, or there was nothing to do. The outcome is the mission's state, or `completed`."""
    WITHDRAWN = "withdrawn"
    """Over without a mission: cancelled, its last plan rejected, or its world no longer runs."""


TO_BE_PLANNED = (GoalState.SUBMITTED, GoalState.WAITING, GoalState.PLANNING)
"""The states of a goal that has no plan yet."""
UNDECIDED = (*TO_BE_PLANNED, GoalState.PLANNED)
"""The states of a goal that no mission carries out yet; it may be cancelled."""
OPEN = (*UNDECIDED, GoalState.COMMITTED)
"""The states of a goal that is not over."""

_TRANSITIONS: Mapping[GoalState, tuple[GoalState, ...]] = {
    GoalState.SUBMITTED: (
        GoalState.PLANNING,
        GoalState.WAITING,  # its world was started again
        GoalState.UNSOLVABLE,  # its planning keeps failing at its start
        GoalState.FINISHED,  # there is nothing to do
        GoalState.WITHDRAWN,
    ),
    GoalState.PLANNING: (
        GoalState.PLANNING,  # another process has taken its planning over, or robots have bid
        GoalState.WAITING,
        GoalState.PLANNED,
        GoalState.FINISHED,  # all of it is true already
        GoalState.UNSOLVABLE,
        GoalState.WITHDRAWN,
    ),
    GoalState.WAITING: (
        GoalState.PLANNING,
        GoalState.WAITING,  # for something else: its world was started again
        GoalState.FINISHED,  # another goal's mission has carried it out
        GoalState.UNSOLVABLE,
        GoalState.WITHDRAWN,
    ),
    GoalState.PLANNED: (
        GoalState.SUBMITTED,  # its plan has expired
        GoalState.WAITING,  # its world was started again
        GoalState.COMMITTED,
        GoalState.WITHDRAWN,
    ),
    GoalState.COMMITTED: (
        GoalState.COMMITTED,  # its mission gets a repaired plan
        GoalState.FINISHED,
    ),
    GoalState.UNSOLVABLE: (),
    GoalState.FINISHED: (),
    GoalState.WITHDRAWN: (),
}


class Goal(Stateful, Protocol):
    """The fields of a goal that its life cycle assigns."""

    reason: str
    outcome: str | None
    plan_id: str | None
    mission_id: str | None
    waits_for: dict[str, Any] | None


def resubmit(goal: Goal, reason: str) -> None:
    """Queue a planned goal for planning again: its plan has expired."""
    _change(goal, GoalState.SUBMITTED, reason)


def begin_planning(goal: Goal) -> None:
    _change(goal, GoalState.PLANNING)


def await_bids(goal: Goal) -> None:
    """Have the goal planned once robots have bid for the legs of its first plan."""
    _change(goal, GoalState.PLANNING, "robots are called for proposals")


def wait(goal: Goal, reason: str) -> None:
    """Have the goal planned again when something in its world becomes free."""
    _change(goal, GoalState.WAITING, reason)


def wait_for(goal: Goal, blockers: Blockers) -> None:
    """As `wait`, for these blockers; also updates the blockers of a goal that waits already."""
    wait(goal, blockers.reason)
    goal.waits_for = blockers.to_json()


def propose(goal: Goal, plan_id: str, reason: str = "") -> None:
    """Submit a plan of the goal to an operator's decision.

    :param reason: a drawback of the plan, such as a missed deadline.
    """
    _change(goal, GoalState.PLANNED, reason)
    goal.plan_id = plan_id


def give_up(goal: Goal, *, outcome: str, reason: str) -> None:
    """End the goal without a plan."""
    _change(goal, GoalState.UNSOLVABLE, reason)
    goal.outcome = outcome


def commit(goal: Goal, *, plan_id: str, mission_id: str) -> None:
    """Have the goal carried out by a mission, or by the same mission with a repaired plan."""
    _change(goal, GoalState.COMMITTED, goal.reason)
    goal.plan_id = plan_id
    goal.mission_id = mission_id


def finish(goal: Goal, *, outcome: str, reason: str, carried_out_by: str | None = None) -> None:
    """End the goal with its mission, or without one if there is nothing to do.

    :param outcome: the mission's last state; `completed` if there is nothing to do.
    :param carried_out_by: the mission of another goal that has carried this one out.
    """
    _change(goal, GoalState.FINISHED, reason)
    goal.outcome = outcome
    goal.mission_id = goal.mission_id or carried_out_by


def withdraw(goal: Goal, *, outcome: str, reason: str) -> None:
    """End the goal before a mission carries it out.

    :param outcome: why it is withdrawn, in one stable word.
    """
    _change(goal, GoalState.WITHDRAWN, reason)
    goal.outcome = outcome


def _change(goal: Goal, state: GoalState, reason: str = "") -> None:
    change_state(goal, state, _TRANSITIONS, what="goal")
    goal.reason = reason
    goal.waits_for = None
