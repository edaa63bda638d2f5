"""The mission monitor's rules (MACTA §4), as a pure function of the mission's record.

At the end of the expected time and its margin the robots are asked for their status; a robot is asked earlier if its
silence is longer than its radio explains. The mission's state follows from the answers: robots still at work extend the
time, silence makes the mission `unknown`, never `failed`. If a robot fails, or a fact that the plan depends on is no
longer believed, the other robots are stopped first; then the mission is recovered or ends.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.recovery import RecoveryStep
from app.domain.lifecycles.script import TERMINAL_SCRIPTS, Delivery
from app.domain.recovery_rules import Policy, Trouble, category_of
from robots.wire import FailureCategory, ScriptState

EXTENSION_S = 20.0
"""Least world seconds by which a mission is extended when its robots report that they are still at work."""
LOOK_S = 5.0
"""Least world seconds between two checks whether a robot has become silent."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptView:
    """A robot's script as recorded.

    :param open_question: a status query is unanswered.
    :param stopping: the robot was ordered to cancel it.
    :param abandoned: its robot was declared lost.
    :param found: that robot is no longer lost.
    :param failed_at: the tag of the packet that failed.
    :param about: the things and places that the failed packet was about.
    :param waited: the failed packet never began: it waited for another robot.
    :param silent_in_s: least world seconds until the robot's silence is longer than its radio explains; 0 once it is.
    :param doubt: why the robot's report was held back as implausible; empty if none was.
    :param is_unasked: its robot does not understand status queries, so that it is not asked.
    :param unheard_s: world seconds for which reports may still come that show whether others were waited for; 0 if
        none is missing.
    :param counterparts: robots whose reports it waits for and that have not come.
    """

    robot: str
    delivery: Delivery
    state: ScriptState | None
    open_question: bool
    stopping: bool = False
    category: FailureCategory | None = None
    detail: str = ""
    abandoned: bool = False
    found: bool = False
    failed_at: str = ""
    about: tuple[str, ...] = ()
    waited: bool = False
    script_id: str = ""
    silent_in_s: float = inf
    doubt: str = ""
    counterparts: tuple[str, ...] = ()
    unheard_s: float = 0.0
    is_unasked: bool = False

    @property
    def is_silent(self) -> bool:
        return self.silent_in_s <= 0

    @property
    def ended(self) -> bool:
        undeliverable = self.delivery in (Delivery.REFUSED, Delivery.WITHDRAWN)
        return self.abandoned or undeliverable or self.state in TERMINAL_SCRIPTS

    @property
    def failed(self) -> bool:
        if self.state is ScriptState.FINISHED:
            return False
        return self.abandoned or self.delivery is Delivery.REFUSED or self.state is ScriptState.FAILED

    @property
    def trouble(self) -> Trouble:
        """The trouble of a failed script. A robot that refused it or is lost is not planned with any longer."""
        if self.abandoned:
            return Trouble(
                robot=self.robot,
                category=FailureCategory.UNREACHABLE,
                detail="was given up as lost and has been found" if self.found else "was declared lost",
                fit=self.found,
                script=self.script_id,
                answered=self.found,
            )
        category = self.category or FailureCategory.ROBOT
        willing = self.delivery is not Delivery.REFUSED
        return Trouble(
            robot=self.robot,
            category=category,
            detail=self.detail,
            tag=self.failed_at,
            fit=willing,
            waited=self.waited,
            script=self.script_id,
            about=self.about,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionView:
    """A mission as recorded.

    :param asked_for_s: wall-clock seconds since the monitor's open question, None without one.
    :param scripts: of the plan that it carries out now.
    :param missed: its goals that are not believed true, in words.
    :param broken: facts that it depends on and that are no longer believed, in words.
    :param tries_left: how often it may still be recovered.
    :param no_way: why no repaired plan was found, or why it was rejected; empty if none was sought.
    :param done_before: a robot has finished a script of an earlier plan.
    :param reason: why it is in its state.
    :param contradictions: in what its robots have reported on this plan, in words.
    :param stopped_for: why its robots were stopped although none had failed.
    :param deadline_s: world's clock; None without a deadline.
    :param replans: an operator has asked for another plan.
    """

    state: MissionState
    now_s: float
    enquire_at_s: float
    estimate_s: float
    asked_for_s: float | None
    cancel_requested: bool
    scripts: Sequence[ScriptView]
    missed: Sequence[str] = ()
    broken: Sequence[str] = ()
    policy: Policy = Policy.NEVER
    step: RecoveryStep | None = None
    tries_left: int = 0
    no_way: str = ""
    done_before: bool = False
    reason: str = ""
    contradictions: Sequence[str] = ()
    stopped_for: str = ""
    replans: bool = False
    deadline_s: float | None = None

    @property
    def left_s(self) -> float:
        """Seconds left of the expected time and its margin; negative if it is over."""
        return self.enquire_at_s - self.now_s

    @property
    def troubles(self) -> tuple[Trouble, ...]:
        return tuple(script.trouble for script in self.scripts if script.failed)

    @property
    def category(self) -> FailureCategory | None:
        """Of what has gone wrong: robots that contradict each other are at fault, not the world. None: nothing has."""
        contradict = bool(self.contradictions) and not self.troubles
        if self.replans and not contradict and not self.troubles:
            return None
        return FailureCategory.ROBOT if contradict else category_of(self.troubles)

    @property
    def is_recovered(self) -> bool:
        """Its plan is made again instead of it being ended."""
        return self.policy is not Policy.NEVER or self.replans

    @property
    def why(self) -> str:
        """What has gone wrong, in words; empty if nothing has."""
        if troubles := self.troubles:
            return "; ".join([*self.contradictions, *map(str, troubles)])
        if self.contradictions:
            return "; ".join(self.contradictions)
        return self.stopped_for or (f"{', '.join(self.broken)} is no longer true" if self.broken else "")


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """What to do next.

    :param wait_s: world seconds until the next review if no report arrives before.
    :param ask: the robots to send a status query.
    :param cancel: the robots to order to stop.
    :param is_overdue: its deadline has passed; the reason does not say so.
    :param recover: the step of its recovery that the mission is to take.
    """

    state: MissionState
    wait_s: float
    reason: str = ""
    failure: FailureCategory | None = None
    ask: tuple[str, ...] = ()
    cancel: tuple[str, ...] = ()
    enquire_at_s: float | None = None
    is_overdue: bool = False
    recover: RecoveryStep | None = None


def review(view: MissionView, *, patience_s: float) -> Verdict:
    """Decide on a mission; `patience_s` is how long (wall clock) an answer may take before a robot counts as silent."""
    verdict = _review(view, patience_s)
    if view.deadline_s is None or verdict.state.ended:
        return verdict
    return _with_deadline(verdict, view.deadline_s - view.now_s)


def _with_deadline(verdict: Verdict, left_s: float) -> Verdict:
    """The verdict with the deadline: a mission past it goes on as overdue; any other failure takes precedence.

    :param left_s: world seconds to the deadline.
    """
    if left_s > 0:
        return replace(verdict, wait_s=min(verdict.wait_s, left_s))
    return replace(verdict, is_overdue=True, failure=verdict.failure or FailureCategory.DEADLINE)


def _review(view: MissionView, patience_s: float) -> Verdict:
    if not view.scripts and view.state in (MissionState.PENDING, MissionState.PAUSED):
        return Verdict(state=view.state, wait_s=EXTENSION_S)
    open_scripts = [script for script in view.scripts if not script.ended]
    if not open_scripts:  # all have ended, or there are none because all goals were true already
        return _conclusion(view)
    stopping = any(script.stopping for script in open_scripts)
    if view.why or view.cancel_requested or stopping:
        return _make_safe(view, open_scripts, patience_s)
    doubted = [script for script in open_scripts if script.doubt]
    if doubted and view.state is not MissionState.PAUSED:
        return _doubting(view, doubted, open_scripts)
    if view.asked_for_s is None:
        return _expecting(view, open_scripts)
    return _questioning(view, open_scripts, patience_s)


def cancelled(*, came_true: bool = False) -> Verdict:
    """The verdict on a mission that the operator cancelled, when no robot is at work for it.

    :param came_true: all its goals are believed true.
    """
    reason = "cancelled by the operator" + (", but all its goals are true" if came_true else "")
    why = FailureCategory.CANCELLED
    return Verdict(state=MissionState.CANCELLED, wait_s=0, reason=reason, failure=why)


def _conclusion(view: MissionView) -> Verdict:
    """The verdict once every robot has ended its script, finished or not."""
    unfinished = [script for script in view.scripts if script.state is not ScriptState.FINISHED]
    if view.cancel_requested and unfinished:
        return cancelled(came_true=not view.missed)
    if not view.missed and not view.contradictions:
        if unheard := [script for script in view.scripts if script.unheard_s > 0]:
            return Verdict(
                state=view.state,
                wait_s=max(script.unheard_s for script in unheard),
                reason=f"waiting for reports of {', '.join(script.robot for script in unheard)}",
            )
        # NOTE: also if a robot failed, when all goals are true.
        return Verdict(state=MissionState.COMPLETED, wait_s=0, reason="" if view.replans else view.why)
    category = view.category
    recovery = _recovery(view, "; ".join(filter(None, (_what_happened(view), view.no_way))))
    if recovery is not None:
        return replace(recovery, failure=category)
    some_done = view.done_before or len(unfinished) < len(view.scripts)
    state = MissionState.PARTIALLY_COMPLETED if some_done else MissionState.FAILED
    reason = "; ".join(filter(None, (_what_happened(view), view.no_way)))
    return Verdict(state=state, wait_s=0, reason=reason, failure=category)


def _recovery(view: MissionView, reason: str) -> Verdict | None:
    """The verdict on the recovery of a mission whose robots are safe; None if the mission ends."""
    if (
        view.step in (RecoveryStep.PLANNING, RecoveryStep.DECIDING, RecoveryStep.STUCK)
        and not view.cancel_requested
    ):
        now = reason if view.step is RecoveryStep.STUCK else view.reason
        return Verdict(state=view.state, wait_s=EXTENSION_S, reason=now)
    if view.step is RecoveryStep.ENDING or view.cancel_requested or not view.is_recovered:
        return None
    if view.step is RecoveryStep.WAITING and view.left_s > 0:
        return Verdict(state=MissionState.RECOVERING, wait_s=view.left_s, reason=reason)
    if view.tries_left > 0 and (not view.no_way or view.step is RecoveryStep.WAITING):
        reason = _what_happened(view)
        return Verdict(
            state=MissionState.RECOVERING, wait_s=EXTENSION_S, reason=reason, recover=RecoveryStep.PLANNING
        )
    if view.policy is Policy.AUTO and not view.replans:
        return None
    return Verdict(
        state=MissionState.RECOVERING, wait_s=EXTENSION_S, reason=reason, recover=RecoveryStep.STUCK
    )


def _what_happened(view: MissionView) -> str:
    if view.why:
        return view.why
    if all(script.state is ScriptState.FINISHED for script in view.scripts):
        return f"every script has finished, but {', '.join(view.missed)} is not true"
    return "the robots were stopped"


def _make_safe(view: MissionView, open_scripts: list[ScriptView], patience_s: float) -> Verdict:
    """Stop the robots that are still at work; one that does not answer leaves the mission unknown."""
    why = "cancelled by the operator" if view.cancel_requested else _what_happened(view)
    names = tuple(script.robot for script in open_scripts)
    cancel = tuple(script.robot for script in open_scripts if not script.stopping)
    recovers = not view.cancel_requested and view.is_recovered
    if cancel or (view.asked_for_s or 0.0) < patience_s:
        reason = f"{why}; stopping {', '.join(names)}"
        state = MissionState.RECOVERING if recovers else view.state
        return Verdict(state=state, wait_s=patience_s, reason=reason, cancel=cancel)
    return Verdict(
        state=MissionState.UNKNOWN,
        wait_s=patience_s,
        reason=f"{why}; no answer from {', '.join(names)}",
        failure=FailureCategory.UNREACHABLE,
    )


def _doubting(view: MissionView, doubted: list[ScriptView], open_scripts: list[ScriptView]) -> Verdict:
    """Robots report implausibly: the mission is `unknown`, and they are asked once for their status, as are those
    whose reports are missing."""
    concerned = {name for script in doubted for name in (script.robot, *script.counterparts)}
    ask = tuple(script.robot for script in _askable(open_scripts) if script.robot in concerned)
    return Verdict(
        state=MissionState.UNKNOWN,
        wait_s=EXTENSION_S,
        reason="; ".join(f"{script.robot} {script.doubt}" for script in doubted),
        failure=FailureCategory.ROBOT,
        ask=ask if view.asked_for_s is None else (),
    )


def _expecting(view: MissionView, open_scripts: list[ScriptView]) -> Verdict:
    """No question is open: wait, or ask robots if the expected time is over or they are silent for too long."""
    if view.state is MissionState.PAUSED:
        return Verdict(state=view.state, wait_s=view.left_s if view.left_s > 0 else EXTENSION_S)
    ask = tuple(script.robot for script in _askable(open_scripts) if view.left_s <= 0 or script.is_silent)
    if not ask:
        if unasked := _unasked(view, open_scripts):
            return unasked
        silent_in_s = min(script.silent_in_s for script in open_scripts)
        state = _at_work(view) if view.state is MissionState.UNKNOWN else view.state
        return Verdict(state=state, wait_s=min(view.left_s, max(silent_in_s, LOOK_S)))
    over = "the expected time is over" if view.left_s <= 0 else f"no message from {', '.join(ask)}"
    reason = f"{over}: asking {', '.join(ask)}"
    return Verdict(state=view.state, wait_s=EXTENSION_S, ask=ask, reason=reason)


def _questioning(view: MissionView, open_scripts: list[ScriptView], patience_s: float) -> Verdict:
    """A question is open: go on if all robots have answered, else wait, and after `patience_s` the state is `unknown`.

    If the mission was paused meanwhile, nothing is concluded: the question is asked again later.
    """
    if view.state is MissionState.PAUSED:
        later_s = max(view.enquire_at_s, view.now_s + EXTENSION_S)
        return Verdict(state=view.state, wait_s=EXTENSION_S, enquire_at_s=later_s)
    owing = [script.robot for script in open_scripts if _owes_an_answer(script, over=view.left_s <= 0)]
    if not owing:
        return _unasked(view, open_scripts) or _going_on(view, open_scripts)
    if (view.asked_for_s or 0.0) < patience_s:
        reason = f"waiting for {', '.join(owing)} to answer"
        return Verdict(state=view.state, wait_s=patience_s, reason=reason)
    return Verdict(
        state=MissionState.UNKNOWN,
        wait_s=patience_s,
        reason=f"no answer from {', '.join(owing)}",
        failure=FailureCategory.UNREACHABLE,
    )


def _askable(open_scripts: Sequence[ScriptView]) -> list[ScriptView]:
    return [script for script in open_scripts if not script.is_unasked]


def _unasked(view: MissionView, open_scripts: Sequence[ScriptView]) -> Verdict | None:
    """The mission is `unknown` while robots would have to be asked that cannot be; None if none would."""
    due = [script for script in open_scripts if script.is_unasked and (view.left_s <= 0 or script.is_silent)]
    if not due:
        return None
    names = ", ".join(script.robot for script in due)
    over = "the expected time is over" if view.left_s <= 0 else f"no message from {names}"
    return Verdict(
        state=MissionState.UNKNOWN,
        wait_s=EXTENSION_S,
        reason=f"{over}, and {names} cannot be asked: status queries are not understood",
        failure=FailureCategory.UNREACHABLE,
    )


def _owes_an_answer(script: ScriptView, *, over: bool) -> bool:
    """True if the robot owes the answer to a query or, once it is silent or the time is `over`, to its script."""
    return script.open_question or (script.delivery is Delivery.PENDING and (over or script.is_silent))


def _going_on(view: MissionView, open_scripts: list[ScriptView]) -> Verdict:
    """All robots that were asked have answered: go on; if the expected time is over, it is extended."""
    extension_s = max(EXTENSION_S, view.estimate_s / 2) if view.left_s <= 0 else view.left_s
    return Verdict(
        state=_at_work(view),
        wait_s=extension_s,
        reason=f"still at work: {', '.join(script.robot for script in open_scripts)}",
        enquire_at_s=view.now_s + extension_s,
    )


def _at_work(view: MissionView) -> MissionState:
    """The state of a mission whose robots are at work."""
    begun = any(script.state is not None for script in view.scripts)
    return MissionState.RUNNING if begun else MissionState.DISPATCHING
