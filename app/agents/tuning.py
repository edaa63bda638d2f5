"""Operators' overrides of the parameters of a robot's packets: stored, and delivered until the robot answers."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Invalid, NotFound, Outdated
from app.domain.events import TuningAcknowledged, TuningRefused, TuningSet
from app.store import TuningRow
from app.store.known_empty import KnownEmpty
from robots.errors import RepertoireError
from robots.repertoire import Repertoire, parameters
from robots.wire import PacketTunings, Performative, TuningReport
from robots.world import RobotSpec, WorldFile

Parameters = Mapping[str, Mapping[str, Mapping[str, float]]]
"""Numbers by packet, pattern and parameter."""
UNTOUCHED = "untouched"
PENDING = "pending"
ACKNOWLEDGED = "acknowledged"
REFUSED = "refused"


@dataclass(frozen=True, slots=True, kw_only=True)
class TunedRobot:
    """A robot's tuning.

    :param tuning: the operators' overrides.
    :param set_out: the world file's overrides; `tuning` is applied after them.
    :param packets: the resulting value of every parameter of the packets in the robot's repertoire.
    :param delivery: untouched, pending, acknowledged or refused by the robot.
    :param detail: why the robot refused.
    """

    robot: str
    world: str
    version: int
    tuning: Parameters
    set_out: Parameters
    packets: Parameters
    delivery: str
    detail: str = ""
    comment: str = ""
    decided_by: str | None = None
    decided_at: str | None = None


class TuningService:
    """Reads and sets tunings. The agent models deliver the pending ones and pass the robots' answers to it."""

    def __init__(self, core: Core, *, worlds: Mapping[str, WorldFile], repertoire: Repertoire) -> None:
        """:param repertoire: the packets of the robots' software."""
        self._database = core.database
        self._none_pending = KnownEmpty(core.database, TuningRow)
        self._events = core.events
        self._worlds = worlds
        self._repertoire = repertoire

    def get(self, robot: str) -> TunedRobot:
        spec, world = robot_and_world(self._worlds, robot)
        with self._database.read() as session:
            return self._tuned(spec, world, session.get(TuningRow, (world, robot)))

    def put(
        self, robot: str, tuning: PacketTunings, *, actor: str, comment: str, expected_version: int | None
    ) -> TunedRobot:
        """Replace all overrides of the robot; they apply from its next packet on.

        :raises Invalid: naming packet, pattern and parameter, for one that does not exist or is out of range.
        :raises Outdated: if the tuning has changed since `expected_version`.
        """
        spec, world = robot_and_world(self._worlds, robot)
        self._check(spec, tuning)
        with self._database.write() as session:
            self._database.lock(session, f"tuning {robot}")  # there may be no row to lock yet
            row = session.get(TuningRow, (world, robot), with_for_update=True)
            if row is None:
                row = TuningRow(world=world, robot=robot, version=0)
                session.add(row)
            if expected_version not in (None, row.version):
                detail = (
                    f"the tuning of {robot} is at version {row.version}, the request was made from version "
                    f"{expected_version}; read it again"
                )
                raise Outdated(detail, code="tuning-changed")
            row.set(tuning, actor=actor, comment=comment)
            self._events.append(
                session,
                TuningSet(
                    subject=robot,
                    world=world,
                    actor=actor,
                    comment=comment,
                    version=row.version,
                    tuning=tuning,
                ),
            )
            return self._tuned(spec, world, row)

    def pending(self, world: str) -> Sequence[TuningRow]:
        """The tunings still to be delivered to robots of the world."""
        return self._none_pending.read(world, lambda: self._pending(world))

    def _pending(self, world: str) -> Sequence[TuningRow]:
        query = select(TuningRow).where(TuningRow.world == world, TuningRow.delivery == PENDING)
        with self._database.read() as session:
            return session.scalars(query.order_by(TuningRow.robot)).all()

    def record_answer(self, world: str, robot: str, performative: Performative, report: TuningReport) -> None:
        """Record that the robot applied a tuning, or refused it."""
        with self._database.write() as session:
            row = session.get(TuningRow, (world, robot), with_for_update=True)
            if row is None or (row.version, row.delivery) != (report.version, PENDING):
                return
            agreed = performative is Performative.AGREE
            row.delivery = ACKNOWLEDGED if agreed else REFUSED
            row.detail = report.reason
            answered = TuningAcknowledged if agreed else TuningRefused
            self._events.append(
                session,
                answered(subject=robot, world=world, version=report.version, reason=report.reason),
            )

    def _check(self, spec: RobotSpec, tuning: PacketTunings) -> None:
        initial = self._initial_repertoire(spec)
        known = _parameters_of(spec, initial)
        for tag in tuning:
            if tag not in known:
                detail = f"{spec.name} has no packet {tag}; its packets: {', '.join(sorted(known))}"
                raise Invalid(detail, code="unfit-tuning", choices=sorted(known))
        try:
            initial.tuned(tuning)
        except RepertoireError as error:
            raise Invalid(str(error), code="unfit-tuning") from error

    def _initial_repertoire(self, spec: RobotSpec) -> Repertoire:
        """The repertoire, tuned by the world file."""
        return self._repertoire.tuned(spec.tuning)

    def _tuned(self, spec: RobotSpec, world: str, row: TuningRow | None) -> TunedRobot:
        if row is None:
            row = TuningRow(world=world, robot=spec.name, version=0, tuning={}, delivery=UNTOUCHED)
        return TunedRobot(
            robot=spec.name,
            world=world,
            version=row.version,
            tuning=row.tuning,
            set_out=spec.tuning,
            packets=_parameters_of(spec, self._initial_repertoire(spec).tuned(row.tuning)),
            delivery=row.delivery,
            detail=row.detail or "",
            comment=row.comment or "",
            decided_by=row.decided_by,
            decided_at=row.decided_at,
        )


def robot_and_world(worlds: Mapping[str, WorldFile], robot: str) -> tuple[RobotSpec, str]:
    """A robot of one of the worlds, and the world's name.

    :raises NotFound: if none has it.
    """
    world_of = {one.name: world.name for world in worlds.values() for one in world.robots}
    if robot not in world_of:
        raise NotFound(f"unknown robot {robot!r}", code="unknown-robot", choices=sorted(world_of))
    world = world_of[robot]
    return worlds[world].robot(robot), world


def renew_tunings(session: Session, world: str, robots: Collection[str] | None = None) -> None:
    """Mark the tunings of a world for delivery again after these robots were restarted or replaced; None: all."""
    for row in session.scalars(select(TuningRow).where(TuningRow.world == world)):
        if robots is not None and row.robot not in robots:
            continue
        row.delivery = PENDING
        row.detail = ""


def _parameters_of(spec: RobotSpec, repertoire: Repertoire) -> Parameters:
    return {
        name: parameters(packet)
        for name, packet in sorted(repertoire.specs.items())
        if packet.basic or packet.tag in spec.repertoire
    }
