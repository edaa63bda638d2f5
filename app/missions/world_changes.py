"""Changes of a world while it runs: checked, recorded as an edition with its reason, and undone."""

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from pydantic import TypeAdapter, ValidationError
from sqlalchemy import delete, select
from sqlalchemy.orm import Session, defer

from app.agents.rules import renew_rules
from app.agents.speech import end_with_robots
from app.agents.tuning import renew_tunings
from app.core import Core
from app.domain.errors import Conflict, Invalid, MactaError, NotFound, Outdated
from app.domain.events import WorldChanged
from app.domain.lifecycles.factsheet import IN_WORLD
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.script import release_abandoned
from app.domain.plan_document import PlanBody
from app.domain.world_model import Change, Facts, broken_support, revise_beliefs
from app.domain.world_model.beliefs import OBJECT_POSITION
from app.domain.world_model.berths import berths_of
from app.domain.world_model.edits import (
    AddPeripheral,
    AddRobot,
    AddSample,
    AnyEdit,
    ChangeRobot,
    EditedWorld,
    WorldEdit,
    apply_edits,
)
from app.domain.world_model.senses import Perceives, restricted_senses, unsensed
from app.domain.world_model.zones import restricted_places, zones_against
from app.missions.embodiment_record import end_for_replaced
from app.missions.world_set import FileChecks
from app.planning.waiting_goals import WaitingGoals
from app.store import (
    DialogueRow,
    EditionRow,
    EmbodimentRow,
    FactsheetRow,
    LostRobotRow,
    MissionRow,
    OutOfServiceRow,
    PlanRow,
    RoleRow,
    RulesRow,
    ScriptRow,
    TuningRow,
    UnknownRow,
    after_commit,
)
from app.store.editions import WorldDirectory
from app.store.event_log import EventLog
from app.store.facts import source_of
from app.store.records import lock_running_missions
from app.workflows.mission_wakeups import wake_missions
from robots.clock import Clock
from robots.errors import RobotError
from robots.wire import PacketTunings, SampleReport
from robots.world import Edition, Sample, WorldFile

NEEDED = "needed-by-mission"
"""The code of a refusal because of a running mission."""
EDITS: TypeAdapter[list[AnyEdit]] = TypeAdapter(list[AnyEdit])

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedChange:
    """What a change would make of a world.

    :param edition: its number.
    :param outdated: the open plans that would be out of date.
    """

    edition: int
    edited: EditedWorld
    change: Change
    outdated: Sequence[str] = ()


class WorldChanges:
    """Changes worlds, all edits of a change or none."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: WorldDirectory,
        clocks: Mapping[str, Clock],
        waiting: WaitingGoals,
        checks: FileChecks,
        perceives: Perceives | None = None,
        is_connected: Callable[[str], bool] = lambda robot: False,
    ) -> None:
        """
        :param clocks: the worlds' clocks by the world's name.
        :param is_connected: whether somebody speaks for a robot now.
        :param checks: of robots that are added or changed.
        :param perceives: what robots sense by their sensors that do not say what they sense; None: all.
        """
        self._is_connected = is_connected
        self._perceives = perceives
        self._checks = checks
        self._core = core
        self._worlds = worlds
        self._clocks = clocks
        self._waiting = waiting

    def edition(self, world: str) -> int:
        """The number of the world's edition."""
        return self._worlds.edition(world).number

    def history(self, world: str, *, limit: int, before: int | None) -> Sequence[EditionRow]:
        """The editions since the world's file, newest first, without their documents; also of a world that was removed.

        :param before: only those before this edition; None: all.
        """
        query = select(EditionRow).where(EditionRow.world == world).options(defer(EditionRow.document))
        if before is not None:
            query = query.where(EditionRow.edition < before)
        with self._core.database.read() as session:
            rows = session.scalars(query.order_by(EditionRow.edition.desc()).limit(limit)).all()
        if not rows and before is None:
            self._worlds.refuse_unknown(world)
        return rows

    def check(self, world: str, edits: Sequence[WorldEdit], *, expected: int | None) -> CheckedChange:
        """What the edits would change; raises what `change` would."""
        self._worlds.refuse_unknown(world)
        with self._core.database.read() as session:
            checked = self.checked(session, world, edits, expected)
            compared = self._core.facts.numbers.compared(session, world)
            return replace(checked, outdated=self._outdated(session, checked.edited, compared))

    def change(
        self,
        world: str,
        edits: Sequence[WorldEdit],
        *,
        actor: str,
        source: str,
        reason: str,
        expected: int | None,
    ) -> EditionRow:
        """Make the edits.

        :param source: of the facts that they bring.
        :param expected: the edition that they were made from; None: any.
        :raises Invalid, NotFound: if an edit can never be made in the world as it is.
        :raises Conflict: if facts, or running missions, do not permit it now.
        :raises Outdated: if the world was changed since `expected`.
        """
        self._worlds.refuse_unknown(world)
        with self._core.database.write() as session:
            return self.make(
                session, world, edits, actor=actor, source=source, reason=reason, expected=expected
            )

    def discover(self, world: str, robot: str, report: SampleReport) -> None:
        """Add a sample that a robot has seen, unless it is known. What was believed to lie there is not any longer.

        What missions need does not matter: the sample is there. A robot sees nothing where it cannot be, and nothing
        that has the name of something else.
        """
        with self._core.database.write() as session:
            lock_running_missions(session, world)
            self._core.facts.lock(session, world)
            self._worlds.read(session)
            known = self._worlds[world]
            is_known = any(one.name == report.sample for one in known.samples)
            if is_known or report.place not in known.reached_by.get(robot, ()):
                return
            try:
                edit = AddSample(sample=Sample(name=report.sample, at=report.place))
                self.checked(session, world, [edit], observed=True)
            except (MactaError, ValidationError) as error:
                logger.warning("%s reports a sample that cannot be: %s", robot, str(error).splitlines()[0])
                return
            self.make(
                session,
                world,
                [edit],
                actor=robot,
                source=source_of(robot),
                reason=f"{robot} saw {report.sample} in {report.place}",
                observed=True,
            )

    def undo(self, world: str, edition: int, *, actor: str, reason: str, expected: int | None) -> EditionRow:
        """Take an edition back, by a further one; checked as any other change.

        :raises NotFound: if there is no such edition. :raises Conflict: if it cannot be undone, or was.
        """
        self._worlds.refuse_unknown(world)
        with self._core.database.write() as session:
            row = session.get(EditionRow, (world, edition), with_for_update=True)
            if row is None:
                numbers = session.scalars(select(EditionRow.edition).where(EditionRow.world == world)).all()
                raise NotFound(
                    f"{world} has no edition {edition}",
                    code="unknown-edition",
                    choices=[str(n) for n in sorted(numbers)],
                )
            if row.undone_by is not None:
                raise Conflict(
                    f"edition {edition} was undone by edition {row.undone_by}", code="already-undone"
                )
            if not row.undo:
                raise Conflict(
                    f"edition {edition} is another world file; start the service with the earlier file",
                    code="not-undoable",
                )
            made = self.make(
                session,
                world,
                EDITS.validate_python(row.undo),
                actor=actor,
                source=f"operator {actor}",
                reason=reason or f"undoes edition {edition}: {row.reason}",
                expected=expected,
                undoes=edition,
            )
            row.undone_by = made.edition
            return made

    def make(
        self,
        session: Session,
        world: str,
        edits: Sequence[WorldEdit],
        *,
        actor: str,
        source: str,
        reason: str,
        expected: int | None = None,
        undoes: int | None = None,
        observed: bool = False,
        resting: Collection[str] = (),
    ) -> EditionRow:
        """Make the edits within a transaction; see `change`. It locks the world's missions, then the world.

        :param observed: the edits were seen to be so: beliefs and missions in the way give way.
        :param resting: robots whose minds rest: their bodies are exchanged though missions need them, and another
            program goes on with what the one before has in mind.
        """
        core = self._core
        lock_running_missions(session, world)  # lock order: missions before the world
        row = core.facts.lock(session, world)
        checked = self.checked(session, world, edits, expected, observed=observed, resting=resting)
        edited = checked.edited
        at_s = self._clocks[world].now_s()
        change = checked.change
        version = row.version
        core.facts.numbers.lay_out(session, row, edited.world)
        core.facts.change(
            session,
            world,
            add=change.add,
            remove=change.remove,
            source=source,
            at_s=at_s,
            corrects=observed,
        )
        row.version = max(row.version, version + 1)  # what readers compare; an edit may change no fact
        session.flush()
        core.facts.numbers.complete(session, edited.world, edited.facts, source=source, at_s=at_s)
        _forget_gone(session, edited.world)
        _forget_replaced(session, core.events, edited, resting)
        recorded = EditionRow(
            world=world,
            edition=checked.edition,
            document=edited.world.model_dump(mode="json"),
            file_digest=self._worlds.file_digest(world),
            edits=[edit.model_dump(mode="json") for edit in edited.made],
            undo=[edit.model_dump(mode="json") for edit in edited.undo],
            actor=actor,
            reason=reason,
            at_s=at_s,
            undoes=undoes,
        )
        session.add(recorded)
        event = WorldChanged(
            subject=world,
            edition=checked.edition,
            changes=tuple(map(str, edited.made)),
            actor=actor,
            reason=reason,
            undoes=undoes,
        )
        core.events.append(session, event)
        session.flush()
        self._waiting.release(session, world)
        wake_missions(session, core.workflows, world)
        after_commit(session, lambda: self._worlds.put(Edition(checked.edition, edited.world)))
        return recorded

    def checked(
        self,
        session: Session,
        world: str,
        edits: Sequence[WorldEdit],
        expected: int | None = None,
        *,
        observed: bool = False,
        resting: Collection[str] = (),
    ) -> CheckedChange:
        """What the edits would change, within a transaction; raises what `make` would."""
        self._worlds.read(session)
        edition = self._worlds.edition(world)
        if expected not in (None, edition.number):
            raise Outdated(
                f"{world} is at edition {edition.number}, the change was made from {expected}",
                code="world-changed",
            )
        facts = self._core.facts.facts(session, world)
        supposed = facts
        if observed:
            places = frozenset().union(*(edit.touched for edit in edits))
            wrong = [f for f in facts if f.predicate == OBJECT_POSITION and f.args[2] in places]
            supposed = revise_beliefs(facts, (), wrong)
        edited = apply_edits(edition.world, edits, supposed, self._core.knowledge_base)
        if not observed:
            self._refuse_needed(session, edition.world, edited, resting)
            self._refuse_connected(edition.world, edited, resting)
            self._refuse_foreign(world, edited)
        return CheckedChange(
            edition=edition.number + 1,
            edited=edited,
            change=edited.change(facts),
        )

    def _refuse_foreign(self, world: str, edited: EditedWorld) -> None:
        """Refuse robots that another world has, whose tags are no packet's, or whose tuning or rules do not fit."""
        others = {
            robot.name: name for name, file in self._worlds.items() if name != world for robot in file.agents
        }
        for index, edit in enumerate(edited.made):
            if (name := _new_agent(edit)) in others:
                raise Invalid(
                    f"edits.{index}: {others[name]} has a robot {name}; robots are known by their names in all worlds "
                    "of a service",
                    code="name-in-use",
                    thing=name,
                )
            tags = self._checks.tags
            if (tag := next((tag for tag in _tags_of(edit) if tag not in tags), None)) is not None:
                raise Invalid(
                    f"edits.{index}: repertoire: no packet of a repertoire has the tag {tag!r}",
                    code="unknown-tag",
                    choices=sorted(tags),
                    thing=tag,
                )
            try:
                self._checks.tuning(_tuning_of(edit))
            except RobotError as error:
                raise Invalid(f"edits.{index}: tuning: {error}", code="unfit-tuning") from error
            try:
                self._checks.rules(edit.robot.rule_files if isinstance(edit, AddRobot) else {})
            except RobotError as error:
                raise Invalid(f"edits.{index}: rules: {error}", code="unfit-rules") from error

    def _refuse_needed(
        self, session: Session, before: WorldFile, edited: EditedWorld, resting: Collection[str]
    ) -> None:
        """Refuse edits of what a running mission still needs, and zones to keep out of, or for one robot, with such a
        place."""
        restricted = restricted_places(edited.world)
        closed = restricted.keys() - restricted_places(before).keys()
        for mission in self._core.reservations.of_world(session, before.name):
            if needed := sorted(closed & mission.reservation.names):
                raise Conflict(
                    f"{restricted[needed[0]]}: mission {mission.mission_id} still needs "
                    f"{', '.join(needed)}; cancel it, or wait for its end",
                    code=NEEDED,
                    thing=needed[0],
                )
            for index, edit in enumerate(edited.made):
                if isinstance(edit, ChangeRobot):
                    robot = before.robots_by_name.get(edit.name)
                    if edit.name in resting or (robot is not None and edit.swaps_ring(robot)):
                        continue
                names = {berth for name in edit.touched for berth in (name, *berths_of(name, before))}
                if needed := sorted(names & mission.reservation.names):
                    raise Conflict(
                        f"edits.{index}: mission {mission.mission_id} still needs {', '.join(needed)}; cancel it, or "
                        "wait for its end",
                        code=NEEDED,
                        thing=needed[0],
                    )

    def _refuse_connected(self, before: WorldFile, edited: EditedWorld, resting: Collection[str]) -> None:
        """Refuse a twin for a robot that is connected: both would follow the twin's orders."""
        for index, edit in enumerate(edited.made):
            if not isinstance(edit, ChangeRobot) or edit.external is not False or edit.name in resting:
                continue
            robot = before.robots_by_name.get(edit.name)
            if robot is not None and robot.external and self._is_connected(edit.name):
                raise Conflict(
                    f"edits.{index}: {edit.name} is connected and would follow the orders of its twin, too; "
                    "disconnect it first, and wait until it is offline",
                    code="robot-connected",
                    thing=edit.name,
                )

    def _outdated(self, session: Session, edited: EditedWorld, compared: Facts) -> Sequence[str]:
        """The open plans that the facts no longer support, or that do not keep to a zone.

        :param compared: the facts that stand for comparisons of numbers.
        """
        world = edited.world
        query = select(PlanRow).where(PlanRow.world == world.name, PlanRow.state == PlanState.PROPOSED)
        base = self._core.knowledge_base
        senses = restricted_senses(world, base, self._perceives)
        nets = {
            plan.id: PlanBody.model_validate(plan.body).to_plan_net(base)
            for plan in session.scalars(query.order_by(PlanRow.created_at, PlanRow.id))
        }
        return [
            plan
            for plan, net in nets.items()
            if broken_support(net, edited.facts | compared)
            or any(zones_against(net, world))
            or any(unsensed(net, senses, base))
        ]


def _new_agent(edit: WorldEdit) -> str:
    """The name of the robot or peripheral that the edit adds; empty if it adds none."""
    match edit:
        case AddRobot(robot=robot):
            return robot.name
        case AddPeripheral(peripheral=peripheral):
            return peripheral.name
    return ""


def _tags_of(edit: WorldEdit) -> Sequence[str]:
    """The packets that a robot has after the edit."""
    match edit:
        case AddRobot(robot=robot):
            return robot.repertoire
        case ChangeRobot(repertoire=repertoire):
            return repertoire or ()
    return ()


def _tuning_of(edit: WorldEdit) -> PacketTunings:
    """What a robot's packets are tuned to by the edit."""
    match edit:
        case AddRobot(robot=robot):
            return robot.tuning
        case ChangeRobot(tuning=tuning):
            return tuning or {}
    return {}


def _forget_replaced(
    session: Session, events: EventLog, edited: EditedWorld, resting: Collection[str]
) -> None:
    """Drop the factsheets of robots in whose place others speak from now on. If these begin without the robots' minds,
    end their leases and the moves of their minds; those get tunings and rules again.
    """
    world = edited.world.name
    replaced = [edit.name for edit in edited.made if isinstance(edit, ChangeRobot) and edit.replaces]
    if replaced:
        session.execute(
            delete(FactsheetRow).where(FactsheetRow.world == world, FactsheetRow.robot.in_(replaced))
        )
        without_mind = [name for name in replaced if name not in resting]
        renew_tunings(session, world, without_mind)
        renew_rules(session, world, without_mind)
        end_for_replaced(session, events, edited.world, without_mind)


def _forget_gone(session: Session, world: WorldFile) -> None:
    """Drop what is recorded of samples and robots that the world no longer has."""
    here = {one.name for one in world.agents} | {one.name for one in world.samples}
    session.execute(delete(UnknownRow).where(UnknownRow.world == world.name, UnknownRow.name.not_in(here)))
    end_with_robots(session, world.name, here)  # lock order: conversations before dialogues
    tables = (
        LostRobotRow,
        OutOfServiceRow,
        TuningRow,
        RulesRow,
        RoleRow,
        DialogueRow,
        EmbodimentRow,
    )
    for table in tables:
        session.execute(delete(table).where(table.world == world.name, table.robot.not_in(here)))
    session.execute(
        delete(FactsheetRow).where(
            FactsheetRow.world == world.name,
            FactsheetRow.robot.not_in(here),
            FactsheetRow.state.in_(IN_WORLD),
        )
    )
    missions = select(MissionRow.id).where(MissionRow.world == world.name)
    abandoned = select(ScriptRow).where(ScriptRow.abandoned, ScriptRow.mission_id.in_(missions))
    for script in session.scalars(abandoned.where(ScriptRow.robot.not_in(here))).all():
        release_abandoned(script)  # a lost robot that is removed is not ordered to stop
