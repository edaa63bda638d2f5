"""Robots announce themselves: what they say is compared with their world, changes it, or waits for an operator.

The answer to a factsheet is recorded with it and sent by the agent models, so that it outlives a restart.
"""

import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from sqlalchemy import delete, or_, select
from sqlalchemy.orm import Session, load_only

from app.agents.agent_models import FactsheetReply, Reception
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Conflict, Invalid, MactaError, NotFound
from app.domain.events import RobotAdmitted, RobotAnnounced, RobotRefused
from app.domain.lifecycles.factsheet import (
    IN_WORLD,
    OUTSIDE,
    await_admission,
    postpone,
    put_in_force,
    refuse,
)
from app.domain.world_model.edits import ChangeRobot, WorldEdit
from app.domain.world_model.factsheets import addition, difference, facts_said_by
from app.missions.world_changes import NEEDED, WorldChanges
from app.store import EditionRow, FactsheetRow, UnaskedRobotRow, WorldRow
from app.store.editions import WorldDirectory
from app.store.facts import factsheet_of
from app.store.known_empty import KnownEmpty
from app.store.records import lock_running_missions
from app.store.tables import utc_now
from robots.clock import Clock
from robots.wire import Factsheet, FactsheetState, Message
from robots.world import Peripheral, RobotSpec

MAX_OUTSIDE = 100
"""Robots outside a world whose factsheets are kept; those of more are dropped."""
MIN_INTERVAL_S = 1.0
"""Wall-clock seconds between two factsheets of a robot that change the world."""
AWAITS_OPERATOR = "no world has it; an operator may admit it"

logger = logging.getLogger(__name__)


class Factsheets:
    """Records the factsheets of all worlds' robots and follows them."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: WorldDirectory,
        clocks: Mapping[str, Clock],
        changes: WorldChanges,
        admits_all: bool = False,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param admits_all: robots that no world has are added without an operator's word."""
        self._core = core
        self._none_open = KnownEmpty(core.database, FactsheetRow)
        self._worlds = worlds
        self._clocks = clocks
        self._changes = changes
        self._admits_all = admits_all
        self._wall = wall
        self._changed_at_s: dict[tuple[str, str], float] = {}
        """When a robot of a world has last changed it (monotonic), by world and robot."""
        self._dropped = 0
        self._turned_down: dict[tuple[str, str], FactsheetReply] = {}
        """By world and robot, the answer to one whose twin is simulated. Not recorded: the robot asks again."""

    def record(self, world: str, messages: Sequence[Message]) -> Sequence[Reception]:
        """Record factsheets: together those that change nothing of the world, each other for itself."""
        receptions: dict[int, Reception] = {}
        with self._locked(world) as session:
            for number, message in enumerate(messages):
                reception = self._take(session, world, message, may_change=False)
                if reception is not None:
                    receptions[number] = reception
        for number, message in enumerate(messages):
            if number not in receptions:
                with self._locked(world) as session:
                    reception = self._take(session, world, message, may_change=True)
                    receptions[number] = reception or Reception.IGNORED
        return [receptions[number] for number in range(len(messages))]

    def due(self, world: str) -> Sequence[FactsheetReply]:
        """Follow what had to wait and need not any longer; the answers to send now, which then count as sent.

        A robot that repeats itself gets its answer again.
        """
        found = self._none_open.read(world, lambda: self._open(world))
        postponed = [one.robot for one in found if one.state == FactsheetState.POSTPONED]
        has_news = self._retry(world, postponed)
        turned_down = [
            reply
            for key, _ in list(self._turned_down.items())
            if key[0] == world and (reply := self._turned_down.pop(key, None)) is not None
        ]
        is_due = has_news or any(not one.is_told for one in found)
        return [*turned_down, *(self._untold(world) if is_due else ())]

    def _open(self, world: str) -> Sequence[FactsheetRow]:
        """The factsheets that had to wait, or whose robots are to be answered."""
        open_ = or_(FactsheetRow.is_told.is_(False), FactsheetRow.state == FactsheetState.POSTPONED)
        columns = load_only(FactsheetRow.state, FactsheetRow.is_told, raiseload=True)
        query = select(FactsheetRow).where(FactsheetRow.world == world, open_).options(columns)
        with self._core.database.read() as session:
            return session.scalars(query).all()

    def _retry(self, world: str, robots: Sequence[str]) -> bool:
        """Follow the postponed factsheets that no mission stands in the way of; True if there is one."""
        if not robots:
            return False
        with self._core.database.read() as session:
            missions = self._core.reservations.of_world(session, world)
        needed = frozenset[str]().union(*(one.reservation.names for one in missions))
        free = [robot for robot in robots if robot not in needed]
        for robot in free:
            with self._locked(world) as session:
                row = session.get(FactsheetRow, (world, robot))
                spec = self._specs(world).get(robot)
                if row is not None and row.state == FactsheetState.POSTPONED and spec is not None:
                    self._follow(session, row, spec)
        return bool(free)

    def _untold(self, world: str) -> Sequence[FactsheetReply]:
        untold = (FactsheetRow.world == world, FactsheetRow.is_told.is_(False))
        with self._locked(world) as session:
            rows = session.scalars(select(FactsheetRow).where(*untold)).all()
            for row in rows:
                row.is_told = True
            return [
                FactsheetReply(
                    robot=row.robot,
                    message_id=row.message_id,
                    state=FactsheetState(row.state),
                    reason=row.reason,
                )
                for row in rows
            ]

    def of_robot(self, world: str, robot: str) -> FactsheetRow | None:
        """The newest factsheet of a robot; None if it has sent none."""
        with self._core.database.read() as session:
            return session.get(FactsheetRow, (world, robot))

    def of_world(self, world: str, state: FactsheetState | None = None) -> Sequence[FactsheetRow]:
        """The newest factsheet of each robot that has announced itself, by name.

        :param state: only those in this state.
        """
        self._worlds.refuse_unknown(world)
        query = select(FactsheetRow).where(FactsheetRow.world == world).order_by(FactsheetRow.robot)
        if state is not None:
            query = query.where(FactsheetRow.state == state)
        with self._core.database.read() as session:
            return session.scalars(query).all()

    def admit(self, world: str, robot: str, *, actor: str, comment: str) -> FactsheetRow:
        """Let a robot into the world as it says, or have what it says followed that was refused.

        :raises NotFound: if it has not announced itself. :raises Conflict: if it is in the world as it says.
        :raises MactaError: if it does not fit, as of any change of a world.
        """
        self._worlds.refuse_unknown(world)
        with self._locked(world) as session:
            row = self._outside(session, world, robot)
            spec = self._specs(world).get(robot)
            edit = self._edit(row, spec)
            reason = comment or f"{robot} announced itself"
            made = None if edit is None else self._make(session, row, edit, actor=actor, reason=reason)
            self._settle(session, row, made, by=actor, comment=comment, spec=spec)
            return row

    def turn_away(self, world: str, robot: str, *, actor: str, reason: str) -> FactsheetRow:
        """Refuse a robot; it is told so, and asks again only if it has changed.

        :raises NotFound: if it has not announced itself. :raises Conflict: if it is in the world.
        """
        self._worlds.refuse_unknown(world)
        with self._locked(world) as session:
            row = self._outside(session, world, robot)
            if robot in self._specs(world):
                raise Conflict(f"{robot} is in {world}; remove it from there", code="robot-in-world")
            self._refuse(session, row, reason, by=actor)
            return row

    def _take(self, session: Session, world: str, message: Message, *, may_change: bool) -> Reception | None:
        """Record a factsheet; None if that may change the world, or add to it, and is not to."""
        sheet = message.body
        assert isinstance(sheet, Factsheet)
        run = session.get_one(WorldRow, world).run or ""
        spec = self._specs(world).get(message.sender)
        is_simulated = spec is not None and not spec.external
        if isinstance(spec, Peripheral):
            if is_simulated:
                self._turn_down(world, message, "its world's file does not say that it is external")
                return Reception.RECORDED
        elif is_simulated and sheet.edition is None and self._is_replaced(session, world, message.sender):
            self._turn_down(world, message)
            return Reception.RECORDED
        row = session.get(FactsheetRow, (world, message.sender), populate_existing=True)
        if row is not None and row.state in IN_WORLD and spec is None:  # the world's file was replaced
            session.delete(row)
            session.flush()
            row = None
        if row is not None and row.run == run and (known := _known(row, message, sheet)) is not None:
            return known
        if spec is None or self._differs(sheet, spec):
            if not may_change:
                return None
            if (put_off := self._put_off(session, world, row, sheet, spec)) is not None:
                return put_off
        if row is None:
            row = FactsheetRow(world=world, robot=message.sender, state=FactsheetState.ANNOUNCED.value)
            session.add(row)
        row.run = run
        row.message_id = message.id
        row.number = sheet.number
        row.sheet = sheet.model_dump(mode="json", exclude={"kind"})
        row.at_s = self._clocks[world].now_s()
        row.came_at = utc_now()
        of_robot = (UnaskedRobotRow.world == world, UnaskedRobotRow.robot == message.sender)
        session.execute(delete(UnaskedRobotRow).where(*of_robot))
        self._follow(session, row, spec)
        return Reception.RECORDED

    def _is_replaced(self, session: Session, world: str, robot: str) -> bool:
        """Whether the robot's simulated twin took its place, of all that was changed last."""
        query = select(EditionRow.edits).where(EditionRow.world == world).order_by(EditionRow.edition.desc())
        for edits in session.scalars(query):
            for edit in reversed(edits):
                if edit.get("name") == robot and edit.get("external") is not None:
                    return edit["external"] is False
        return False

    def _turn_down(
        self,
        world: str,
        message: Message,
        why: str = "an operator may take it back (change_robot, external)",
    ) -> None:
        reason = f"{message.sender} is simulated now; {why}"
        self._turned_down[world, message.sender] = FactsheetReply(
            robot=message.sender, message_id=message.id, state=FactsheetState.REFUSED, reason=reason
        )

    def _put_off(
        self,
        session: Session,
        world: str,
        row: FactsheetRow | None,
        sheet: Factsheet,
        spec: RobotSpec | Peripheral | None,
    ) -> Reception | None:
        """How a factsheet that changes something is handled if it is not followed now; None if it is."""
        if spec is None:
            return None if row is not None or self._has_room(session, world) else Reception.HELD_BACK
        newest = self._worlds.edition(world).number
        if not spec.external and sheet.edition is not None and sheet.edition < newest:
            # It announces itself again once its world has taken up the newest edition.
            return Reception.IGNORED
        return None if self._is_time(world, spec.name) else Reception.HELD_BACK

    def _follow(self, session: Session, row: FactsheetRow, spec: RobotSpec | Peripheral | None) -> None:
        """Have the world be as the factsheet says, or note why it is not.

        :param spec: the world's robot; None if it has none of that name.
        """
        try:
            edit = self._edit(row, spec)
            if spec is None and not self._admits_all:
                assert edit is not None
                self._changes.checked(session, row.world, [edit])
                await_admission(row, AWAITS_OPERATOR)
                self._tell(session, row)
                return
            reason = f"{row.robot} announced itself"
            made = None if edit is None else self._make(session, row, edit, actor=row.robot, reason=reason)
        except Conflict as error:
            if error.code != NEEDED:
                self._refuse(session, row, _words(error))
            elif (row.state, row.reason) != (FactsheetState.POSTPONED, _words(error)):
                postpone(row, _words(error))
                self._tell(session, row)
            return
        except MactaError as error:
            self._refuse(session, row, _words(error))
            return
        self._settle(session, row, made, spec=spec)

    def _edit(self, row: FactsheetRow, spec: RobotSpec | Peripheral | None) -> WorldEdit | None:
        """What the factsheet changes of its world; None if nothing.

        :raises Invalid: if it describes no robot of this world.
        """
        sheet = Factsheet.model_validate(row.sheet)
        if spec is None:
            return addition(row.robot, sheet, self._worlds[row.world])
        return difference(sheet, spec)

    def _make(self, session: Session, row: FactsheetRow, edit: WorldEdit, *, actor: str, reason: str) -> int:
        """Make the edit; the number of the edition."""
        if isinstance(edit, ChangeRobot):
            reason = f"{reason}: {', '.join(edit.values)}"
        source = factsheet_of(row.robot)
        made = self._changes.make(session, row.world, [edit], actor=actor, source=source, reason=reason)
        return made.edition

    def _settle(
        self,
        session: Session,
        row: FactsheetRow,
        edition: int | None,
        *,
        spec: RobotSpec | Peripheral | None,
        by: str | None = None,
        comment: str = "",
    ) -> None:
        """Note that the world is as the factsheet says; its facts have that source from now on.

        :param edition: that was made of it, if any.
        :param spec: the world's robot as it was before; None if it had none of that name.
        """
        if spec is not None:  # what an edition adds has that source already
            self._core.facts.attest(
                session,
                row.world,
                facts_said_by(spec, self._worlds[row.world], self._core.knowledge_base),
                source=factsheet_of(row.robot),
                at_s=self._clocks[row.world].now_s(),
            )
        put_in_force(row, edition=edition, by=by)
        if spec is None and edition is not None:
            admitted = RobotAdmitted(
                subject=row.robot, world=row.world, edition=edition, actor=by, comment=comment
            )
            self._core.events.append(session, admitted)
        else:
            self._tell(session, row)

    def _refuse(self, session: Session, row: FactsheetRow, reason: str, *, by: str | None = None) -> None:
        refuse(row, reason, by=by)
        refused = RobotRefused(subject=row.robot, world=row.world, actor=by, reason=reason)
        self._core.events.append(session, refused)

    def _tell(self, session: Session, row: FactsheetRow) -> None:
        announced = RobotAnnounced(
            subject=row.robot,
            world=row.world,
            number=row.number,
            outcome=FactsheetState(row.state),
            reason=row.reason,
            edition=row.edition,
        )
        self._core.events.append(session, announced)

    def _outside(self, session: Session, world: str, robot: str) -> FactsheetRow:
        """The factsheet of a robot that waits for an operator."""
        row = session.get(FactsheetRow, (world, robot), populate_existing=True)
        if row is None:
            waiting = (FactsheetRow.world == world, FactsheetRow.state.in_(OUTSIDE))
            raise NotFound(
                f"no robot {robot!r} has announced itself to {world}",
                code="robot-not-announced",
                choices=session.scalars(select(FactsheetRow.robot).where(*waiting)).all(),
                thing=robot,
            )
        if row.state in IN_WORLD:
            raise Conflict(f"{robot} is in {world} already", code="robot-in-world", thing=robot)
        return row

    def _has_room(self, session: Session, world: str) -> bool:
        """Whether one more factsheet of a robot outside is kept.

        The oldest that was refused makes room for it, once its robot was told so.
        """
        outside = (FactsheetRow.world == world, FactsheetRow.state.in_(OUTSIDE))
        rows = session.scalars(select(FactsheetRow).where(*outside).order_by(FactsheetRow.came_at)).all()
        if len(rows) < MAX_OUTSIDE:
            return True
        refused = next((row for row in rows if row.state == FactsheetState.REFUSED and row.is_told), None)
        if refused is not None:
            session.delete(refused)
            return True
        self._dropped += 1
        if str(self._dropped).strip("0") == "1":
            logger.warning(
                "%d robots that are not in %s have announced themselves; further factsheets are dropped (%d so far)",
                len(rows),
                world,
                self._dropped,
            )
        return False

    def _differs(self, sheet: Factsheet, spec: RobotSpec | Peripheral) -> bool:
        try:
            return difference(sheet, spec) is not None
        except Invalid:
            return True

    def _is_time(self, world: str, robot: str) -> bool:
        """Whether the robot may change the world now; that counts as done."""
        now_s = self._wall.monotonic_s()
        last_s = self._changed_at_s.get((world, robot))
        if last_s is not None and now_s - last_s < MIN_INTERVAL_S:
            return False
        self._changed_at_s[world, robot] = now_s
        return True

    def _specs(self, world: str) -> Mapping[str, RobotSpec | Peripheral]:
        return self._worlds[world].agents_by_name

    @contextmanager
    def _locked(self, world: str) -> Iterator[Session]:
        """A write transaction with the world locked, after its missions as in all others, and its newest edition."""
        with self._core.database.write() as session:
            lock_running_missions(session, world)
            self._core.facts.lock(session, world)
            self._worlds.read(session)
            yield session


def _known(row: FactsheetRow, message: Message, sheet: Factsheet) -> Reception | None:
    """How a factsheet is handled that says nothing new; None if it does."""
    last = Factsheet.model_validate(row.sheet)
    says_same = last.content == sheet.content
    was_turned_away = row.state == FactsheetState.REFUSED and row.decided_by is not None
    is_repeated = row.message_id == message.id or (says_same and sheet.number == last.number)
    if is_repeated or (says_same and was_turned_away):
        row.message_id = message.id
        row.number = max(row.number, sheet.number)
        row.is_told = False
        return Reception.RECORDED
    if sheet.number <= last.number:
        logger.debug("%s: an outdated factsheet is ignored", message.sender)
        return Reception.IGNORED
    return None


def _words(error: MactaError) -> str:
    return error.detail.removeprefix("edits.0: ")
