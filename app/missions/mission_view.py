"""Reads a mission from the record as the view that the monitor's rules take."""

from collections.abc import Callable, Mapping, Sequence
from threading import Lock
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.broken_links import broken_links
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.recovery import RecoveryStep, why_no_plan
from app.domain.lifecycles.script import Delivery
from app.domain.mission_monitor import EXTENSION_S, MissionView, ScriptView
from app.domain.recovery_rules import Policy
from app.domain.world_model.vocabulary import symbolic
from app.missions.clearance import counterparts
from app.missions.contradictions import recorded
from app.missions.mission_progress import begun, done
from app.missions.unheard import unheard_s
from app.store import MissionRow, ScriptRow
from app.store.records import lost_robot_reasons, unasked_robots
from planner import Fact
from robots.wire import FailureCategory, PacketState, ScriptState

REMEMBERED = 2000
"""The number of missions whose last comparison with the facts, and whose last question, is kept in memory."""

THINGS = ("object", "ref1", "ref2")
"""The arguments of packets that name things and places."""

Beliefs = tuple[tuple[str, ...], tuple[str, ...]]


class MissionViews:
    """Reads missions; their conditions are compared with the facts only when either has changed."""

    def __init__(self, core: Core, *, silent_in_s: Callable[[str], float]) -> None:
        """:param silent_in_s: least world seconds until a robot's silence is longer than its radio explains."""
        self._core = core
        self._silent_in_s = silent_in_s
        self._lock = Lock()
        self._known: dict[str, tuple[object, Beliefs]] = {}
        self._asked: dict[str, tuple[float, float]] = {}
        """By mission: `asked_at` of the open question, and the monotonic time since which it is known here."""

    def of(
        self,
        session: Session,
        mission: MissionRow,
        scripts: Sequence[ScriptRow],
        *,
        now_s: float,
        monotonic_s: float,
    ) -> MissionView:
        """
        :param scripts: all of the mission's, of every plan it had.
        :param now_s: the world's clock.
        """
        current = [script for script in scripts if script.plan_id == mission.plan_id]
        missed, broken = self._beliefs(session, mission, current)
        owing = unheard_s(current, now_s)
        any_lost = any(script.abandoned for script in current)
        lost = lost_robot_reasons(session, mission.world) if any_lost else {}
        unasked = {row.robot for row in unasked_robots(session, mission.world)}
        return MissionView(
            state=MissionState(mission.state),
            now_s=now_s,
            enquire_at_s=mission.enquire_at_s if mission.enquire_at_s is not None else now_s + EXTENSION_S,
            estimate_s=mission.original_estimate_s,
            asked_for_s=self._asked_for_s(mission, monotonic_s),
            cancel_requested=mission.cancel_requested,
            scripts=[
                _script(
                    script,
                    silent_in_s=self._silent_in_s(script.robot),
                    is_lost=script.robot in lost,
                    counterparts=counterparts(script, current) if script.doubt else (),
                    unheard_s=owing.get(script.robot, 0.0),
                    is_unasked=script.robot in unasked,
                )
                for script in current
            ],
            missed=missed,
            broken=broken,
            policy=Policy(mission.recovery),
            step=None if mission.recovery_step is None else RecoveryStep(mission.recovery_step),
            tries_left=mission.tries_left,
            no_way=why_no_plan(mission),
            done_before=any(
                script.state == ScriptState.FINISHED for script in scripts if script not in current
            ),
            reason=mission.reason,
            contradictions=[str(one) for one in recorded(mission) if one.plan_id == mission.plan_id],
            stopped_for=mission.stopped_for,
            replans=mission.replanning is not None,
            deadline_s=mission.deadline_s,
        )

    def note_asked(self, mission: MissionRow, monotonic_s: float) -> None:
        """Note that the mission's robots are asked now."""
        if mission.asked_at is not None:
            with self._lock:
                if len(self._asked) >= REMEMBERED:
                    self._asked.clear()
                self._asked[mission.id] = (mission.asked_at, monotonic_s)

    def forget(self, mission_id: str) -> None:
        with self._lock:
            self._known.pop(mission_id, None)
            self._asked.pop(mission_id, None)

    def _asked_for_s(self, mission: MissionRow, monotonic_s: float) -> float | None:
        """Seconds since the open question, by this process's monotonic clock; None without one.

        A process that takes over the mission counts from 0 again: wall clocks of two processes cannot be compared.
        """
        if mission.asked_at is None:
            return None
        with self._lock:
            asked_at, since_s = self._asked.get(mission.id, (None, monotonic_s))
        if asked_at != mission.asked_at:
            self.note_asked(mission, monotonic_s)
            return 0.0
        return monotonic_s - since_s

    def _beliefs(self, session: Session, mission: MissionRow, scripts: Sequence[ScriptRow]) -> Beliefs:
        """The goals, and the facts that the plan depends on, that are not believed, in words."""
        begun_ = begun(scripts)
        done_ = done(scripts)
        key = (self._core.facts.version(session, mission.world), mission.plan_id, begun_, done_)
        with self._lock:
            before, known = self._known.get(mission.id, (None, ((), ())))
        if before == key:
            return known
        net = self._core.plan_nets.of(session, mission.plan_id)
        facts = self._core.facts.counting_for(session, mission.world, net.goals, since_s=mission.started_at_s)
        links = broken_links(net, facts, begun=begun_, done=done_)
        missed = tuple(self._words(goal) for goal in net.goals if goal not in facts)
        known = (missed, tuple(dict.fromkeys(self._words(link.fact) for link in links)))
        with self._lock:
            if len(self._known) >= REMEMBERED:
                self._known.clear()
            self._known[mission.id] = (key, known)
        return known

    def _words(self, fact: Fact) -> str:
        return str(symbolic(fact, self._core.knowledge_base))


def scripts_of_all_plans(session: Session, mission_id: str) -> Sequence[ScriptRow]:
    query = select(ScriptRow).where(ScriptRow.mission_id == mission_id).order_by(ScriptRow.id)
    return session.scalars(query).all()


def _failed(script: ScriptRow) -> tuple[Mapping[str, Any], Mapping[str, Any]] | None:
    """The packet that failed and its recorded state; None if none was reported."""
    packets = {packet["id"]: packet for packet in script.body["packets"]}
    failed = (name for name, known in script.packets.items() if known["state"] == PacketState.FAILED)
    name = next(failed, None)
    return None if name is None else (packets[name], script.packets[name])


def _waited(packet: Mapping[str, Any], known: Mapping[str, Any]) -> bool:
    """True if the packet never began, and waits for other robots."""
    return "started_at_s" not in known and bool(packet.get("awaits") or packet.get("after"))


def _about(packet: Mapping[str, Any]) -> tuple[str, ...]:
    """The things and places of the packet's arguments."""
    return tuple(value for name, value in packet["arguments"].items() if name in THINGS)


def _script(
    script: ScriptRow,
    *,
    silent_in_s: float,
    is_lost: bool,
    counterparts: tuple[str, ...],
    unheard_s: float,
    is_unasked: bool,
) -> ScriptView:
    failed = _failed(script)
    return ScriptView(
        robot=script.robot,
        delivery=Delivery(script.delivery),
        state=None if script.state is None else ScriptState(script.state),
        open_question=script.question is not None,
        stopping=script.stopping,
        category=None if script.category is None else FailureCategory(script.category),
        detail=script.detail,
        abandoned=script.abandoned,
        found=script.abandoned and not is_lost,
        failed_at=failed[0]["tag"] if failed else "",
        about=_about(failed[0]) if failed else (),
        waited=failed is not None and _waited(*failed),
        script_id=script.id,
        silent_in_s=silent_in_s,
        doubt=script.doubt,
        counterparts=counterparts,
        unheard_s=unheard_s,
        is_unasked=is_unasked,
    )
