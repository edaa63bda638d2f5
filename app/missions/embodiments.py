"""Moves robots' minds into other bodies (SRA, Virtual Robotic Workbench: migration of agents among platforms).

A robot's mind is its script and its place in it, beliefs, commitments, conversations, tuning and rules. It comes to
rest at a safe point, the world exchanges the robot's body as an edition, and only then the mind is told to go on. Each
step is recorded before it is told, and told until it is answered; the fencing number of a move tells its messages from
those of earlier ones.

Between a simulated body and the real one the mind leaves its program: that writes it as a document when it rests, and
the other program takes it up, before an edition says who speaks for the robot, or with it. The program that the mind
has left keeps it at rest, so that a mind that is refused goes on where it was.
"""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError
from sqlalchemy import func, or_, select, tuple_
from sqlalchemy.orm import Session

from app.agents.tuning import robot_and_world
from app.core import Core
from app.domain.errors import Conflict, MactaError
from app.domain.lifecycles.embodiment import GOES_ON_AS, OPEN, EmbodimentState, become, is_open
from app.domain.world_model import initial_support
from app.domain.world_model.beliefs import occupants
from app.domain.world_model.edits import ChangeRobot
from app.missions.embodiment_record import (
    body_record,
    crosses,
    exchange_edit,
    has_body,
    is_complete,
    is_real,
    keep_piece,
    mind_text,
    newest_move,
    next_piece,
    program_of,
    tell_of_move,
    wanted_record,
)
from app.missions.world_changes import WorldChanges
from app.store import EditionRow, EmbodimentRow, MissionRow
from app.store.editions import WorldDirectory
from app.store.engine import is_unavailable
from app.store.known_empty import KnownEmpty
from app.store.records import lock_running_missions
from app.store.tables import utc_now
from robots.clock import Clock
from robots.wire import (
    MindOrder,
    MindOrderReport,
    MindTransfer,
    MindTransferReport,
    MindVerb,
    Performative,
)
from robots.world import RobotSpec, WorldFile
from robots.world.bodies import BodyKind, BodySpec, kind_of

PATIENCE_S = 30.0
"""World seconds in which a robot that has been asked comes to rest, or refuses (our choice)."""
LEASE_MARGIN_S = 2.0
"""How long after its end a lease counts as over here: the robot's clock may be behind (our choice)."""
KEPT = 50
"""Attempts that are shown, newest first."""
_OF_THE_WORLD = (EmbodimentState.REQUESTED, EmbodimentState.HANDING_OVER, EmbodimentState.MOVING)
"""States whose next step may change the world; the others' steps need the row alone."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotEmbodiment:
    """The body that a robot's mind is in.

    :param body: its specification as in a world file. :param fence: of the newest move, 0: there was none.
    :param since: when a move brought it there; None: it has had it from the start, or an edition exchanged it at rest.
    :param lease_s: how long it may act without hearing of the service; None: without end.
    :param lease_until_s: until when it may act now, by the world's clock.
    :param attempts: the moves, newest first.
    """

    robot: str
    world: str
    kind: BodyKind
    body: Mapping[str, Any]
    fence: int
    since: str | None
    lease_s: float | None
    lease_until_s: float | None
    attempts: Sequence[EmbodimentRow]


@dataclass(frozen=True, slots=True, kw_only=True)
class DueOrder:
    """An order that a robot has not answered."""

    robot: str
    order: MindOrder | MindTransfer


class EmbodimentService:
    """Moves minds, and keeps robots' leases. The agent models deliver what is due and pass robots' answers to it."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: WorldDirectory,
        clocks: Mapping[str, Clock],
        changes: WorldChanges,
        is_connected: Callable[[str], bool] = lambda robot: True,
        is_simulated: Callable[[str], bool] = lambda world: True,
    ) -> None:
        """
        :param clocks: the worlds' clocks by the world's name.
        :param is_connected: whether somebody speaks for a robot now.
        :param is_simulated: whether there is a simulation of a world.
        """
        self._is_connected = is_connected
        self._is_simulated = is_simulated
        self._core = core
        self._none_open = KnownEmpty(core.database, EmbodimentRow)
        self._worlds = worlds
        self._clocks = clocks
        self._changes = changes
        self._leased: dict[str, bool] = {}

    def get(self, robot: str) -> RobotEmbodiment:
        """:raises NotFound: if no world has the robot."""
        spec, world = robot_and_world(self._worlds, robot)
        with self._core.database.read() as session:
            return self._embodiment(session, world, spec)

    def embody(
        self,
        robot: str,
        body: BodySpec | None,
        *,
        lease_s: float | None = None,
        actor: str,
        comment: str = "",
    ) -> RobotEmbodiment:
        """Move the robot's mind into another body, or leave it where it is: that withdraws a move that has only been
        requested, or else gives the mind this lease. Repeated, it changes nothing.

        :param body: None: the real one, with the robot's own software.
        :param lease_s: how long the robot may act in that body without hearing of the service; None: without end.
        :raises Invalid: if the robot cannot have the body.
        :raises Conflict: if a mission, or what the robot holds, needs the present one, or another move is under way.
        """
        _, world = robot_and_world(self._worlds, robot)
        with self._core.database.write() as session:
            lock_running_missions(session, world)  # lock order: missions before the world
            self._core.facts.lock(session, world)
            self._worlds.read(session)
            spec, _ = robot_and_world(self._worlds, robot)
            newest = newest_move(session, world, robot)
            wanted, former = wanted_record(body, spec), body_record(spec)
            moves = wanted != former
            if newest is not None and is_open(newest):
                self._meet(session, newest, spec, wanted, lease_s)
            elif moves or lease_s != (None if newest is None else newest.lease_s):
                if spec.external is not is_real(wanted):
                    self._refuse_alone(self._worlds[world], spec)
                self._refuse_unfit(session, self._worlds[world], spec, wanted)
                row = EmbodimentRow(
                    world=world,
                    robot=robot,
                    fence=1 if newest is None else newest.fence + 1,
                    # Another lease alone needs no rest: the robot is told to go on under it.
                    state=EmbodimentState.REQUESTED if moves else EmbodimentState.GOING_ON,
                    reason="",
                    body=wanted,
                    former=former,
                    lease_s=lease_s,
                    actor=actor,
                    comment=comment,
                )
                if not moves:
                    self._promise(row)
                session.add(row)
                tell_of_move(session, self._core.events, row)
            session.flush()
            return self._embodiment(session, world, spec)

    def due(self, world: str) -> Sequence[DueOrder]:
        """The orders that robots of the world have not answered; steps that have become possible are made before."""
        rows = self._none_open.read(world, lambda: self._open(world))
        if not rows:
            self._leased[world] = False
            return []
        with self._core.database.read() as session:
            steps = [row for row in rows if self._has_step(session, row)]
        for row in steps:
            try:
                with self._core.database.write() as session:
                    if (locked := self._locked(session, row)) is not None:
                        self._step(session, locked)
            except Exception as error:  # one robot's move keeps nothing from the others
                if is_unavailable(error):
                    raise
                logger.exception("the move of %s's mind, %s, cannot go on", row.robot, row.state)
        if steps:
            rows = self._open(world)
        self._leased[world] = any(row.lease_s is not None for row in rows)
        return [order for row in rows if (order := _order(row)) is not None]

    def _open(self, world: str) -> Sequence[EmbodimentRow]:
        """The newest move of each robot whose mind moves, or has a lease."""
        newest = (
            select(EmbodimentRow.robot, func.max(EmbodimentRow.fence))
            .where(EmbodimentRow.world == world)
            .group_by(EmbodimentRow.robot)
        )
        query = select(EmbodimentRow).where(
            EmbodimentRow.world == world,
            tuple_(EmbodimentRow.robot, EmbodimentRow.fence).in_(newest),
            or_(EmbodimentRow.state.in_(OPEN), EmbodimentRow.lease_s.is_not(None)),
        )
        with self._core.database.read() as session:
            return session.scalars(query).all()

    def has_leases(self, world: str) -> bool:
        """Whether robots of the world had leases when `due` was called last."""
        return self._leased.get(world, False)

    def record_answer(
        self, world: str, robot: str, performative: Performative, report: MindOrderReport
    ) -> None:
        """Record that the robot's mind rests, or goes on, or why it does not."""
        with self._core.database.write() as session:
            row = session.get(EmbodimentRow, (world, robot, report.fence))
            if row is None or (row := self._locked(session, row)) is None:
                return
            agreed = performative is Performative.AGREE
            if report.verb is MindVerb.REST:
                self._note_rest(session, row, report, agreed=agreed)
            elif report.verb is MindVerb.GO_ON and agreed:
                row.lease_told_s = report.lease_until_s
                if row.state in GOES_ON_AS:
                    self._become(session, row, GOES_ON_AS[row.state])
            elif self._is_to_be_handed_again(row):
                logger.warning("%s is handed its mind of move %d again: %s", robot, row.fence, report.reason)
                row.taken = 0
                row.asked_s = self._clocks[world].now_s()
                self._become(session, row, EmbodimentState.HANDING_OVER)
            elif report.verb is MindVerb.GO_ON and newest_move(session, world, robot) is row:
                row.lease_s = row.lease_until_s = row.lease_told_s = None  # else it would be told for ever
                logger.warning("%s does not go on as move %d says: %s", robot, row.fence, report.reason)
                if row.state in GOES_ON_AS:
                    stays = row.body == row.former
                    self._become(
                        session,
                        row,
                        EmbodimentState.RETURNED if stays else GOES_ON_AS[row.state],
                        report.reason if stays else "",
                    )

    def record_transfer(
        self, world: str, robot: str, performative: Performative, report: MindTransferReport
    ) -> None:
        """Record that the robot's own software has a piece of the mind, or why it cannot take it."""
        with self._core.database.write() as session:
            row = session.get(EmbodimentRow, (world, robot, report.fence))
            if row is None or (row := self._locked(session, row)) is None:
                return
            if row.state != EmbodimentState.HANDING_OVER or not is_complete(row) or not is_real(row.body):
                return
            if performative is not Performative.AGREE:
                self._give_back(session, row, report.reason)
            elif row.mind is not None and report.digest == row.mind["digest"]:
                row.taken = max(row.taken, report.number + 1)
                if row.taken == row.mind["count"]:
                    self._exchange(session, row)

    def minds(self, world: str) -> Mapping[str, str]:
        """By robot, the document of the mind with which the world's simulation is to take its place."""
        query = select(EmbodimentRow).where(
            EmbodimentRow.world == world,
            EmbodimentRow.mind.is_not(None),
            EmbodimentRow.state.in_((EmbodimentState.MOVING, EmbodimentState.RETURNING)),
        )
        with self._core.database.read() as session:
            rows = session.scalars(query).all()
        goes_to = {row: row.body if row.state == EmbodimentState.MOVING else row.former for row in rows}
        return {row.robot: mind_text(row) for row, body in goes_to.items() if not is_real(body)}

    def _note_rest(
        self, session: Session, row: EmbodimentRow, report: MindOrderReport, *, agreed: bool
    ) -> None:
        """The mind rests, and has brought a piece of its document if it is handed over; or it does not rest."""
        if row.state not in (EmbodimentState.REQUESTED, EmbodimentState.HANDING_OVER):
            return
        is_asked = row.state == EmbodimentState.REQUESTED
        if not agreed and is_asked:
            self._become(session, row, EmbodimentState.REFUSED, report.reason)
        elif not agreed:
            self._give_back(session, row, report.reason)
        elif not crosses(row):
            self._exchange(session, row)
        elif report.mind is None:
            self._become(
                session, row, EmbodimentState.RETURNING, f"the software of {row.robot} hands no mind over"
            )
        else:
            if not is_complete(row):
                keep_piece(row, report.mind)
                row.asked_s = self._clocks[row.world].now_s()
            if is_asked:
                self._become(session, row, EmbodimentState.HANDING_OVER)
            if is_complete(row) and not is_real(row.body):
                self._exchange(session, row)

    def _is_to_be_handed_again(self, row: EmbodimentRow) -> bool:
        """Whether the robot's own software does not go on because it has lost the mind, or never had it."""
        return row.state == EmbodimentState.GOING_ON and crosses(row) and is_real(row.body)

    def _give_back(self, session: Session, row: EmbodimentRow, reason: str) -> None:
        """Have the mind go on where it was, and that the record says so, too."""
        self._worlds.read(session)
        if row.edition is not None and has_body(self._worlds[row.world], row):
            try:
                self._take_back(session, row)
            except (MactaError, ValidationError) as error:
                reason = f"{reason}; the record still has that body: {_words(error)}"
        self._become(session, row, EmbodimentState.RETURNING, reason)

    def _locked(self, session: Session, row: EmbodimentRow) -> EmbodimentRow | None:
        """The row as it is now, locked; before it the world, if its next step may change that. None: it was dropped."""
        if row.state in _OF_THE_WORLD:
            lock_running_missions(session, row.world)
            self._core.facts.lock(session, row.world)
        key = (row.world, row.robot, row.fence)
        return session.get(EmbodimentRow, key, with_for_update=True, populate_existing=True)

    def _meet(
        self,
        session: Session,
        row: EmbodimentRow,
        spec: RobotSpec,
        wanted: Mapping[str, Any],
        lease_s: float | None,
    ) -> None:
        """Handle a request while a move is under way."""
        if row.state in _OF_THE_WORLD and wanted == row.body:
            row.lease_s = lease_s  # the robot has not been told of one yet
            return
        if row.state == EmbodimentState.GOING_ON and (wanted, lease_s) == (row.body, row.lease_s):
            return
        is_unmade = row.state == EmbodimentState.HANDING_OVER and row.edition is None
        if (row.state == EmbodimentState.REQUESTED or is_unmade) and wanted == row.former:
            self._become(session, row, EmbodimentState.RETURNING, "withdrawn")
            return
        raise Conflict(
            f"the mind of {spec.name} is moving from {row.former['kind']} to {row.body['kind']}, and the move is "
            f"{row.state}; wait for its end",
            code="embodiment-under-way",
            thing=spec.name,
        )

    def _refuse_unfit(
        self, session: Session, world: WorldFile, spec: RobotSpec, wanted: Mapping[str, Any]
    ) -> None:
        """Refuse a body in which the robot could not go on with what it does, or holds."""
        replaces = spec.external is not is_real(wanted)
        edit = exchange_edit(spec.name, wanted, replaces=replaces)
        held = occupants(spec.name, self._core.facts.facts(session, world.name))
        is_virtual = edit.body is not None and not edit.body.is_solid and not is_real(wanted)
        if held and is_virtual and not replaces and any(other.external for other in world.robots):
            raise Conflict(
                f"{spec.name} holds {', '.join(held)}, which a virtual body does not beside real robots; "
                "have it put down first",
                code="robot-holds-sample",
                thing=spec.name,
            )
        checked = self._changes.checked(session, world.name, [edit], resting=[spec.name])
        lost = checked.change.remove
        for one in self._core.reservations.of_world(session, world.name):
            if spec.name not in one.reservation.names and not replaces:
                continue  # avatars beside real robots can do less, so a further real one concerns all missions
            plan = session.get_one(MissionRow, one.mission_id).plan_id
            if needed := sorted(map(str, lost & initial_support(self._core.plan_nets.of(session, plan)))):
                raise Conflict(
                    f"mission {one.mission_id} rests on {', '.join(needed)}, which does not hold with that body; wait "
                    "for its end",
                    code="needed-by-mission",
                    thing=spec.name,
                )

    def _refuse_alone(self, world: WorldFile, spec: RobotSpec) -> None:
        """Refuse to begin a move between programs of which one is not there; that of a simulated robot's own software
        shows only when it is asked. Once it has handed the mind over a program is silent.
        """
        if not self._is_simulated(world.name):
            raise Conflict(
                f"there is no simulation of {world.name} that a mind could move from or to; start macta fleet",
                code="world-not-simulated",
                thing=world.name,
            )
        if spec.external and not self._is_connected(spec.name):
            raise Conflict(
                f"{spec.name} is offline, and its mind is there; connect it, or, while it is idle, let its twin begin "
                f"without its mind (macta robot twin {spec.name} --simulated)",
                code="robot-offline",
                thing=spec.name,
            )

    def _has_step(self, session: Session, row: EmbodimentRow) -> bool:
        """Whether `_step` would change something."""
        match row.state:
            case EmbodimentState.REQUESTED:
                return not crosses(row) and self._lease_is_over(session, row)
            case EmbodimentState.HANDING_OVER:
                return self._is_too_late(row)
            case EmbodimentState.MOVING:
                return self._delivery(session, row) != "pending"
            case _:
                return self._lease_is_due(row)

    def _step(self, session: Session, row: EmbodimentRow) -> None:
        """Make the step of a move, or of a lease, that needs no answer of the robot."""
        if not self._has_step(session, row):
            return
        match row.state:
            case EmbodimentState.REQUESTED:
                self._exchange(session, row)
            case EmbodimentState.HANDING_OVER:
                self._give_back(
                    session,
                    row,
                    f"the software of {row.robot}'s real body has not taken its mind within {PATIENCE_S:g} s; start it",
                )
            case EmbodimentState.MOVING:
                self._end_exchange(session, row)
            case _:
                self._promise(row)

    def _end_exchange(self, session: Session, row: EmbodimentRow) -> None:
        """Have a mind go on in the other body if the world has it by now."""
        self._worlds.read(session)
        if not has_body(self._worlds[row.world], row):
            reason = f"edition {self._worlds.edition(row.world).number} of the world gives it another body"
            self._become(session, row, EmbodimentState.RETURNING, reason)
        elif self._delivery(session, row) == "taken_up":
            self._promise(row)
            self._become(session, row, EmbodimentState.GOING_ON)
        else:
            reason = session.get_one(EditionRow, (row.world, row.edition)).detail
            try:
                self._take_back(session, row)
            except (MactaError, ValidationError) as error:
                reason = f"{reason}; the record still has that body: {_words(error)}"
            self._become(session, row, EmbodimentState.RETURNING, reason)

    def _exchange(self, session: Session, row: EmbodimentRow) -> None:
        """Have the world exchange the body of a robot whose mind rests; if that is not possible any more, the mind is
        told to go on as it was.
        """
        self._worlds.read(session)
        world = self._worlds[row.world]
        if row.edition is not None and has_body(world, row):  # the mind was handed over again
            self._become(session, row, EmbodimentState.MOVING)
            return
        try:
            edit = exchange_edit(row.robot, row.body, replaces=crosses(row))
            self._refuse_unfit(session, world, world.robot(row.robot), row.body)
            row.edition = self._edition(
                session, row, edit, row.comment or f"moves into a {row.body['kind']} body"
            )
        except (MactaError, ValidationError) as error:
            self._become(session, row, EmbodimentState.RETURNING, _words(error))
            return
        self._become(session, row, EmbodimentState.MOVING)

    def _take_back(self, session: Session, row: EmbodimentRow) -> None:
        """Have the record say again that the robot has its former body: the world refuses the other one."""
        back = exchange_edit(row.robot, row.former, replaces=crosses(row))
        row.edition = self._edition(session, row, back, "the mind does not get the other body")

    def _edition(self, session: Session, row: EmbodimentRow, edit: ChangeRobot, reason: str) -> int:
        made = self._changes.make(
            session,
            row.world,
            [edit],
            actor=row.actor,
            source=f"operator {row.actor}",
            reason=reason,
            resting=[row.robot],
        )
        return made.edition

    def _promise(self, row: EmbodimentRow) -> None:
        """Record until when the robot may act, before it is told."""
        if row.lease_s is not None:
            row.lease_until_s = self._clocks[row.world].now_s() + row.lease_s

    def _lease_is_due(self, row: EmbodimentRow) -> bool:
        """Whether half of the lease is over."""
        if row.lease_s is None:
            return False
        left_s = (row.lease_until_s or 0.0) - self._clocks[row.world].now_s()
        return left_s < row.lease_s / 2

    def _is_too_late(self, row: EmbodimentRow) -> bool:
        """Whether the robot's own software has not taken the mind in time."""
        if not is_complete(row) or row.asked_s is None:
            return False  # the program that has it is asked for it
        return self._clocks[row.world].now_s() > row.asked_s + PATIENCE_S

    def _lease_is_over(self, session: Session, row: EmbodimentRow) -> bool:
        """Whether the robot rests by itself, so that it need not be asked."""
        before = newest_move(session, row.world, row.robot, before=row.fence)
        if before is None or before.lease_until_s is None or before.lease_told_s is None:
            return False  # it has none, or has not confirmed any
        return self._clocks[row.world].now_s() > before.lease_until_s + LEASE_MARGIN_S

    @staticmethod
    def _delivery(session: Session, row: EmbodimentRow) -> str:
        edition = session.get(EditionRow, (row.world, row.edition))
        return "taken_up" if edition is None else edition.delivery

    def _become(self, session: Session, row: EmbodimentRow, state: EmbodimentState, reason: str = "") -> None:
        become(row, state, reason)
        if state in (EmbodimentState.RETURNING, EmbodimentState.REFUSED):
            # It goes on in the body, and under the lease, that it had.
            before = newest_move(session, row.world, row.robot, before=row.fence)
            row.lease_s = None if before is None else before.lease_s
            row.lease_until_s = None if before is None else before.lease_until_s
            row.lease_told_s = None if before is None else before.lease_told_s
            self._promise(row)
        if not is_open(row):
            row.ended_at = utc_now()
            row.mind = None
        tell_of_move(session, self._core.events, row)

    def _embodiment(self, session: Session, world: str, spec: RobotSpec) -> RobotEmbodiment:
        of_robot = (EmbodimentRow.world == world, EmbodimentRow.robot == spec.name)
        query = select(EmbodimentRow).where(*of_robot).order_by(EmbodimentRow.fence.desc()).limit(KEPT)
        attempts = session.scalars(query).all()
        body = spec.body.model_dump(mode="json")
        record = body_record(spec)
        brought = (
            one for one in attempts if one.state == EmbodimentState.EMBODIED and one.body != one.former
        )
        got = next(brought, None)
        leased = next((one for one in attempts if not is_open(one)), None)
        return RobotEmbodiment(
            robot=spec.name,
            world=world,
            kind=kind_of(spec.body, external=spec.external),
            body=body,
            fence=attempts[0].fence if attempts else 0,
            since=got.ended_at if got is not None and got.body == record else None,
            lease_s=None if leased is None else leased.lease_s,
            lease_until_s=None if leased is None else leased.lease_until_s,
            attempts=attempts,
        )


def _words(error: MactaError | ValidationError) -> str:
    return error.detail if isinstance(error, MactaError) else str(error).replace("\n", " ")


def _order(row: EmbodimentRow) -> DueOrder | None:
    """What the robot is to be told and has not confirmed; None if nothing."""
    is_asked = row.state == EmbodimentState.REQUESTED
    if is_asked or (row.state == EmbodimentState.HANDING_OVER and not is_complete(row)):
        number = len(row.mind["texts"]) if row.mind is not None else 0
        order = MindOrder(
            verb=MindVerb.REST,
            fence=row.fence,
            within_s=PATIENCE_S,
            to=program_of(row.former),
            piece=number if crosses(row) else None,
        )
        return DueOrder(robot=row.robot, order=order)
    if row.state == EmbodimentState.HANDING_OVER:
        return DueOrder(robot=row.robot, order=MindTransfer(fence=row.fence, mind=next_piece(row)))
    is_told = row.lease_told_s == row.lease_until_s
    if row.state == EmbodimentState.MOVING or (row.state not in GOES_ON_AS and is_told):
        return None
    stays = row.state in (EmbodimentState.RETURNING, EmbodimentState.RETURNED, EmbodimentState.REFUSED)
    order = MindOrder(
        verb=MindVerb.GO_ON,
        fence=row.fence,
        lease_until_s=row.lease_until_s,
        to=program_of(row.former if stays else row.body),
    )
    return DueOrder(robot=row.robot, order=order)
