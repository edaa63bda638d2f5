"""Notices that robots' reports contradict each other: the mission keeps both, and what they are about is unknown."""

from collections.abc import Iterable, Sequence

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.contradictions import Contradiction, Parts, Told, contradictions
from app.domain.events import ContradictingReport, ReportsContradict
from app.domain.lifecycles.mission import MissionState
from app.domain.rivals import Ended, Rival
from app.domain.world_model import belief_change
from app.domain.world_model.beliefs import OBJECT_POSITION
from app.missions.clearance import begun_by, begun_uncleared, packets_of, said_with
from app.store import MissionRow, ScriptRow
from robots.wire import PacketReport, PacketState, ScriptReport


class ContradictionRecord:
    """Compares what the robots of a plan have reported, inside the caller's transaction."""

    def __init__(self, core: Core) -> None:
        self._events = core.events
        self._facts = core.facts
        self._plan_nets = core.plan_nets
        self._workflows = core.workflows

    def note(self, session: Session, mission: MissionRow, scripts: Sequence[ScriptRow]) -> None:
        """Record contradictions that are new: the places of what they are about are no longer believed.

        :param scripts: all of the plan that the mission carries out now.
        """
        net = self._plan_nets.of(session, mission.plan_id)
        self._add(session, mission, contradictions(net, parts_of(scripts), plan_id=mission.plan_id))

    def note_rival(
        self, session: Session, mission: MissionRow, script: ScriptRow, ended: Ended, rival: Rival
    ) -> None:
        """Record that what a robot reports to have ended does not fit to what others have told.

        While news may be under way, only keep when it says to have ended it: what comes after waits for that, too.
        """
        if not rival.is_certain:
            known = script.packets.get(ended.action, {"state": PacketState.WAITING.value})
            script.packets = {**script.packets, ended.action: {**known, "doubted_at_s": ended.at_s}}
            return
        later = Told(
            robot=ended.robot,
            packet=ended.action,
            tag=ended.net.action(ended.action).tag,
            state=PacketState.FINISHED,
            at_s=ended.at_s,
        )
        one = Contradiction(plan_id=mission.plan_id, earlier=rival.told, later=later, things=rival.things)
        self._add(session, mission, [one])
        self._workflows.wake(session, mission.workflow)

    def _add(self, session: Session, mission: MissionRow, found: Iterable[Contradiction]) -> None:
        known = {one.key for one in recorded(mission)}
        for one in found:
            if one.key in known:
                continue
            known.add(one.key)
            mission.contradictions = [*mission.contradictions, one.to_json()]
            self._events.append(session, _event(mission, one))
            self._doubt_places(session, mission, one)

    def _doubt_places(self, session: Session, mission: MissionRow, one: Contradiction) -> None:
        if not one.things:
            return
        world = self._facts.read_locked(session, mission.world)
        gone = [
            fact for fact in world.facts if fact.predicate == OBJECT_POSITION and fact.args[0] in one.things
        ]
        change = belief_change(world.facts, (), gone)
        world.change(
            add=change.add,
            remove=change.remove,
            source=f"contradicting reports of {one.later.robot} and {one.earlier.robot}",
            at_s=max(told.at_s for told in one.reports if told.at_s is not None),
            corrects=True,
        )


def note_claim(report: object, script: ScriptRow, scripts: Sequence[ScriptRow]) -> None:
    """Keep when a robot says to have begun what it is not cleared for, though its report is held back.

    :param scripts: all of the same plan.
    """
    packet = begun_by(report, script)
    pair = None if packet is None else begun_uncleared(packet, script, scripts, said_with(report))
    if pair is None or not isinstance(report, PacketReport | ScriptReport):
        return
    known = script.packets.get(pair[0], {"state": PacketState.WAITING.value})
    said_s = min(known.get("claimed_at_s", report.at_s), report.at_s)
    script.packets = {**script.packets, pair[0]: {**known, "claimed_at_s": said_s}}


def recorded(mission: MissionRow) -> Sequence[Contradiction]:
    """The contradictions in what the mission's robots have reported, of all its plans."""
    return [Contradiction.from_json(one) for one in mission.contradictions]


def disputed(mission: MissionRow, plan_id: str) -> frozenset[str]:
    """The things about which this plan's robots contradict each other: their reports do not tell where these are."""
    return frozenset(thing for one in recorded(mission) if one.plan_id == plan_id for thing in one.things)


def parts_of(scripts: Iterable[ScriptRow]) -> Parts:
    return {
        (packet, script.robot): script.packets[packet]
        for script in scripts
        for packet in packets_of(script)
        if packet in script.packets
    }


def _event(mission: MissionRow, one: Contradiction) -> ReportsContradict:
    return ReportsContradict(
        subject=mission.id,
        reports=tuple(
            ContradictingReport(
                robot=told.robot,
                packet=told.packet,
                tag=told.tag,
                state=told.state,
                at_s=told.at_s,
                holding=told.holding,
                place=told.place,
                believed=told.believed,
            )
            for told in one.reports
        ),
        things=one.things,
        detail=str(one),
        state=MissionState(mission.state),
    )
