"""A mission's durable workflow: organise, dispatch, monitor, recover, conclude.

Every step reads and writes the record in one transaction, so a step that runs again after a crash does nothing twice.
Between steps the workflow sleeps until a report arrives or the monitor's next review is due.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Self

from sqlalchemy.orm import Session

from app.agents.running_world import RunningWorld
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.events import MISSION_PHASES, MissionOverdue, MissionRobotsAsked
from app.domain.lifecycles.mission import MissionState, active_state, assess, has_ended, with_overdue
from app.domain.lifecycles.recovery import RecoveryStep, note_stop
from app.domain.lifecycles.script import ask, order
from app.domain.mission_monitor import Verdict, cancelled, review
from app.missions.clearance import next_time_s, renew_clearances
from app.missions.dispatch import ScriptDispatcher
from app.missions.ending import end_mission, finish_parts
from app.missions.mission_view import MissionViews, scripts_of_all_plans
from app.missions.recovery import RecoverySteps
from app.planning.tenders import Tenders
from app.planning.waiting_goals import WaitingGoals
from app.store import MissionRow, ScriptRow
from app.store.records import lock_mission
from app.workflows import or_give_up, sleep_until_woken, step
from robots.clock import Clock
from robots.wire import ControlVerb, FailureCategory

LONGEST_SLEEP_S = 30.0
SHORTEST_SLEEP_S = 0.1
"""The bounds of a sleep between two reviews (wall clock)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldTime:
    """A world's clock, its current rate and the delay of its radio.

    :param rate: world seconds per wall-clock second; None: as fast as possible.
    :param answer_s: world seconds that a message to a robot and its answer may take by radio.
    """

    clock: Clock
    rate: Callable[[], float | None]
    answer_s: float = 0.0

    @classmethod
    def of(cls, world: RunningWorld) -> Self:
        return cls(clock=world.clock, rate=world.pace, answer_s=world.file.answer_s)

    def patience_s(self, wall_s: float) -> float:
        """Wall-clock seconds that an answer may take: `wall_s` and the radio's time.

        A world that runs as fast as possible is taken to run at least in real time.
        """
        return wall_s + self.answer_s / (self.rate() or 1.0)

    def wall_s(self, world_s: float) -> float:
        """Wall-clock seconds to sleep for a span of the world's time, bounded on both sides."""
        rate = self.rate()
        wall_s = world_s / rate if rate else SHORTEST_SLEEP_S
        return min(max(wall_s, SHORTEST_SLEEP_S), LONGEST_SLEEP_S)


class MissionLife:
    """The steps of a mission and the workflow that runs them."""

    def __init__(
        self,
        core: Core,
        *,
        dispatcher: ScriptDispatcher,
        times: Mapping[str, WorldTime],
        patience_s: float,
        recovery: RecoverySteps,
        waiting: WaitingGoals,
        silent_in_s: Callable[[str], float],
        tenders: Tenders | None = None,
        stands: Callable[[str], bool] = lambda world: False,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param patience_s: wall-clock seconds a robot may take to answer before it counts as silent.
        :param stands: whether a world stands at a breakpoint now; its robots answer nothing meanwhile.
        :param tenders: None: robots do not bid for goals.
        :param silent_in_s: least world seconds until a robot's silence is longer than its radio explains.
        """
        self._core = core
        self._database = core.database
        self._events = core.events
        self._views = MissionViews(core, silent_in_s=silent_in_s)
        self._dispatcher = dispatcher
        self._recovery = recovery
        self._tenders = tenders
        self._waiting = waiting
        self._times = times
        self._patience_s = patience_s
        self._stands = stands
        self._clock = clock

    def run(self, mission_id: str) -> None:
        """The workflow. A step that keeps failing ends the mission, so that its robots are released."""
        or_give_up(lambda: self._run(mission_id), partial(self._give_up, mission_id))

    def _run(self, mission_id: str) -> None:
        while (sleep_s := step("monitor", lambda: self.monitor(mission_id))) is not None:
            sleep_until_woken(sleep_s)

    def _dispatch(self, session: Session, mission: MissionRow) -> bool:
        """Turn the plan-net into scripts for the agent models to deliver; False if that ended the mission."""
        if mission.cancel_requested:
            self._close(session, mission, cancelled())
            return False
        times = self._times[mission.world]
        why_not = self._dispatcher.dispatch(session, mission, times.clock.now_s(), answer_s=times.answer_s)
        if why_not:
            self._fail(session, mission, why_not)
        return not why_not

    def monitor(self, mission_id: str) -> float | None:
        """Review the mission once and act on the verdict; returns how long to sleep (wall clock), None at its end.

        Before that, the scripts of a plan that has none yet are made.
        """
        with self._database.write() as session:
            mission = lock_mission(session, mission_id)
            if has_ended(mission):
                return None
            scripts = scripts_of_all_plans(session, mission_id)
            if all(script.plan_id != mission.plan_id for script in scripts):
                if not self._dispatch(session, mission):
                    return None
                scripts = scripts_of_all_plans(session, mission_id)
            times = self._times[mission.world]
            now_s = times.clock.now_s()
            monotonic_s = self._clock.monotonic_s()
            current = [script for script in scripts if script.plan_id == mission.plan_id]
            renew_clearances(session, self._events, mission, current, now_s=now_s)
            finish_parts(session, self._core, mission, current)
            until_s = next_time_s(current)
            if mission.asked_at is not None and self._stands(mission.world):
                self._note_asked(mission)  # they have the time to answer once their world goes on
            view = self._views.of(session, mission, scripts, now_s=now_s, monotonic_s=monotonic_s)
            verdict = review(view, patience_s=times.patience_s(self._patience_s))
            if verdict.state.ended:
                self._close(session, mission, verdict)
                return None
            if verdict.cancel and not view.troubles and not view.cancel_requested:
                note_stop(mission, view.why)
            self._act(session, mission, scripts, verdict, view.now_s)
            if verdict.recover is not None:
                self._recovery.take(session, mission, view, verdict)
            if verdict.state is MissionState.UNKNOWN or mission.recovery_step not in (
                None,
                RecoveryStep.WAITING,
            ):
                return LONGEST_SLEEP_S  # an answer, a plan or a decision wakes the workflow
            if mission.asked_at is not None:
                return min(self._patience_s, 1.0)
            wait_s = verdict.wait_s if until_s is None else min(verdict.wait_s, until_s - now_s)
            return times.wall_s(wait_s)

    def _act(
        self,
        session: Session,
        mission: MissionRow,
        scripts: Sequence[ScriptRow],
        verdict: Verdict,
        now_s: float,
    ) -> None:
        for script in scripts:
            if script.plan_id != mission.plan_id:
                continue
            if script.robot in verdict.cancel:
                order(script, ControlVerb.CANCEL)
            if script.robot in verdict.ask:
                ask(script, f"{script.id}:status:{now_s:.3f}")
        if verdict.ask or verdict.cancel:
            self._note_asked(mission)
        if verdict.enquire_at_s is not None:
            mission.asked_at = None
            mission.enquire_at_s = verdict.enquire_at_s
            if mission.started_at_s is not None:
                estimate_s = verdict.enquire_at_s - mission.started_at_s - mission.margin_s
                mission.estimate_s = max(estimate_s, mission.original_estimate_s)
        self._assess(session, mission, verdict)

    def _note_asked(self, mission: MissionRow) -> None:
        """The mission's robots are asked now."""
        mission.asked_at = self._clock.epoch_s()
        self._views.note_asked(mission, self._clock.monotonic_s())

    def _assess(self, session: Session, mission: MissionRow, verdict: Verdict) -> None:
        """Record the monitor's assessment, with events for what is new."""
        same_state = verdict.state in (MissionState.PAUSED, active_state(mission))
        newly_overdue = verdict.is_overdue and not mission.is_overdue
        if same_state and mission.reason == verdict.reason and not newly_overdue:
            return
        assess(
            mission,
            verdict.state,
            reason=verdict.reason,
            failure=verdict.failure,
            is_overdue=verdict.is_overdue,
        )
        shown = MissionState(mission.state)
        if newly_overdue:
            late = MissionOverdue(subject=mission.id, deadline_s=mission.deadline_s, state=shown)
            self._events.append(session, late)
        if not same_state or verdict.ask or verdict.cancel:
            reason = with_overdue(verdict.reason, is_overdue=verdict.is_overdue)
            told = MissionRobotsAsked if verdict.ask else MISSION_PHASES[verdict.state]
            self._events.append(session, told(subject=mission.id, reason=reason, state=shown))

    def _give_up(self, mission_id: str, reason: str) -> None:
        with self._database.write() as session:
            mission = lock_mission(session, mission_id)
            if not has_ended(mission):
                self._fail(session, mission, reason)

    def _fail(self, session: Session, mission: MissionRow, reason: str) -> None:
        verdict = Verdict(
            state=MissionState.FAILED, wait_s=0, reason=reason, failure=FailureCategory.INTERNAL
        )
        self._close(session, mission, verdict)

    def _close(self, session: Session, mission: MissionRow, verdict: Verdict) -> None:
        self._views.forget(mission.id)
        if self._tenders is not None:
            self._tenders.settle(session, mission)
        end_mission(
            session,
            self._events,
            mission,
            state=verdict.state,
            reason=verdict.reason,
            failure=verdict.failure,
            now_s=self._times[mission.world].clock.now_s(),
        )
        self._waiting.release(session, mission.world)
