"""A mission's recovery: the step that it is at, the outcomes of its attempts, and the only code that assigns them."""

from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from typing import Any, Protocol

from app.domain.blockers import Blockers
from app.domain.lifecycles.transitions import check_transition
from app.domain.recovery_rules import TRIES, Measure, Trouble

Attempt = dict[str, Any]


class RecoveryStep(StrEnum):
    """Where the recovery of a mission stands, once its robots are safe; none while nothing is to be recovered."""

    PLANNING = "planning"
    """A repaired plan is sought."""
    DECIDING = "deciding"
    """A repaired plan waits for an operator's decision."""
    WAITING = "waiting"
    """Others use what a plan would need; it is planned again later."""
    STUCK = "stuck"
    """There is no plan, or it was tried too often: an operator must see to it."""
    ENDING = "ending"
    """An operator has turned the repair down: the mission ends."""


class AttemptOutcome(StrEnum):
    """What came of one attempt at recovering a mission."""

    PLANNING = "planning"
    """A repaired plan is sought."""
    PROPOSED = "proposed"
    """A repaired plan is open to decision."""
    APPROVED = "approved"
    """The mission carries the repaired plan out, or has carried it out."""
    REJECTED = "rejected"
    """An operator does not want the repaired plan."""
    OVERTAKEN = "overtaken"
    """The world had changed under the repaired plan before it was approved."""
    NO_PLAN = "no plan"
    """No repaired plan was found."""
    TAKEN_UP = "taken up"
    """An operator has had the mission tried again after it was stuck."""


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
    RecoveryStep.STUCK: (None,),  # an operator has had it tried again
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
    """What of a mission its recovery assigns; the last of `attempts` is the present one."""

    recovery_step: str | None
    tries_left: int
    attempts: list[Any]


def begin_attempt(
    mission: Recovery, troubles: Sequence[Trouble], *, at_s: float, failure: str, reason: str
) -> Attempt:
    """Have the mission's plan repaired; this uses up one of its tries.

    :param troubles: what befell the scripts of its present plan; what an attempt has recorded already is not
        recorded again.
    :param at_s: world's clock.
    :param failure: the failure category that the attempt is recorded under.
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
    }
    mission.attempts = [*mission.attempts, attempt]
    return attempt


def note_left_out(mission: Recovery, names: Sequence[str]) -> None:
    """Note what the present attempt does not plan with: robots, and packets of robots."""
    _note(mission, without=list(names))


def propose(mission: Recovery, *, plan_id: str, measure: Measure, detail: str) -> None:
    """Note the repaired plan that was found."""
    _conclude(mission, AttemptOutcome.PROPOSED, measure=measure.value, plan_id=plan_id, detail=detail)


def ask_operator(mission: Recovery) -> None:
    """Have an operator decide on the repaired plan."""
    _set_step(mission, RecoveryStep.DECIDING)


def approve(mission: Recovery, plan_id: str) -> None:
    _conclude(mission, AttemptOutcome.APPROVED, plan_id=plan_id)
    _set_step(mission, None)


def reject(mission: Recovery, plan_id: str, detail: str) -> None:
    """Have the mission end, for the operator does not want it repaired this way."""
    _conclude(mission, AttemptOutcome.REJECTED, plan_id=plan_id, detail=detail)
    _set_step(mission, RecoveryStep.ENDING)


def overtake(mission: Recovery, reason: str) -> None:
    """Note that the world has changed under the repaired plan."""
    _conclude(mission, AttemptOutcome.OVERTAKEN, detail=reason)


def find_no_plan(mission: Recovery, reason: str) -> None:
    _conclude(mission, AttemptOutcome.NO_PLAN, detail=reason)
    _set_step(mission, None)


def wait_for(mission: Recovery, blockers: Blockers) -> None:
    """Have the plan sought again later."""
    _conclude(mission, AttemptOutcome.NO_PLAN)
    note_blockers(mission, blockers)
    _set_step(mission, RecoveryStep.WAITING)


def note_blockers(mission: Recovery, blockers: Blockers) -> None:
    """Note what is known now of what the mission waits for."""
    _note(mission, detail=blockers.reason, waits_for=blockers.to_json())


def waits_for(mission: Recovery) -> Blockers:
    """What the mission waits for; nothing if it does not wait."""
    known = mission.attempts[-1].get("waits_for") if mission.recovery_step == RecoveryStep.WAITING else None
    return Blockers() if known is None else Blockers.from_json(known)


def get_stuck(mission: Recovery) -> None:
    """Have an operator see to the mission."""
    _set_step(mission, RecoveryStep.STUCK)


def try_again(mission: Recovery) -> None:
    """Have a mission that is stuck recovered as if nothing had been tried. Robots that are lost stay so."""
    _conclude(mission, AttemptOutcome.TAKEN_UP)
    answer_troubles(mission, lambda trouble: not trouble.is_loss)
    _set_step(mission, None)
    mission.tries_left = TRIES


def answer_troubles(mission: Recovery, is_answered: Callable[[Trouble], bool]) -> None:
    """Have troubles of the mission speak against their robots no more."""

    def told(known: Mapping[str, Any]) -> Mapping[str, Any]:
        return {**known, "answered": True} if is_answered(Trouble.from_json(known)) else known

    mission.attempts = [
        {**attempt, "troubles": [told(one) for one in attempt["troubles"]]} for attempt in mission.attempts
    ]


def end(mission: Recovery) -> None:
    """Stop recovering: the mission has ended."""
    mission.recovery_step = None


def troubles_of(mission: Recovery) -> list[Trouble]:
    """All that has befallen the mission so far."""
    return [Trouble.from_json(one) for attempt in mission.attempts for one in attempt["troubles"]]


def why_no_plan(mission: Recovery) -> str:
    """Why the last attempt came to nothing, in words; empty if it has not."""
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
