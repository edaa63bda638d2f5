"""The robots as clients see them: newest telemetry, contact, reservation and loss of each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from sqlalchemy import or_, select
from sqlalchemy.orm import Session

from app.agents.contact_monitor import ContactMonitor
from app.agents.impersonation import Impersonation
from app.agents.robot_board import RobotBoard, RobotView
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.contact import Connection
from app.domain.errors import NotFound, UnknownWorld
from app.domain.goal_language.words import natural_key
from app.domain.lifecycles.mission import OPEN
from app.domain.lifecycles.script import TERMINAL_SCRIPTS, Delivery
from app.domain.world_model.beliefs import LIFT_AT, STATES
from app.domain.world_model.senses import Perceives, senses_of
from app.store import LostRobotRow, MissionRow, OutOfServiceRow, ScriptRow, UnaskedRobotRow
from app.store.records import lost_robots, robots_out_of_service, unasked_robots
from app.store.roles import roles_of
from planner import Fact
from robots.world import Peripheral, RobotSpec, WorldFile
from robots.world.bodies import BodyKind, kind_of

ROBOT = "robot"
"""The kind of what drives."""

Noted = TypeVar("Noted", LostRobotRow, OutOfServiceRow, UnaskedRobotRow)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotReport:
    """A robot, or a door, hatch or lift, and what is known of it now.

    :param kind: `robot`, or the peripheral's.
    :param state: how a peripheral is believed to stand, in words of its facts; empty for a robot.

    :param world_stands: True while its simulated world stands at a breakpoint.
    :param silent: True if nothing was received from it for longer than the gaps of its radio.
    :param next_contact_s: world seconds until contact is expected.
    :param senses: the predicates whose facts it senses.
    :param mission_id: the mission that it is reserved for.
    :param role: that it plays; None: none.
    :param body: of a robot, what kind of body its mind is in; None of a peripheral.
    :param lost: set if it was declared lost.
    :param out_of_service: set if it was taken out of service.
    :param unasked: set if it does not understand status queries.
    :param impersonation: set if somebody else publishes in its name.
    """

    view: RobotView
    kind: str
    state: str
    connection: Connection
    world_stands: bool
    last_heard_s: float | None
    silent: bool
    next_contact_s: float
    repertoire: Sequence[str]
    senses: Sequence[str]
    reach: Sequence[str]
    mission_id: str | None
    role: str | None
    body: BodyKind | None
    lost: LostRobotRow | None
    out_of_service: OutOfServiceRow | None
    unasked: UnaskedRobotRow | None
    impersonation: Impersonation | None


class RobotDirectory:
    """Reads the robots of all worlds."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        board: RobotBoard,
        contact: ContactMonitor,
        perceives: Perceives,
        impersonation: Callable[[str], Impersonation | None] = lambda robot: None,
        stands: Callable[[str], bool] = lambda world: False,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param perceives: what robots sense by their sensors that do not say what they sense.
        :param stands: whether a world stands at a breakpoint.
        """
        self._database = core.database
        self._facts = core.facts
        self._worlds = worlds
        self._board = board
        self._contact = contact
        self._impersonation = impersonation
        self._wall = wall
        self._perceives = perceives
        self._stands = stands

    def robots(self, world: str | None = None) -> list[RobotReport]:
        """The robots of a world, or of all worlds, in alphabetical order.

        :raises NotFound: if there is no such world.
        """
        return [report for report in self._agents(world) if report.kind == ROBOT]

    def peripherals(self, world: str | None = None) -> list[RobotReport]:
        """The doors, hatches and lifts of a world, or of all worlds, in alphabetical order.

        :raises NotFound: if there is no such world.
        """
        return [report for report in self._agents(world) if report.kind != ROBOT]

    def _agents(self, world: str | None) -> list[RobotReport]:
        if world is not None and world not in self._worlds:
            raise UnknownWorld(world, self._worlds)
        views = self._board.views(world)
        with self._database.read() as session:
            missions = _missions_by_robot(session)
            lost = self._by_robot(session, lost_robots)
            resting = self._by_robot(session, robots_out_of_service)
            unasked = self._by_robot(session, unasked_robots)
            roles = {
                (name, robot): role.name
                for name, file in self._worlds.items()
                for robot, role in roles_of(session, file).items()
            }
            states = {
                (name, fact.args[0]): fact
                for name, file in self._worlds.items()
                if file.peripherals
                for fact in self._facts.facts(session, name)
                if fact.predicate in STATES
            }
        standing = {name for name in {view.world for view in views.values()} if self._stands(name)}
        reports = []
        for name in sorted(views, key=natural_key):
            view = views[name]
            key = (view.world, name)
            try:
                spec = self._worlds[view.world].agents_by_name.get(name)
                if spec is not None:
                    state = states.get(key)
                    reports.append(
                        self._report(
                            view,
                            spec,
                            missions.get(key),
                            roles.get(key),
                            world_stands=view.world in standing,
                            state="" if state is None else _state_words(state),
                            lost=lost.get(key),
                            out_of_service=resting.get(key),
                            unasked=unasked.get(key),
                        )
                    )
            except KeyError:
                if view.world in self._worlds:  # else it was removed just now
                    raise
        return reports

    def _by_robot(
        self, session: Session, of_world: Callable[[Session, str], Sequence[Noted]]
    ) -> Mapping[tuple[str, str], Noted]:
        """The rows of all worlds, by world and robot."""
        return {(row.world, row.robot): row for name in self._worlds for row in of_world(session, name)}

    def robot(self, name: str) -> RobotReport:
        reports = {report.view.name: report for report in self._agents(None)}
        if name not in reports:
            raise NotFound(f"unknown robot {name!r}", code="unknown-robot", choices=[*reports])
        return reports[name]

    def _report(
        self,
        view: RobotView,
        spec: RobotSpec | Peripheral,
        mission_id: str | None,
        role: str | None,
        *,
        world_stands: bool,
        state: str,
        lost: LostRobotRow | None,
        out_of_service: OutOfServiceRow | None,
        unasked: UnaskedRobotRow | None,
    ) -> RobotReport:
        monotonic_s = self._wall.monotonic_s()
        world = self._worlds[view.world]
        return RobotReport(
            view=view,
            kind=spec.kind.value if isinstance(spec, Peripheral) else ROBOT,
            state=state,
            # Nothing is heard of a world that stands: that is no silence.
            connection=Connection.ONLINE
            if world_stands and not view.is_gone
            else view.connection(monotonic_s),
            world_stands=world_stands,
            last_heard_s=None
            if view.heard_monotonic_s is None
            else round(monotonic_s - view.heard_monotonic_s, 3),
            silent=self._contact.silent_in_s(view.name) == 0,
            next_contact_s=round(self._contact.next_contact_s(view.name), 3),
            repertoire=spec.repertoire,
            senses=sorted(senses_of(spec, self._perceives)) if isinstance(spec, RobotSpec) else (),
            reach=world.reached_by.get(view.name, ()),
            mission_id=mission_id,
            role=role,
            body=kind_of(spec.body, external=spec.external) if isinstance(spec, RobotSpec) else None,
            lost=lost,
            out_of_service=out_of_service,
            unasked=unasked,
            impersonation=self._impersonation(view.name),
        )


def _state_words(fact: Fact) -> str:
    """`opened`, `closed`, or the level at which a lift is."""
    return fact.args[1] if fact.predicate == LIFT_AT else fact.predicate


def _missions_by_robot(session: Session) -> Mapping[tuple[str, str], str]:
    """The open mission of each robot, by world and robot."""
    query = (
        select(MissionRow.world, ScriptRow.robot, MissionRow.id)
        .join(ScriptRow, ScriptRow.mission_id == MissionRow.id)
        .where(
            MissionRow.state.in_(OPEN),
            ScriptRow.delivery != Delivery.REFUSED,
            ScriptRow.plan_id == MissionRow.plan_id,
            or_(ScriptRow.state.is_(None), ScriptRow.state.not_in(TERMINAL_SCRIPTS)),
        )
    )
    return {(world, robot): mission for world, robot, mission in session.execute(query)}
