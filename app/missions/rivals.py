"""Reads what others have told of what a robot reports to have ended: their telemetry and the record's facts."""

from collections.abc import Callable, Collection, Mapping, Sequence
from math import dist

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.agents import RobotBoard
from app.core import Core
from app.domain.contradictions import HELD_S
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.script import has_terminated
from app.domain.plausibility import PLACE_M
from app.domain.rivals import (
    Ended,
    Rival,
    Seen,
    arrives_at,
    believed_occupant,
    holder_after_grip,
    holder_until_release,
    may_have_left,
    occupants,
    place_until_release,
    released_alone,
    shows_occupant,
)
from app.domain.world_model.beliefs import IN_AREA
from app.domain.world_model.timeliness import DatedFact
from app.domain.world_model.vocabulary import symbolic
from app.missions.clearance import finished_by, packets_of
from app.missions.contradictions import parts_of, recorded
from app.store import MissionRow, ScriptRow
from app.store.facts import source_of
from planner import Fact
from robots.clock import Clock
from robots.wire import PacketReport, PacketState, ScriptReport
from robots.world import WorldFile

FINISHED = PacketState.FINISHED


class Rivals:
    """Finds what rules out a report, inside the caller's transaction."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        clocks: Mapping[str, Clock],
        board: RobotBoard,
    ) -> None:
        """:param clocks: by world."""
        self._facts = core.facts
        self._knowledge_base = core.knowledge_base
        self._plan_nets = core.plan_nets
        self._worlds = worlds
        self._clocks = clocks
        self._board = board

    def of(
        self, session: Session, report: object, world: str, script: ScriptRow, scripts: Sequence[ScriptRow]
    ) -> tuple[Ended, Rival] | None:
        """What does not fit to the end that a robot reports, or to an earlier one that is held back for that; None if
        nothing does, or if the mission has noted it.

        :param scripts: all of the same plan.
        """
        packet = finished_by(report, script)
        if packet is None or not isinstance(report, PacketReport | ScriptReport):
            return None
        ids = packets_of(script)
        held_back = {
            one: known["doubted_at_s"]
            for one in ids[: ids.index(packet)]
            if "doubted_at_s" in (known := script.packets.get(one, {})) and known["state"] != FINISHED
        }
        for name, at_s in {**held_back, packet: report.at_s}.items():
            ended = Ended(
                net=self._plan_nets.of(session, script.plan_id),
                action=name,
                robot=script.robot,
                at_s=at_s,
                parts=parts_of(scripts),
                given_at_s=script.given_at_s,
            )
            rival = self._of(session, ended, world, scripts)
            if rival is not None and not _is_noted(session, ended, script):
                return ended, rival
        return None

    def _of(self, session: Session, ended: Ended, world: str, scripts: Sequence[ScriptRow]) -> Rival | None:
        at_work = {one.robot for one in scripts if not has_terminated(one)}
        others = self._others(ended, world)
        return (
            holder_after_grip(ended, [one for one in others if one.robot in at_work])
            or self._of_release(session, ended, world)
            or self._of_arrival(session, ended, world)
        )

    def _of_release(self, session: Session, ended: Ended, world: str) -> Rival | None:
        if not released_alone(ended.net, ended.action, ended.robot):
            return None
        if rival := holder_until_release(ended, self._others(ended, world)):
            return rival
        facts = self._facts.read_locked(session, world).believed
        return place_until_release(ended, facts, self._words, own_source=source_of(ended.robot))

    def _of_arrival(self, session: Session, ended: Ended, world: str) -> Rival | None:
        target = arrives_at(ended.net, ended.action, ended.robot)
        if target is None:
            return None
        facts = self._facts.read_locked(session, world).believed
        point = self._worlds[world].points.get(target[0])
        seen = {one.robot: one for one in self._others(ended, world)}
        for belief in occupants(ended, facts, _of_predicate(facts, IN_AREA)):
            robot = belief.fact.args[0]
            known = seen.get(robot)
            if known is not None and point is not None:
                if rival := shows_occupant(ended, belief, known, point):
                    return rival
                here = (known.telemetry.x_m, known.telemetry.y_m)
                if known.telemetry.at_s > belief.at_s and dist(point, here) > PLACE_M:
                    continue  # its pose is newer: it stands elsewhere
            said = None if known is None else known.telemetry
            if may_have_left(ended, belief.fact, said) or _is_at_work(session, robot):
                continue
            is_certain = self._clocks[world].now_s() - ended.at_s >= HELD_S
            return believed_occupant(belief, self._words, is_certain=is_certain)
        return None

    def _others(self, ended: Ended, world: str) -> list[Seen]:
        agents = ended.net.action(ended.action).agents
        views = self._board.views(world)
        return [
            Seen(robot=name, telemetry=view.telemetry, holding_since_s=view.holding_since_s)
            for name, view in views.items()
            if view.telemetry is not None and name not in agents
        ]

    @property
    def _words(self) -> Callable[[Fact], str]:
        return lambda fact: str(symbolic(fact, self._knowledge_base))


def _of_predicate(facts: Collection[DatedFact], predicate: str) -> frozenset[Fact]:
    return frozenset(one.fact for one in facts if one.fact.predicate == predicate)


def _is_noted(session: Session, ended: Ended, script: ScriptRow) -> bool:
    mission = session.get_one(MissionRow, script.mission_id)
    later = (one.later for one in recorded(mission) if one.plan_id == script.plan_id)
    return any((one.packet, one.robot) == (ended.action, ended.robot) for one in later)


def _is_at_work(session: Session, robot: str) -> bool:
    """True if the robot has a script of a mission that goes on: it may have left, and its report be under way."""
    query = (
        select(ScriptRow)
        .join(MissionRow, MissionRow.id == ScriptRow.mission_id)
        .where(
            ScriptRow.robot == robot,
            MissionRow.state.in_([state.value for state in MissionState if not state.ended]),
        )
    )
    return any(not has_terminated(script) for script in session.scalars(query))
