"""The mission monitor's rules (MACTA §4), as a pure function of what is known.

At the end of the expected time and its margin the robots are asked how they stand, and the mission's state follows
from their answers: still at work extends the time, silence makes the mission `unknown`, never `failed`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from app.states import MissionState
from robots.wire import FailureCategory, ScriptState

EXTENSION_S = 20.0
"""World seconds a mission is given at least when its robots say they are still at work."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptView:
    """A robot's script as known: `open_question` while a status query is unanswered, `stopping` once told to cancel."""

    robot: str
    delivery: str
    state: ScriptState | None
    open_question: bool
    stopping: bool = False
    category: FailureCategory | None = None
    detail: str = ""

    @property
    def ended(self) -> bool:
        done = (ScriptState.FINISHED, ScriptState.FAILED, ScriptState.CANCELLED)
        return self.delivery == "refused" or self.state in done

    @property
    def failed(self) -> bool:
        return self.delivery == "refused" or self.state is ScriptState.FAILED


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionView:
    """A mission as known. `asked_for_s`: wall-clock seconds since the monitor's open question, None without one."""

    state: MissionState
    now_s: float
    enquire_at_s: float
    estimate_s: float
    asked_for_s: float | None
    cancel_requested: bool
    scripts: Sequence[ScriptView]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """What to do next. `wait_s` is in the world's clock: when to look again if nothing is heard."""

    state: MissionState
    wait_s: float
    reason: str = ""
    failure: FailureCategory | None = None
    ask: tuple[str, ...] = ()
    cancel: tuple[str, ...] = ()
    enquire_at_s: float | None = None


def review(view: MissionView, *, patience_s: float) -> Verdict:
    """Decide on a mission; `patience_s` is how long (wall clock) an answer may take before a robot counts as silent."""
    if not view.scripts:
        return Verdict(state=view.state, wait_s=EXTENSION_S)
    open_scripts = [script for script in view.scripts if not script.ended]
    if not open_scripts:
        return _conclusion(view)
    failed = [script for script in view.scripts if script.failed]
    if failed or view.cancel_requested:
        return _make_safe(view, open_scripts, failed, patience_s)
    if view.asked_for_s is None:
        return _expecting(view, open_scripts)
    return _questioning(view, open_scripts, patience_s)


def _conclusion(view: MissionView) -> Verdict:
    failed = [script for script in view.scripts if script.failed]
    finished = [script for script in view.scripts if script.state is ScriptState.FINISHED]
    if view.cancel_requested and len(finished) < len(view.scripts):
        return Verdict(
            state=MissionState.CANCELLED,
            wait_s=0,
            reason="cancelled by the operator",
            failure=FailureCategory.CANCELLED,
        )
    if not failed:
        return Verdict(state=MissionState.COMPLETED, wait_s=0)
    reason = "; ".join(f"{script.robot}: {script.detail}" for script in failed)
    category = failed[0].category or FailureCategory.ROBOT
    state = MissionState.PARTIALLY_COMPLETED if finished else MissionState.FAILED
    return Verdict(state=state, wait_s=0, reason=reason, failure=category)


def _make_safe(
    view: MissionView, open_scripts: list[ScriptView], failed: list[ScriptView], patience_s: float
) -> Verdict:
    """Stop the robots that are still at work; one that does not answer leaves the mission unknown."""
    why = "; ".join(f"{script.robot}: {script.detail}" for script in failed) or "cancelled by the operator"
    names = tuple(script.robot for script in open_scripts)
    cancel = tuple(script.robot for script in open_scripts if not script.stopping)
    if cancel or (view.asked_for_s or 0.0) < patience_s:
        reason = f"{why}; stopping {', '.join(names)}"
        return Verdict(state=view.state, wait_s=patience_s, reason=reason, cancel=cancel)
    return Verdict(
        state=MissionState.UNKNOWN,
        wait_s=patience_s,
        reason=f"{why}; no answer from {', '.join(names)}",
        failure=FailureCategory.UNREACHABLE,
    )


def _expecting(view: MissionView, open_scripts: list[ScriptView]) -> Verdict:
    """The expected time is not over, or it is and the robots are to be asked."""
    left_s = view.enquire_at_s - view.now_s
    if left_s > 0 or view.state is MissionState.PAUSED:
        return Verdict(state=view.state, wait_s=max(left_s, EXTENSION_S if left_s <= 0 else left_s))
    names = tuple(script.robot for script in open_scripts)
    return Verdict(
        state=view.state,
        wait_s=EXTENSION_S,
        ask=names,
        reason=f"the expected time is over: asking {', '.join(names)}",
    )


def _questioning(view: MissionView, open_scripts: list[ScriptView], patience_s: float) -> Verdict:
    """Robots have been asked: all answered that they are at work, or some are still silent.

    Paused meanwhile, nothing is concluded from either: the question is asked anew later.
    """
    if view.state is MissionState.PAUSED:
        return Verdict(state=view.state, wait_s=EXTENSION_S, enquire_at_s=view.now_s + EXTENSION_S)
    silent = [script.robot for script in open_scripts if script.open_question or script.delivery == "pending"]
    if not silent:
        extension_s = max(EXTENSION_S, view.estimate_s / 2)
        return Verdict(
            state=MissionState.RUNNING,
            wait_s=extension_s,
            reason=f"still at work: {', '.join(script.robot for script in open_scripts)}",
            enquire_at_s=view.now_s + extension_s,
        )
    asked_s = view.asked_for_s or 0.0
    if asked_s < patience_s:
        return Verdict(
            state=view.state, wait_s=patience_s, reason=f"waiting for {', '.join(silent)} to answer"
        )
    return Verdict(
        state=MissionState.UNKNOWN,
        wait_s=patience_s,
        reason=f"no answer from {', '.join(silent)}",
        failure=FailureCategory.UNREACHABLE,
    )
