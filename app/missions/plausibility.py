"""Compares robots' reports with what is known of their world: its clock, its places and their telemetry."""

from collections.abc import Callable, Iterable, Mapping, Sequence

from sqlalchemy.orm import Session

from app.agents import RobotBoard
from app.core import Core
from app.domain.contradictions import told_of
from app.domain.lifecycles.script import has_terminated
from app.domain.plausibility import (
    PLACE_M,
    SIGHT_M,
    Presence,
    Work,
    doubt_of_finish,
    doubt_of_order,
    doubt_of_place,
    doubt_of_progress,
    doubt_of_time,
)
from app.domain.world_model.beliefs import ROBOT_POSITION
from app.missions.clearance import begun_by, begun_uncleared, finished_by, packets_of, said_with
from app.missions.contradictions import parts_of
from app.missions.delegation import DONE_BY, granted_to
from app.missions.rivals import Rivals
from app.store import ScriptRow
from planner import PlanNet
from robots.clock import Clock
from robots.wire import (
    DelegationReport,
    Message,
    PacketReport,
    PacketState,
    SampleReport,
    ScriptReport,
    ScriptState,
    StatusReport,
    SymbolicFact,
    UpkeepReport,
)
from robots.world import WorldFile

Report = PacketReport | ScriptReport | StatusReport | UpkeepReport


class Plausibility:
    """Judges reports before they are recorded."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        clocks: Mapping[str, Clock],
        lags_s: Mapping[str, Callable[[], float]],
        board: RobotBoard,
    ) -> None:
        """
        :param clocks: by world.
        :param lags_s: by world, how far the service's reading of its clock may be behind.
        """
        self.rivals = Rivals(core, worlds=worlds, clocks=clocks, board=board)
        self._plan_nets = core.plan_nets
        self._clocks = clocks
        self._lags_s = lags_s
        self._board = board
        self._worlds = worlds

    def doubt(
        self,
        session: Session,
        message: Message,
        world: str,
        script: ScriptRow | None,
        scripts: Sequence[ScriptRow] = (),
    ) -> str:
        """Why a robot's report is implausible, perhaps only at present; empty if it is plausible.

        :param script: the script that it reports on, locked; None for its upkeep.
        :param scripts: all of the same plan.
        """
        report = message.body
        if not isinstance(report, Report | DelegationReport):
            return ""
        now_s = self._clocks[world].now_s()
        lag_s = self._lags_s[world]()
        early = doubt_of_time(report.at_s, now_s=now_s, lag_s=lag_s)
        if early or isinstance(report, StatusReport | DelegationReport) or _tells_nothing(report, script):
            return early
        if script is not None and (packet := begun_by(report, script)) is not None:
            out_of_order = self._doubt_of_order(session, script, scripts, packet, report=report, now_s=now_s)
            if out_of_order:
                return out_of_order
        if script is not None and (packet := finished_by(report, script)) is not None:
            doubt = self._doubt_of_finish(
                session, script, packet, world=world, at_s=report.at_s, now_s=now_s, lag_s=lag_s
            )
            return doubt or self._doubt_of_rival(session, report, world, script, scripts)
        if isinstance(report, PacketReport):  # its percepts are not used, because its script goes on
            return ""
        return self._doubt_of_percepts(message.sender, report.perceived, report.at_s, world=world)

    def _doubt_of_rival(
        self, session: Session, report: Report, world: str, script: ScriptRow, scripts: Sequence[ScriptRow]
    ) -> str:
        found = self.rivals.of(session, report, world, script, scripts)
        if found is None:
            return ""
        ended, rival = found
        tag = ended.net.action(ended.action).tag
        return f"reports to have ended {ended.action} {tag} at {ended.at_s:.1f} s, but {rival.told}"

    def doubt_of_sample(self, robot: str, report: SampleReport, world: str) -> str:
        """Why a report of an unknown sample is implausible; empty if it is plausible."""
        lag_s = self._lags_s[world]()
        early = doubt_of_time(report.at_s, now_s=self._clocks[world].now_s(), lag_s=lag_s)
        seen = SymbolicFact(predicate="in", args=(report.sample, report.place))
        return early or self._doubt_of_percepts(robot, [seen], report.at_s, world=world)

    def _doubt_of_order(
        self,
        session: Session,
        script: ScriptRow,
        scripts: Sequence[ScriptRow],
        packet: str,
        *,
        report: Report,
        now_s: float,
    ) -> str:
        pair = begun_uncleared(packet, script, scripts, said_with(report))
        if pair is None:
            return ""
        net = self._plan_nets.of(session, script.plan_id)
        parts = parts_of(scripts)
        begun, awaited = pair
        return doubt_of_order(
            told_of(net, parts, begun, script.robot),
            [told_of(net, parts, awaited, robot) for robot in net.action(awaited).agents],
            at_s=report.at_s,
            now_s=now_s,
        )

    def _doubt_of_finish(
        self,
        session: Session,
        script: ScriptRow,
        packet: str,
        *,
        world: str,
        at_s: float,
        now_s: float,
        lag_s: float,
    ) -> str:
        work = _work(script, self._plan_nets.of(session, script.plan_id))
        presence = self._presence(script.robot)
        doubt = doubt_of_finish(work, packet, at_s, now_s=now_s, lag_s=lag_s)
        if doubt or presence is None:
            return doubt
        action = self._plan_nets.of(session, script.plan_id).action(packet)
        ends = (
            f.args[2] for f in action.effects if f.args[0] == script.robot and f.predicate == ROBOT_POSITION
        )
        longest_m = self._longest_m(world, action.arguments.values())
        return doubt_of_progress(work, packet, at_s, presence.telemetry) or self._doubt_of_places(
            ends, presence, at_s, world=world, within_m=PLACE_M + longest_m
        )

    def _doubt_of_percepts(
        self, robot: str, perceived: Iterable[SymbolicFact], at_s: float, *, world: str
    ) -> str:
        presence = self._presence(robot)
        if presence is None:
            return ""
        longest_m = self._longest_m(world, self._worlds[world].lengths_m)
        for fact in perceived:
            within_m = (SIGHT_M if fact.predicate == "in" else PLACE_M) + longest_m
            places = fact.args[1:] if fact.predicate in ("in", "at", "near") else ()
            if doubt := self._doubt_of_places(places, presence, at_s, world=world, within_m=within_m):
                return doubt
        return ""

    def _doubt_of_places(
        self, places: Iterable[str], presence: Presence, at_s: float, *, world: str, within_m: float
    ) -> str:
        points = self._worlds[world].points
        doubts = (
            doubt_of_place(place, points[place], at_s, presence, within_m=within_m)
            for place in places
            if place in points
        )
        return next(filter(None, doubts), "")

    def _presence(self, robot: str) -> Presence | None:
        view = self._board.view(robot)
        spec = self._worlds[view.world].robots_by_name.get(robot)
        if view.telemetry is None or spec is None:  # doors, hatches and lifts stand where they are
            return None
        return Presence(telemetry=view.telemetry, speed_m_s=spec.speed_m_s)

    def _longest_m(self, world: str, things: Iterable[str]) -> float:
        """The greatest length of the objects: a robot at the handle of a long one is off the object's place by that."""
        lengths_m = self._worlds[world].lengths_m
        return max((lengths_m.get(thing, 0.0) for thing in things), default=0.0)


def _tells_nothing(report: Report, script: ScriptRow | None) -> bool:
    """True of what changes nothing; and of what another robot has done: not where this one is, and has been."""
    return _changes_nothing(report, script) or _is_done_by_another(report, script)


def _changes_nothing(report: Report, script: ScriptRow | None) -> bool:
    """True if the script, or the packet, has ended already."""
    match report:
        case ScriptReport() if script is not None:
            return has_terminated(script)
        case PacketReport(packet_id=packet) if script is not None:
            return script.packets.get(packet, {}).get("state") in (PacketState.FINISHED, PacketState.FAILED)
    return False


def _is_done_by_another(report: Report, script: ScriptRow | None) -> bool:
    """True if it tells the end of the script, whose last packet another robot has done."""
    if script is None or not isinstance(report, ScriptReport) or report.state is not ScriptState.FINISHED:
        return False
    last = packets_of(script)[-1]
    return last in granted_to(script, report.done_by) or DONE_BY in script.packets.get(last, {})


def _work(script: ScriptRow, net: PlanNet) -> Work:
    """NOTE: what lasts as long as a number needs is over at once if the number is there already."""
    packets = script.body["packets"]
    as_needed = {action.id for action in net.actions if action.level is not None}
    phase_of = {action.id: action.phase for action in net.actions}
    firsts: list[int] = []
    for number, packet in enumerate(packets):
        goes_on = number > 0 and phase_of.get(packet["id"], 0) > 1
        firsts.append(firsts[-1] if goes_on else number)
    return Work(
        script_id=script.id,
        ids=[packet["id"] for packet in packets],
        tags=[packet["tag"] for packet in packets],
        expected_s=[
            0.0 if packet["id"] in as_needed else packet["expected_duration_s"] for packet in packets
        ],
        firsts=firsts,
        known=script.packets,
        given_at_s=script.given_at_s,
    )
