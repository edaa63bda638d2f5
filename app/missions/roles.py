"""The roles that operators give robots (docs/rules.md): a rule file, what they are recruited for, and a home."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from sqlalchemy.orm import Session

from app.agents.rules import RuleService
from app.agents.tuning import robot_and_world
from app.core import Core
from app.domain.errors import Conflict, Invalid, MactaError, Outdated
from app.domain.events import RoleCleared, RoleSet
from app.domain.world_model.edits import ChangeRobot
from app.missions.world_changes import WorldChanges
from app.planning.waiting_goals import WaitingGoals
from app.store import RoleRow
from app.store.editions import WorldDirectory
from app.store.records import lock_running_missions
from app.store.roles import role_in_force
from app.store.tables import utc_now
from robots.world import RobotSpec, RoleSpec, WorldFile


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotRole:
    """A robot's role.

    :param role: None: it plays none.
    :param tags: the packets that it is recruited for; None: all of its repertoire.
    :param home: that the role brings; None: it brings none.
    :param home_kept: why the robot did not get back the home that it had before its last role; empty: it did, or the
        role had brought none.
    :param rules: the text of the role's rule file, if one was stated.
    :param played: the role that the robot said to play; empty: none.
    :param rules_version: of the rules by which it was told; `delivery` and `detail` are theirs.
    """

    robot: str
    world: str
    version: int
    role: str | None
    tags: Sequence[str] | None
    home: str | None
    rules: str | None
    played: str
    rules_version: int
    delivery: str
    detail: str
    comment: str
    decided_by: str | None
    decided_at: str | None
    home_kept: str = ""


class RoleService:
    """Gives robots roles. Recruiting reads them from the record; robots are told as of their rules."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: WorldDirectory,
        rules: RuleService,
        changes: WorldChanges,
        waiting: WaitingGoals,
    ) -> None:
        self._core = core
        self._worlds = worlds
        self._rules = rules
        self._changes = changes
        self._waiting = waiting

    def get(self, robot: str) -> RobotRole:
        """Its role; until one is given, that of its world file, as version 0."""
        spec, world = robot_and_world(self._worlds, robot)
        with self._core.database.read() as session:
            return self._role(session, world, spec)

    def put(
        self,
        robot: str,
        role: RoleSpec | None,
        *,
        home: str | None = None,
        actor: str,
        comment: str,
        expected_version: int | None,
    ) -> RobotRole:
        """Give the robot a role, or end the one that it plays; all of it or nothing.

        Its mission goes on. The home that a role has brought is given back with the role, unless the robot has another
        one since, or the former one is gone or another robot's: then its home stays, and the answer says why.

        :param role: None: it plays none any longer.
        :param home: where it goes to be charged in this role; None: the role brings no home.
        :raises Invalid: naming what the robot has no packet for, cannot reach, or is faulty in the role's rules.
        :raises Conflict: if a running mission needs the robot and its home would change.
        :raises Outdated: if the role has changed since `expected_version`.
        """
        _, world = robot_and_world(self._worlds, robot)
        with self._core.database.write() as session:
            lock_running_missions(session, world)  # lock order: missions before the world
            self._core.facts.lock(session, world)
            self._worlds.read(session)
            file = self._worlds[world]
            spec, _ = robot_and_world(self._worlds, robot)
            _refuse_unfit(file, spec, role, home)
            row = session.get(RoleRow, (world, robot), with_for_update=True)
            if row is None:
                named = spec.role
                role_name = "" if named is None else named.name
                row = RoleRow(world=world, robot=robot, version=0, role=role_name, comment="")
                session.add(row)
            if expected_version not in (None, row.version):
                detail = (
                    f"the role of {robot} is at version {row.version}, the request was made from version "
                    f"{expected_version}; read it again"
                )
                raise Outdated(detail, code="role-changed")
            before = row.role
            kept = self._move_home(session, file, spec, row, home, actor=actor, role=role)
            row.version += 1
            row.role = "" if role is None else role.name
            row.tags = None if role is None or role.tags is None else list(role.tags)
            row.rules = None if role is None else role.rules
            row.comment = comment
            row.decided_by = actor
            row.decided_at = utc_now()
            rules_version = self._rules.play(session, world, spec, role)
            told = {"subject": robot, "world": world, "actor": actor, "comment": comment}
            changed = (
                RoleCleared(**told, version=row.version, role=before, rules_version=rules_version)
                if role is None
                else RoleSet(
                    **told,
                    version=row.version,
                    role=role.name,
                    tags=role.tags,
                    home=home,
                    rules_version=rules_version,
                )
            )
            self._core.events.append(session, changed)
            session.flush()
            self._waiting.release(session, world)
            return replace(self._role(session, world, spec), home_kept=kept)

    def _move_home(
        self,
        session: Session,
        world: WorldFile,
        spec: RobotSpec,
        row: RoleRow,
        home: str | None,
        *,
        actor: str,
        role: RoleSpec | None,
    ) -> str:
        """Have the robot's home be the role's, or what it was before the last role that brought one.

        Returns why the robot keeps its present home though the role that brought it ends; empty if it does not.
        """
        brought = row.home
        former = row.former_home if brought == spec.home else spec.home
        wanted = former if home is None else home
        row.former_home = None if home is None else former
        row.home = home
        if home is None and brought not in (None, spec.home):
            return f"{spec.name} has been given {spec.home or 'no home'} since"
        if wanted == spec.home:
            return ""
        if home is None:
            try:
                _refuse_unfit(world, spec, None, wanted)
            except MactaError as error:
                return error.detail.removeprefix("home: ")
        reason = f"{spec.name} plays {role.name}" if role is not None else f"{spec.name} plays no role"
        try:
            self._changes.make(
                session,
                world.name,
                [ChangeRobot(name=spec.name, home=wanted)],
                actor=actor,
                source=f"operator {actor}",
                reason=reason,
            )
        except MactaError as error:
            raise type(error)(
                f"home: {error.detail.removeprefix('edits.0: ')}",
                code=error.code,
                choices=error.choices,
                thing=error.thing,
            ) from error
        return ""

    def _role(self, session: Session, world: str, spec: RobotSpec) -> RobotRole:
        row = session.get(RoleRow, (world, spec.name))
        role = role_in_force(row, spec)
        played = self._rules.played(session, world, spec)
        return RobotRole(
            robot=spec.name,
            world=world,
            version=0 if row is None else row.version,
            role=None if role is None else role.name,
            tags=None if role is None else role.tags,
            home=None if row is None else row.home,
            rules=None if role is None else role.rules,
            played=played.role,
            rules_version=played.version,
            delivery=played.delivery,
            detail=played.detail,
            comment="" if row is None else row.comment,
            decided_by=None if row is None else row.decided_by,
            decided_at=None if row is None else row.decided_at,
        )


def _refuse_unfit(world: WorldFile, spec: RobotSpec, role: RoleSpec | None, home: str | None) -> None:
    """Refuse tags that are none of the robot's packets, and a home that cannot be its own."""
    lacking = [tag for tag in (() if role is None else role.tags or ()) if tag not in spec.repertoire]
    if lacking:
        raise Invalid(
            f"tags: {spec.name} has no packet {', '.join(lacking)}; its packets: {', '.join(spec.repertoire)}",
            code="unfit-role",
            choices=spec.repertoire,
            thing=lacking[0],
        )
    if home is None or home == spec.home:
        return
    if spec.external:
        raise Conflict(
            f"home: software of its own speaks for {spec.name}, which says its home in its factsheet",
            code="home-of-external",
            thing=home,
        )
    owner = next((other.name for other in world.robots if other.home == home and other is not spec), None)
    if owner is not None:
        raise Conflict(f"home: {home} is the home of {owner}", code="home-in-use", thing=home)
    reach = [place.name for place in world.reach_of(spec.model_copy(update={"home": home}))]
    if home not in reach:
        raise Invalid(
            f"home: {spec.name} does not reach {home}", code="unfit-role", choices=tuple(reach), thing=home
        )
