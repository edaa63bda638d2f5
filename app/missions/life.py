"""A mission's life as a durable workflow: organise, dispatch, monitor, conclude.

Every step reads the record and writes it in one transaction, so a step that runs again after a crash finds what it did
before and does nothing twice. Between steps the workflow sleeps until a report or the monitor's next instant.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.database import MissionRow, PlanRow, ScriptRow
from app.durable import StepFailed, sleep_until_woken, step
from app.missions.ending import end_mission
from app.missions.monitor import EXTENSION_S, MissionView, ScriptView, Verdict, review
from app.organiser import Library, OrganiserFailure, organise
from app.plan_body import PlanBody
from app.states import MissionState
from app.vocabulary import symbolic
from robots.clock import Clock
from robots.wire import BehaviourScript, FailureCategory, ScriptState

WORKFLOW = "mission_life"
LONGEST_SLEEP_S = 30.0
SHORTEST_SLEEP_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldTime:
    """A world's clock, its rate now (world seconds a wall-clock second, None flat out) and its radio's pace.

    :param answer_s: world seconds that an answer from a robot that is in order may take by its radio.
    """

    clock: Clock
    rate: Callable[[], float | None]
    answer_s: float = 0.0

    def patience_s(self, wall_s: float) -> float:
        """Wall-clock seconds that an answer may take: so many by itself, and the radio's time. Flat out is not slower
        than real time.
        """
        return wall_s + self.answer_s / (self.rate() or 1.0)

    def wall_s(self, world_s: float) -> float:
        """Wall-clock seconds to sleep for a span of the world's time, bounded on both sides."""
        rate = self.rate()
        wall_s = world_s / rate if rate else SHORTEST_SLEEP_S
        return min(max(wall_s, SHORTEST_SLEEP_S), LONGEST_SLEEP_S)


class MissionLife:
    """The steps of a mission and the workflow that strings them together."""

    def __init__(
        self,
        core: Core,
        *,
        library: Library,
        repertoires: Mapping[str, Mapping[str, Sequence[str]]],
        times: Mapping[str, WorldTime],
        patience_s: float,
        freed: Callable[[Session, str], None],
    ) -> None:
        """
        :param repertoires: by world and robot, the packet tags the robot can carry out.
        :param patience_s: wall-clock seconds a robot may take to answer before it counts as silent.
        :param freed: called in the closing transaction with the world whose robots are free again.
        """
        self._database, self._events, self._facts = core.database, core.events, core.facts
        self._freed = freed
        self._knowledge_base, self._library, self._repertoires = core.knowledge_base, library, repertoires
        self._times, self._patience_s = times, patience_s

    def run(self, mission_id: str) -> None:
        """The workflow. A step that keeps failing ends the mission, so that it does not hold its robots for ever."""
        try:
            if not step("organise", lambda: self._organise(mission_id)):
                return
            while (sleep_s := step("monitor", lambda: self._monitor(mission_id))) is not None:
                sleep_until_woken(sleep_s)
        except StepFailed as failure:
            reason = str(failure)
            step("give up", lambda: self._give_up(mission_id, reason))

    def _organise(self, mission_id: str) -> bool:
        """Turn the plan-net into scripts and hand them to the agent models; False if it cannot be."""
        with self._database.write() as session:
            mission = session.get_one(MissionRow, mission_id, with_for_update=True)
            if MissionState(mission.state).ended:
                return False
            if session.scalars(select(ScriptRow.id).where(ScriptRow.mission_id == mission_id)).first():
                return True
            plan = session.get_one(PlanRow, mission.plan_id)
            organised = organise(
                PlanBody.model_validate(plan.body).to_plan_net(self._knowledge_base),
                self._library,
                self._repertoires[mission.world],
                mission_id,
                self._knowledge_base,
                answer_s=self._times[mission.world].answer_s,
            )
            now_s = self._times[mission.world].clock.now_s()
            if isinstance(organised, OrganiserFailure):
                verdict = Verdict(
                    state=MissionState.FAILED,
                    wait_s=0,
                    reason=organised.reason,
                    failure=FailureCategory.INTERNAL,
                )
                self._close(session, mission, verdict)
                return False
            for script in organised.scripts:
                session.add(_script_row(script))
            if mission.state == MissionState.PAUSED:
                mission.resume_to = MissionState.DISPATCHING
            else:
                mission.state = MissionState.DISPATCHING
            mission.enquire_at_s = now_s + mission.estimate_s + mission.margin_s
            self._events.append(
                session, "mission.dispatching", mission.id, robots=[s.robot for s in organised.scripts]
            )
            return True

    def _monitor(self, mission_id: str) -> float | None:
        """Judge the mission once and act on it; answers how long to sleep (wall clock), None at its end."""
        with self._database.write() as session:
            mission = session.get_one(MissionRow, mission_id, with_for_update=True)
            if MissionState(mission.state).ended:
                return None
            scripts = session.scalars(select(ScriptRow).where(ScriptRow.mission_id == mission_id)).all()
            times = self._times[mission.world]
            now_s = times.clock.now_s()
            verdict = review(_view(mission, scripts, now_s), patience_s=times.patience_s(self._patience_s))
            if verdict.state.ended:
                self._close(session, mission, self._checked(session, mission, verdict))
                return None
            self._act(session, mission, scripts, verdict)
            if verdict.state is MissionState.UNKNOWN:
                return LONGEST_SLEEP_S  # an answer wakes the workflow
            if mission.asked_at is not None:
                return min(self._patience_s, 1.0)
            return times.wall_s(verdict.wait_s)

    def _checked(self, session: Session, mission: MissionRow, verdict: Verdict) -> Verdict:
        """Completed means that the goals are believed true, not only that every script has finished."""
        if verdict.state is not MissionState.COMPLETED:
            return verdict
        plan = PlanBody.model_validate(session.get_one(PlanRow, mission.plan_id).body)
        facts = self._facts.facts(session, mission.world)
        missed = [goal for goal in plan.to_plan_net(self._knowledge_base).goals if goal not in facts]
        if not missed:
            return verdict
        named = ", ".join(str(symbolic(goal, self._knowledge_base)) for goal in missed)
        return replace(
            verdict,
            state=MissionState.PARTIALLY_COMPLETED,
            failure=FailureCategory.WORLD_CHANGED,
            reason=f"every script has finished, but {named} is not true",
        )

    def _act(
        self, session: Session, mission: MissionRow, scripts: Sequence[ScriptRow], verdict: Verdict
    ) -> None:
        for script in scripts:
            if script.robot in verdict.cancel:
                script.orders += 1
                script.control, script.stopping = f"cancel:{script.orders}", True
            if script.robot in verdict.ask:
                script.question = f"{script.id}:status:{mission.enquire_at_s or 0:.3f}"
        if verdict.ask or verdict.cancel:
            mission.asked_at = time.time()
        if verdict.enquire_at_s is not None:
            mission.asked_at, mission.enquire_at_s = None, verdict.enquire_at_s
            mission.estimate_s = verdict.enquire_at_s - (mission.started_at_s or 0.0) - mission.margin_s
            mission.estimate_s = max(mission.estimate_s, mission.original_estimate_s)
        if (mission.state, mission.reason) != (verdict.state, verdict.reason):
            changed = mission.state != verdict.state or verdict.ask or verdict.cancel
            mission.state, mission.reason = verdict.state, verdict.reason
            mission.failure = verdict.failure
            if changed:
                type_ = "mission.robots_asked" if verdict.ask else f"mission.{verdict.state.value}"
                self._events.append(session, type_, mission.id, reason=verdict.reason)

    def _give_up(self, mission_id: str, reason: str) -> None:
        with self._database.write() as session:
            mission = session.get_one(MissionRow, mission_id, with_for_update=True)
            if not MissionState(mission.state).ended:
                verdict = Verdict(
                    state=MissionState.FAILED, wait_s=0, reason=reason, failure=FailureCategory.INTERNAL
                )
                self._close(session, mission, verdict)

    def _close(self, session: Session, mission: MissionRow, verdict: Verdict) -> None:
        end_mission(
            session,
            self._events,
            mission,
            state=verdict.state,
            reason=verdict.reason,
            failure=verdict.failure,
            now_s=self._times[mission.world].clock.now_s(),
        )
        self._freed(session, mission.world)


def _script_row(script: BehaviourScript) -> ScriptRow:
    return ScriptRow(
        id=script.id,
        mission_id=script.mission_id,
        robot=script.robot,
        body=script.model_dump(mode="json"),
        delivery="pending",
        packets={},
        perceived=[],
    )


def _view(mission: MissionRow, scripts: Sequence[ScriptRow], now_s: float) -> MissionView:
    return MissionView(
        state=MissionState(mission.state),
        now_s=now_s,
        enquire_at_s=mission.enquire_at_s if mission.enquire_at_s is not None else now_s + EXTENSION_S,
        estimate_s=mission.original_estimate_s,
        asked_for_s=None if mission.asked_at is None else time.time() - mission.asked_at,
        cancel_requested=mission.cancel_requested,
        scripts=[
            ScriptView(
                robot=script.robot,
                delivery=script.delivery,
                state=None if script.state is None else ScriptState(script.state),
                open_question=script.question is not None,
                stopping=script.stopping,
                category=None if script.category is None else FailureCategory(script.category),
                detail=script.detail,
            )
            for script in scripts
        ],
    )
