"""A mission's recovery: its current step, the outcomes of its attempts, and the only code that assigns them."""

from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from typing import Any, Protocol

from app.domain.blockers import Blockers
from app.domain.lifecycles.transitions import check_transition
from app.domain.recovery_rules import TRIES, Measure, Trouble

Attempt = dict[str, Any]


class RecoveryStep(StrEnum):
    """The current step of a mission's recovery, once its robots are safe; none while nothing is to be recovered."""

    PLANNING = "planning"
    """A repaired plan is sought."""
    DECIDING = "deciding"
    """A repaired plan waits for an operator's decision."""
    WAITING = "waiting"
    """A plan needs robots, places or samples that are not available; it is planned again later."""
    STUCK = "stuck"
    """There is no plan, or no try is left: an operator has to act."""
    ENDING = "ending"
    """An operator has rejected the repair: the mission ends."""


class AttemptOutcome(StrEnum):
    """The outcome of one attempt at recovering a mission."""

    PLANNING = "planning"
    """A repaired plan is sought."""
    PROPOSED = "proposed"
    """A repaired plan is open to decision."""
    APPROVED = "approved"
    """The mission carries the repaired plan out, or has carried it out."""
    REJECTED = "rejected"
    """An operator has rejected the repaired plan."""
    OVERTAKEN = "overtaken"
    """The world changed so that the repaired plan could not be approved any longer."""
    NO_PLAN = "no plan"
    """No repaired plan was found."""
    TAKEN_UP = "taken up"
    """An operator has resumed the mission after it was stuck."""


_STEPS: Mapping[RecoveryStep | None, tuple[RecoveryStep | None, ...]] = {
    None: (RecoveryStep.PLANNING, RecoveryStep.STUCK),
    RecoveryStep.PLANNING: (
        None,  # approved at once, or there is no plan
        RecoveryStep.PLANNING,  # the world has changed meanwhile
        RecoveryStep.DECIDING,
        RecoveryStep.WAITING,
    ),
    RecoveryStep.DECIDING: (
        None,  # approved
        RecoveryStep.PLANNING,  # the world has changed meanwhile
        RecoveryStep.ENDING,
    ),
    RecoveryStep.WAITING: (RecoveryStep.PLANNING, RecoveryStep.STUCK),
    RecoveryStep.STUCK: (None,),  # an operator has resumed the mission
    RecoveryStep.ENDING: (),
}
_OUTCOMES: Mapping[AttemptOutcome, tuple[AttemptOutcome, ...]] = {
    AttemptOutcome.PLANNING: (AttemptOutcome.PROPOSED, AttemptOutcome.NO_PLAN),
    AttemptOutcome.PROPOSED: (
        AttemptOutcome.APPROVED,
        AttemptOutcome.REJECTED,
        AttemptOutcome.OVERTAKEN,
    ),
    AttemptOutcome.OVERTAKEN: (AttemptOutcome.NO_PLAN,),  # and there are no tries left
    AttemptOutcome.NO_PLAN: (AttemptOutcome.TAKEN_UP,),
    AttemptOutcome.APPROVED: (AttemptOutcome.TAKEN_UP,),  # it failed, and there are no tries left
    AttemptOutcome.REJECTED: (),
    AttemptOutcome.TAKEN_UP: (),
}


class Recovery(Protocol):
    """The fields of a mission that its recovery assigns; the last of `attempts` is the present one.

    `stopped_for`: why its robots were stopped, in words, if none of them had failed. `replanning`: an operator has
    asked for another plan, with `pins`, what is pinned of it, and `goals`, further ones that it is to be for; None if
    not, or once it is approved or rejected. `joined_goals`: those that it carries out beside its own, by id.
    """

    recovery_step: str | None
    tries_left: int
    attempts: list[Any]
    stopped_for: str
    replanning: dict[str, Any] | None
    joined_goals: list[Any]


def ask_for_plan(
    mission: Recovery, *, pins: Sequence[Mapping[str, Any]], goals: Sequence[str] = (), reason: str
) -> None:
    """Have the mission's robots stopped and its plan made again, as an operator asks.

    This uses up none of its tries.

    :param goals: that wait; the plan is to be for them, too.
    """
    mission.replanning = {"pins": list(pins), "goals": list(goals)}
    mission.stopped_for = reason
    mission.tries_left += 1


def asked_goals(mission: Recovery) -> tuple[str, ...]:
    """The goals that the plan that an operator has asked for is to be for, too."""
    return tuple((mission.replanning or {}).get("goals", ()))


def goals_beside(mission: Recovery) -> tuple[str, ...]:
    """The goals that the mission's next plan is for beside its own."""
    return (*mission.joined_goals, *asked_goals(mission))


def goals_left_out(mission: Recovery) -> tuple[str, ...]:
    """The goals that plans were asked for and that the mission does not carry out."""
    asked = dict.fromkeys(goal for attempt in mission.attempts for goal in attempt.get("goals", ()))
    return tuple(goal for goal in asked if goal not in goals_beside(mission))


def leave_goals_out(mission: Recovery, reason: str) -> None:
    """Note that no plan was found for the goals that were asked for; one without them is to be made."""
    _conclude(mission, AttemptOutcome.NO_PLAN, detail=reason)
    mission.replanning = {**(mission.replanning or {}), "goals": []}
    mission.tries_left += 1


def refuse_plan(mission: Recovery, plan_id: str, detail: str) -> None:
    """Note that the operator who has asked for another plan rejects it: the present one is to be carried on with."""
    _conclude(mission, AttemptOutcome.REJECTED, plan_id=plan_id, detail=detail)
    mission.replanning = None
    mission.stopped_for = detail
    mission.tries_left += 1


def goes_back(mission: Recovery) -> bool:
    """True if the mission goes back to the rest of its plan because the one that was asked for was rejected."""
    return mission.replanning is None and mission.attempts[-1]["failure"] is None


def note_stop(mission: Recovery, reason: str) -> None:
    """Note why the mission's robots are stopped although none of them has failed."""
    mission.stopped_for = reason


def begin_attempt(
    mission: Recovery, troubles: Sequence[Trouble], *, at_s: float, failure: str | None, reason: str
) -> Attempt:
    """Have the mission's plan repaired; this uses up one of its tries.

    :param troubles: the troubles of its present plan's scripts; those of scripts in earlier attempts are not recorded
        again.
    :param at_s: world's clock.
    :param failure: the failure category that the attempt is recorded under; None: nothing has failed.
    """
    _set_step(mission, RecoveryStep.PLANNING)
    mission.tries_left = max(0, mission.tries_left - 1)
    recorded = {one.script for one in troubles_of(mission) if one.script}
    attempt: Attempt = {
        "number": len(mission.attempts) + 1,
        "troubles": [one.to_json() for one in troubles if one.script not in recorded],
        "measure": None,
        "without": [],
        "plan_id": None,
        "outcome": AttemptOutcome.PLANNING.value,
        "detail": "",
        "at_s": at_s,
        "failure": failure,
        "reason": reason,
        "goals": list(asked_goals(mission)),
    }
    mission.attempts = [*mission.attempts, attempt]
    return attempt


def note_left_out(mission: Recovery, names: Sequence[str]) -> None:
    """Note what the present attempt excludes from planning: robots, and packets of robots."""
    _note(mission, without=list(names))


def propose(mission: Recovery, *, plan_id: str, measure: Measure, detail: str) -> None:
    """Note the repaired plan that was found."""
    _conclude(mission, AttemptOutcome.PROPOSED, measure=measure.value, plan_id=plan_id, detail=detail)


def ask_operator(mission: Recovery) -> None:
    """Let the repaired plan wait for an operator's decision."""
    _set_step(mission, RecoveryStep.DECIDING)


def approve(mission: Recovery, plan_id: str) -> None:
    """Let the mission carry the repaired plan out."""
    _conclude(mission, AttemptOutcome.APPROVED, plan_id=plan_id)
    _set_step(mission, None)
    mission.joined_goals = list(goals_beside(mission))
    mission.replanning = None
    mission.stopped_for = ""


def reject(mission: Recovery, plan_id: str, detail: str) -> None:
    """Let the mission end, because the operator has rejected the repair."""
    _conclude(mission, AttemptOutcome.REJECTED, plan_id=plan_id, detail=detail)
    _set_step(mission, RecoveryStep.ENDING)


def overtake(mission: Recovery, reason: str) -> None:
    """Note that the world has changed so that the repaired plan cannot be approved."""
    _conclude(mission, AttemptOutcome.OVERTAKEN, detail=reason)


def find_no_plan(mission: Recovery, reason: str) -> None:
    _conclude(mission, AttemptOutcome.NO_PLAN, detail=reason)
    _set_step(mission, None)


def wait_for(mission: Recovery, blockers: Blockers) -> None:
    """Let the repair wait for the blockers; it is planned again later."""
    _conclude(mission, AttemptOutcome.NO_PLAN)
    note_blockers(mission, blockers)
    _set_step(mission, RecoveryStep.WAITING)


def note_blockers(mission: Recovery, blockers: Blockers) -> None:
    """Record the current state of what the mission waits for."""
    _note(mission, detail=blockers.reason, waits_for=blockers.to_json())


def waits_for(mission: Recovery) -> Blockers:
    """What the mission waits for; nothing if it does not wait."""
    known = mission.attempts[-1].get("waits_for") if mission.recovery_step == RecoveryStep.WAITING else None
    return Blockers() if known is None else Blockers.from_json(known)


def get_stuck(mission: Recovery) -> None:
    """Let the mission wait for an operator."""
    _set_step(mission, RecoveryStep.STUCK)


def try_again(mission: Recovery) -> None:
    """Let a stuck mission be recovered with all its tries again. Troubles no longer count, except lost robots."""
    _conclude(mission, AttemptOutcome.TAKEN_UP)
    answer_troubles(mission, lambda trouble: not trouble.is_loss)
    _set_step(mission, None)
    mission.tries_left = TRIES


def answer_troubles(mission: Recovery, is_answered: Callable[[Trouble], bool]) -> None:
    """Mark troubles of the mission as answered: they no longer count against their robots."""

    def told(known: Mapping[str, Any]) -> Mapping[str, Any]:
        return {**known, "answered": True} if is_answered(Trouble.from_json(known)) else known

    mission.attempts = [
        {**attempt, "troubles": [told(one) for one in attempt["troubles"]]} for attempt in mission.attempts
    ]


def end(mission: Recovery) -> None:
    """Stop recovering: the mission has ended."""
    mission.recovery_step = None


def troubles_of(mission: Recovery) -> list[Trouble]:
    """All troubles of the mission so far."""
    return [Trouble.from_json(one) for attempt in mission.attempts for one in attempt["troubles"]]


def why_no_plan(mission: Recovery) -> str:
    """Why the last attempt brought no plan, in words; empty if it did or is still open."""
    fruitless = (AttemptOutcome.NO_PLAN, AttemptOutcome.REJECTED)
    if not mission.attempts or mission.attempts[-1]["outcome"] not in fruitless:
        return ""
    return str(mission.attempts[-1]["detail"])


def _set_step(mission: Recovery, step: RecoveryStep | None) -> None:
    if step is None and mission.recovery_step is None:
        return
    check_transition(mission.recovery_step, step, _STEPS, what="recovery")
    mission.recovery_step = step


def _conclude(mission: Recovery, outcome: AttemptOutcome, **news: Any) -> None:
    present = mission.attempts[-1]["outcome"]
    check_transition(present, outcome, _OUTCOMES, what="recovery attempt")
    _note(mission, outcome=outcome.value, **news)


def _note(mission: Recovery, **news: Any) -> None:
    *before, last = mission.attempts
    mission.attempts = [*before, {**last, **news}]
