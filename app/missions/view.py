"""A mission as its record shows it to the monitor's rules."""

import time
from collections.abc import Sequence
from threading import Lock

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.database import MissionRow, ScriptRow
from app.missions.monitor import EXTENSION_S, MissionView, ScriptView
from app.recovery.links import cut
from app.recovery.progress import begun, done, no_way
from app.recovery.rules import Policy, Step
from app.states import MissionState
from app.vocabulary import symbolic
from planner import Fact
from robots.wire import FailureCategory, PacketState, ScriptState

Known = tuple[tuple[str, ...], tuple[str, ...]]


class MissionViews:
    """Reads missions; what they count on is held against the facts only when either has changed."""

    def __init__(self, core: Core) -> None:
        self._core, self._lock = core, Lock()
        self._known: dict[str, tuple[object, Known]] = {}

    def of(
        self, session: Session, mission: MissionRow, scripts: Sequence[ScriptRow], now_s: float
    ) -> MissionView:
        """:param scripts: all of the mission's, of every plan it had."""
        current = [script for script in scripts if script.plan_id == mission.plan_id]
        missed, lacking = self._beliefs(session, mission, current)
        return MissionView(
            state=MissionState(mission.state),
            now_s=now_s,
            enquire_at_s=mission.enquire_at_s if mission.enquire_at_s is not None else now_s + EXTENSION_S,
            estimate_s=mission.original_estimate_s,
            asked_for_s=None if mission.asked_at is None else time.time() - mission.asked_at,
            cancel_requested=mission.cancel_requested,
            scripts=[_script(script) for script in current],
            missed=missed,
            cut=lacking,
            policy=Policy(mission.recovery),
            step=None if mission.recovery_step is None else Step(mission.recovery_step),
            tries_left=mission.tries_left,
            no_way=no_way(mission),
            done_before=any(
                script.state == ScriptState.FINISHED for script in scripts if script not in current
            ),
            reason=mission.reason,
            stopped_for=mission.stopped_for,
        )

    def forget(self, mission_id: str) -> None:
        with self._lock:
            self._known.pop(mission_id, None)

    def _beliefs(self, session: Session, mission: MissionRow, scripts: Sequence[ScriptRow]) -> Known:
        """The goals that are not believed true, and what the plan counts on that is not, in words."""
        begun_, done_ = begun(scripts), done(scripts)
        key = (self._core.facts.version(session, mission.world), mission.plan_id, begun_, done_)
        with self._lock:
            before, known = self._known.get(mission.id, (None, ((), ())))
        if before == key:
            return known
        net = self._core.plan_nets.of(session, mission.plan_id)
        facts = self._core.facts.facts(session, mission.world)
        links = cut(net, facts, begun=begun_, done=done_)
        missed = tuple(self._said(goal) for goal in net.goals if goal not in facts)
        known = (missed, tuple(dict.fromkeys(self._said(link.fact) for link in links)))
        with self._lock:
            self._known[mission.id] = (key, known)
        return known

    def _said(self, fact: Fact) -> str:
        return str(symbolic(fact, self._core.knowledge_base))


def scripts_of_all_plans(session: Session, mission_id: str) -> Sequence[ScriptRow]:
    query = select(ScriptRow).where(ScriptRow.mission_id == mission_id).order_by(ScriptRow.id)
    return session.scalars(query).all()


def _failed_at(script: ScriptRow) -> str:
    """The tag of the packet that failed, as far as it was reported."""
    tags = {packet["id"]: packet["tag"] for packet in script.body["packets"]}
    failed = (known["state"] == PacketState.FAILED and tags[name] for name, known in script.packets.items())
    return next(filter(None, failed), "")


def _script(script: ScriptRow) -> ScriptView:
    return ScriptView(
        robot=script.robot,
        delivery=script.delivery,
        state=None if script.state is None else ScriptState(script.state),
        open_question=script.question is not None,
        stopping=script.stopping,
        category=None if script.category is None else FailureCategory(script.category),
        detail=script.detail,
        abandoned=script.abandoned,
        failed_at=_failed_at(script),
    )
