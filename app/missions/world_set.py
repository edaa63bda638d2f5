"""Worlds that are added and removed while the service runs, by any process on its database."""

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from threading import Event, Lock

from pydantic import ValidationError
from sqlalchemy import Select, delete, func, select
from sqlalchemy.orm import Session

from app.agents.running_world import RunningWorld, WorldHost, WorldState
from app.agents.running_worlds import RunningWorlds
from app.agents.speech import end_conversations
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK
from app.domain.errors import Busy, Conflict, Invalid, UnknownWorld
from app.domain.events import WorldAdded, WorldRemoved
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.hold import HoldEnding
from app.domain.lifecycles.mission import OPEN
from app.domain.lifecycles.script import release_abandoned
from app.domain.world_model import initial_facts
from app.domain.world_model.numbers import initial_numbers
from app.missions.dialogues import end_dialogues
from app.missions.world_start import UNKNOWN_RUN, start_world_run
from app.planning.hold_service import end_hold
from app.store import (
    AddedWorldRow,
    ConversationRow,
    DialogueRow,
    EditionRow,
    FactsheetRow,
    GoalRow,
    LeaseRow,
    LostRobotRow,
    MissionRow,
    OutOfServiceRow,
    RoleRow,
    RulesRow,
    ScriptRow,
    TuningRow,
    UnknownRow,
    WorldRow,
    announce,
    is_unavailable,
)
from app.store.editions import WorldDirectory, file_edition, newest_edition
from app.store.standing_holds import standing_rows
from app.store.tables import utc_now
from app.workflows.background import Background
from planner import KnowledgeBaseError
from robots.wire import PacketTunings
from robots.world import Edition, WorldFile, WorldFileError, read_world

WORLDS = "worlds"
"""The topic of other processes' announcements that worlds were added or removed, and the lock for doing so."""
SHOWN = 20
"""How many goals and missions a refusal names."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class FileChecks:
    """What is checked of a world file besides its own rules.

    :param tags: of the packets that robots may have.
    :param tuning: raises a `RobotError` if a robot's tuning is not valid. :param rules: the same of its rule files.
    """

    tags: Collection[str]
    tuning: Callable[[PacketTunings], object]
    rules: Callable[[Mapping[str, str]], object]


class WorldSet:
    """Adds and removes worlds, and has this process run those that the record says are added."""

    def __init__(
        self,
        core: Core,
        *,
        files: WorldDirectory,
        running: RunningWorlds,
        host: WorldHost | None,
        checks: FileChecks,
        limit: int,
    ) -> None:
        """
        :param files, running: which hold the worlds that were given at the start.
        :param host: makes added worlds run; None: none can be added.
        :param limit: the most worlds that may run.
        """
        self._core = core
        self._database = core.database
        self._files = files
        self._running = running
        self._host = host
        self._checks = checks
        self._limit = limit
        self._given = frozenset(files)
        self._opened: dict[str, str] = {}
        """When each added world that runs here was added."""
        self._has_started = False
        self._lock = Lock()
        self._news = Event()
        self._background = Background("worlds", self._run)

    @property
    def topics(self) -> Mapping[str, Callable[[], None]]:
        """The announcements of other processes that this handles, each with its handler."""
        return {WORLDS: self._news.set} if self._follows_others else {}

    @property
    def _follows_others(self) -> bool:
        """True if other processes may add worlds: they have fleets, for a simulation is only one process's."""
        return self._host is not None and self._database.shared and not self._host.simulates

    def restore(self) -> None:
        """Know the worlds that were added earlier; before workflows that may concern them run."""
        self.follow()

    def start(self) -> None:
        """Exchange messages with the added worlds from now on, and follow what other processes add and remove."""
        with self._lock:
            self._has_started = True
            for name in self._opened:
                self._running.start(name)
        if self._follows_others:
            self._running.unknown = self.follow
        if self._host is not None:
            self._background.start()

    def close(self) -> None:
        self._background.ending.set()
        self._news.set()
        self._background.end()

    def those(self, state: WorldState) -> list[str]:
        """The worlds in this state."""
        return sorted(name for name, world in self._running.items() if world.status().state is state)

    def find(self, name: str) -> None:
        """Look again whether another process has added a world of that name, unless it is known."""
        if name not in self._files and self._follows_others:
            self.follow()

    def read(self, text: str, origin: str) -> WorldFile:
        """The world that a text describes, checked as one that is given at the start.

        :raises WorldFileError: naming the place in the text and the choices.
        """
        checks = self._checks
        world = read_world(
            text, origin, tags=checks.tags, check_tuning=checks.tuning, check_rules=checks.rules
        )
        try:
            initial_facts(world, self._core.knowledge_base)
            initial_numbers(world, self._core.knowledge_base)
        except (KnowledgeBaseError, Invalid) as error:
            raise WorldFileError(f"{origin} is not a valid world:", [f"facts: {error}"]) from error
        return world

    def check(self, file: WorldFile, *, rate: float | None) -> None:
        """Raise what `add` would."""
        with self._database.read() as session:
            self._refuse(session, file, rate)

    def add(self, file: WorldFile, *, rate: float | None, actor: str, reason: str) -> None:
        """Add a world, which starts at once, and again with the service.

        :param rate: world seconds per wall-clock second; None: the service's.
        :raises Conflict: if a name is in use. :raises Busy: if too many worlds run.
        :raises Invalid: if the rate is not the service's to choose.
        """
        with self._database.write() as session:
            self._database.lock(session, WORLDS)
            self._refuse(session, file, rate)
            recorded = session.scalar(
                select(func.max(EditionRow.edition)).where(EditionRow.world == file.name)
            )
            number = (recorded or 0) + 1
            self._core.events.append(
                session,
                WorldAdded(
                    subject=file.name,
                    edition=number,
                    robots=tuple(robot.name for robot in file.robots),
                    actor=actor,
                    reason=reason,
                ),
            )
            start_world_run(session, self._core, file, UNKNOWN_RUN)
            row = session.get(AddedWorldRow, file.name, with_for_update=True)
            if row is None:
                row = AddedWorldRow(world=file.name)
                session.add(row)
            row.document = file.model_dump(mode="json")
            row.rate = rate
            row.added_by = actor
            row.reason = reason
            row.added_at = utc_now()
            row.removed_at = None
            row.removed_by = None
            row.removal_reason = None
            session.add(file_edition(Edition(number, file), actor=actor, reason=reason))
            announce(session, WORLDS)
        self._apply()

    def remove(self, name: str, *, actor: str, reason: str) -> None:
        """Remove a world that was added: what drives it here ends, and its history stays.

        :raises NotFound: if there is none.
        :raises Conflict: if it was given at the start, or goals or missions are open in it.
        """
        self.find(name)
        if name in self._given:
            raise Conflict(
                f"{name} was given at the start of the service: start it without the world to remove that",
                code="world-of-the-start",
                thing=name,
            )
        file = self._files.get(name)
        with self._database.write() as session:
            self._database.lock(session, WORLDS)
            row = session.get(AddedWorldRow, name, with_for_update=True)
            if row is None or row.removed_at is not None:
                raise UnknownWorld(name, self._files)
            _release_abandoned(session, name)  # lock order: scripts before the world
            world = session.get_one(WorldRow, name, with_for_update=True)
            _refuse_in_use(session, name)
            for hold in standing_rows(session, name):
                end_hold(
                    session,
                    self._core.events,
                    hold,
                    HoldEnding.WORLD_REMOVED,
                    SYSTEM_CLOCK.epoch_s(),
                    actor=actor,
                    comment=reason,
                )
            row.removed_at = utc_now()
            row.removed_by = actor
            row.removal_reason = reason
            world.run = None
            end_conversations(session, name, "the world is removed")
            end_dialogues(session, self._core.events, name, "the world is removed")
            _forget_robots(session, name)
            self._core.events.append(session, WorldRemoved(subject=name, actor=actor, reason=reason))
            announce(session, WORLDS)
        self._apply()
        if file is not None and self._host is not None:
            self._host.forget(file)

    def _apply(self) -> None:
        """Do what is recorded now; if that fails, again in the background."""
        try:
            self.follow()
        except BaseException:
            self._news.set()
            raise

    def follow(self) -> None:
        """Run the added worlds that the record has, and no others of them."""
        if self._host is None:
            return
        with self._lock:
            gone = self._gone(self._rows())
        # Without the lock: the threads that end here may be about to look for a world themselves.
        for name in gone:
            self._running.stop(name)
        with self._lock:
            removed = [self._forget(name) for name in self._gone(self._rows()) if name in gone]
        for world in removed:
            world.close()
        with self._lock:
            for row in self._rows():
                if row.world not in self._opened:
                    self._open(self._host, row)

    def _rows(self) -> Sequence[AddedWorldRow]:
        query = _added().where(AddedWorldRow.world.not_in(self._given))
        with self._database.read() as session:
            return session.scalars(query.order_by(AddedWorldRow.added_at, AddedWorldRow.world)).all()

    def _gone(self, rows: Sequence[AddedWorldRow]) -> Sequence[str]:
        """The worlds that were removed, perhaps added again since."""
        wanted = {row.world: row.added_at for row in rows}
        return [name for name, added_at in self._opened.items() if wanted.get(name) != added_at]

    def _forget(self, name: str) -> RunningWorld:
        """Know the world no longer; returns it, to be closed."""
        del self._opened[name]
        self._files.remove(name)
        return self._running.remove(name)

    def _open(self, host: WorldHost, row: AddedWorldRow) -> None:
        try:
            file = WorldFile.model_validate(row.document)
        except ValidationError:
            logger.exception("the added world %s cannot be read by this version", row.world)
            return
        with self._database.read() as session:
            edition = newest_edition(session, file)
        self._running.add(host.open(file, rate=row.rate))
        self._files.add(file, edition)
        self._opened[row.world] = row.added_at
        if self._has_started:
            self._running.start(row.world)

    def _run(self) -> None:
        while not self._background.ending.is_set():
            self._news.wait()
            self._news.clear()
            if self._background.ending.is_set():
                return
            try:
                self.follow()
            except Exception as error:
                if not is_unavailable(error):
                    logger.exception("following the added worlds failed")
                self._background.ending.wait(1.0)
                self._news.set()

    def _refuse(self, session: Session, file: WorldFile, rate: float | None) -> None:
        if self._host is None:
            raise Conflict("the worlds of this service are fixed", code="worlds-fixed")
        if rate is not None and not self._host.simulates:
            raise Invalid(
                "the rate is chosen by the fleet that drives the world: `macta fleet --speed`",
                code="rate-of-fleet",
                thing="rate",
            )
        self._refuse_names(session, file)
        running = set(self._files) | {row.world for row in session.scalars(_added())}
        if len(running) >= self._limit:
            raise Busy(
                f"{len(running)} worlds run, the limit is {self._limit} (MACTA_WORLDS); remove one",
                code="too-many-worlds",
            )

    def _refuse_names(self, session: Session, file: WorldFile) -> None:
        """Refuse the names of worlds and robots that are in use; robots are known by theirs in all worlds."""
        self._files.read(session)
        known = dict(self._files)
        for row in session.scalars(_added()):
            if row.world not in known:  # another process has added it just now
                known[row.world] = WorldFile.model_validate(row.document)
        if file.name in known:
            raise Conflict(
                f"name: a world {file.name} runs already; the worlds are {', '.join(sorted(known))}",
                code="name-in-use",
                thing=file.name,
            )
        others = {robot.name: name for name, other in known.items() for robot in other.agents}
        for index, robot in enumerate(file.agents):
            if robot.name in others:
                raise Conflict(
                    f"robots.{index}.name: {others[robot.name]} has a robot {robot.name}; robots are known by their "
                    "names in all worlds of a service",
                    code="name-in-use",
                    thing=robot.name,
                )


def _added() -> Select[AddedWorldRow]:
    return select(AddedWorldRow).where(AddedWorldRow.removed_at.is_(None))


def _refuse_in_use(session: Session, world: str) -> None:
    """:raises Conflict: naming the world's open missions and goals."""
    missions = session.scalars(
        select(MissionRow.id).where(MissionRow.world == world, MissionRow.state.in_(OPEN))
    ).all()
    open_goals = (GoalRow.world == world, GoalRow.state.in_(goal_lifecycle.OPEN))
    goals = session.scalars(select(GoalRow.id).where(*open_goals)).all()
    if missions:
        raise Conflict(
            f"missions are open in {world}: {_listed(missions)}; cancel them, or wait for their ends",
            code="world-in-use",
            thing=missions[0],
        )
    if goals:
        raise Conflict(
            f"goals are open in {world}: {_listed(goals)}; cancel them", code="world-in-use", thing=goals[0]
        )


def _listed(ids: Sequence[str]) -> str:
    more = f" and {len(ids) - SHOWN} more" if len(ids) > SHOWN else ""
    return ", ".join(sorted(ids)[:SHOWN]) + more


def _forget_robots(session: Session, world: str) -> None:
    """Drop what is recorded of the robots' and samples' present state, and the world's lease."""
    for table in (
        UnknownRow,
        LostRobotRow,
        OutOfServiceRow,
        TuningRow,
        RulesRow,
        RoleRow,
        FactsheetRow,
        LeaseRow,
        ConversationRow,
        DialogueRow,
    ):
        session.execute(delete(table).where(table.world == world))


def _release_abandoned(session: Session, world: str) -> None:
    """Drop the orders to stop for lost robots."""
    missions = select(MissionRow.id).where(MissionRow.world == world)
    abandoned = select(ScriptRow).where(ScriptRow.abandoned, ScriptRow.mission_id.in_(missions))
    for script in session.scalars(abandoned.with_for_update()).all():
        release_abandoned(script)
