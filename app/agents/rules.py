"""The rule files of robots' deliberative levels (docs/rules.md): stored, and delivered until the robot answers."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.agents.tuning import ACKNOWLEDGED, PENDING, REFUSED, UNTOUCHED, robot_and_world
from app.core import Core
from app.domain.errors import Invalid, Outdated
from app.domain.events import RulesAcknowledged, RulesRefused, RulesSet
from app.store import RoleRow, RulesRow
from app.store.known_empty import KnownEmpty
from app.store.roles import role_in_force
from robots.errors import RuleError
from robots.repertoire import Repertoire
from robots.wire import MAX_RULE_FILES, Performative, RulesReport
from robots.world import RobotSpec, RoleSpec, WorldFile
from robots.world.rule_files import shipped_rules

DUTY = "duty"
"""The shipped agent without rules of its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RuledRobot:
    """A robot's rules.

    :param files: the text of each by the name of its agent or role, agents in order of rank.
    :param role: that is sent with them; empty: none. :param role_files: the texts that it adds, by name.
    :param digests: of `files` and `role_files`, by name.
    :param followed: the digests of the files that the robot followed when it answered last.
    :param delivery: untouched, pending, acknowledged or refused by the robot.
    :param detail: why the robot refused.
    """

    robot: str
    world: str
    version: int
    files: Mapping[str, str]
    digests: Mapping[str, str]
    role: str
    role_files: Mapping[str, str]
    followed: Mapping[str, str]
    delivery: str
    detail: str
    comment: str
    decided_by: str | None
    decided_at: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """How a robot was told of its role.

    :param role: that it said to play.
    """

    role: str
    version: int
    delivery: str
    detail: str


class RuleService:
    """Reads and sets robots' rules. The agent models deliver the pending ones and pass the robots' answers to it."""

    def __init__(self, core: Core, *, worlds: Mapping[str, WorldFile], repertoire: Repertoire) -> None:
        """:param repertoire: the packets of the robots' software."""
        self._database = core.database
        self._none_pending = KnownEmpty(core.database, RulesRow)
        self._events = core.events
        self._worlds = worlds
        self._check_files = rule_check(repertoire)

    def get(self, robot: str) -> RuledRobot:
        """Its rules; until others are set, those of its world file, as version 0."""
        spec, world = robot_and_world(self._worlds, robot)
        with self._database.read() as session:
            return _ruled(session.get(RulesRow, (world, robot)) or _no_rules(world, spec))

    def put(
        self, robot: str, files: Mapping[str, str], *, actor: str, comment: str, expected_version: int | None
    ) -> RuledRobot:
        """Replace the robot's rule files; it follows them once it has agreed.

        :raises Invalid: naming file, line and column of each fault.
        :raises Outdated: if the rules have changed since `expected_version`.
        """
        spec, world = robot_and_world(self._worlds, robot)
        self._check(files)
        with self._database.write() as session:
            row = self._locked(session, world, spec)
            if expected_version not in (None, row.version):
                detail = (
                    f"the rules of {robot} are at version {row.version}, the request was made from version "
                    f"{expected_version}; read them again"
                )
                raise Outdated(detail, code="rules-changed")
            role = role_in_force(session.get(RoleRow, (world, robot)), spec)
            added = {} if role is None else self._added(files, role)
            row.set(files, actor=actor, comment=comment)
            row.role_files = [list(one) for one in added.items()]
            ruled = _ruled(row)
            self._events.append(
                session,
                RulesSet(
                    subject=robot,
                    world=world,
                    actor=actor,
                    comment=comment,
                    version=row.version,
                    digests=ruled.digests,
                ),
            )
            return ruled

    def play(self, session: Session, world: str, spec: RobotSpec, role: RoleSpec | None) -> int:
        """Have the robot told its role within a transaction; the version of its rules from now on.

        :param role: None: it plays none any longer.
        :raises Invalid: naming file, line and column of each fault of the role's rules.
        """
        row = self._locked(session, world, spec)
        added = {} if role is None else self._added(dict(row.files), role)
        row.play("" if role is None else role.name, added)
        return row.version

    def played(self, session: Session, world: str, spec: RobotSpec) -> Played:
        """How the robot was told of its role."""
        row = session.get(RulesRow, (world, spec.name)) or _no_rules(world, spec)
        return Played(role=row.played, version=row.version, delivery=row.delivery, detail=row.detail)

    def pending(self, world: str) -> Sequence[RulesRow]:
        """The rules still to be delivered to robots of the world."""
        return self._none_pending.read(world, lambda: self._pending(world))

    def _pending(self, world: str) -> Sequence[RulesRow]:
        query = select(RulesRow).where(RulesRow.world == world, RulesRow.delivery == PENDING)
        with self._database.read() as session:
            return session.scalars(query.order_by(RulesRow.robot)).all()

    def record_answer(self, world: str, robot: str, performative: Performative, report: RulesReport) -> None:
        """Record that the robot follows its rules, or has refused them."""
        with self._database.write() as session:
            row = session.get(RulesRow, (world, robot), with_for_update=True)
            if row is None or (row.version, row.delivery) != (report.version, PENDING):
                return
            agreed = performative is Performative.AGREE
            row.delivery = ACKNOWLEDGED if agreed else REFUSED
            row.detail = report.reason
            row.followed = report.digests
            row.played = report.role
            answered = RulesAcknowledged if agreed else RulesRefused
            self._events.append(
                session,
                answered(
                    subject=robot,
                    world=world,
                    version=report.version,
                    reason=report.reason,
                    followed=report.digests,
                ),
            )

    def _locked(self, session: Session, world: str, spec: RobotSpec) -> RulesRow:
        self._database.lock(session, f"rules {spec.name}")  # there may be no row to lock yet
        row = session.get(RulesRow, (world, spec.name), with_for_update=True)
        if row is None:
            row = _no_rules(world, spec)
            session.add(row)
        return row

    def _added(self, files: Mapping[str, str], role: RoleSpec) -> Mapping[str, str]:
        """The files that the role adds to these; checked with them."""
        try:
            added = files_of_role(files, role)
        except RuleError as error:
            raise Invalid(str(error), code="unfit-rules") from error
        together = {**files, **added}
        if len(together) > MAX_RULE_FILES:
            detail = f"{len(together)} rule files with those of {role.name}; at most {MAX_RULE_FILES}"
            raise Invalid(detail, code="unfit-rules")
        self._check(together)
        return added

    def _check(self, files: Mapping[str, str]) -> None:
        try:
            self._check_files(files)
        except RuleError as error:
            raise Invalid(str(error), code="unfit-rules") from error


def rule_check(repertoire: Repertoire) -> Callable[[Mapping[str, str]], None]:
    """Checks rule files by name; raises a `RuleError` that names file, line and column of each fault."""

    def check(files: Mapping[str, str]) -> None:
        from robots.deliberative.rule_set import check_rule_set  # a parser, which few services need

        check_rule_set(files, repertoire)

    return check


def files_of_role(files: Mapping[str, str], role: RoleSpec) -> Mapping[str, str]:
    """The files that a role adds to a robot's own: its rules, stated or shipped, and an agent if there is none.

    :raises RuleError: if the role's rules are those of an agent.
    """
    from robots.deliberative.rule_set import read_rule_set

    text = role.rules
    if text is None and role.name not in files and (path := shipped_rules().get(role.name)) is not None:
        text = path.read_text(encoding="utf-8")
    added = {} if text is None else {role.name: text}
    together = {**files, **added}
    read = read_rule_set(together)
    playing = next((file for file in read if file.name == role.name), None)
    if playing is not None and not playing.is_role:
        raise RuleError(
            f"{role.name}:1:1: these are the rules of an agent; a role's begin with ROLE {role.name};"
        )
    if read and all(file.is_role for file in read):
        added[DUTY] = shipped_rules()[DUTY].read_text(encoding="utf-8")
    return added


def renew_rules(session: Session, world: str, robots: Collection[str] | None = None) -> None:
    """Mark the rules of a world for delivery again after these robots were restarted or replaced; None: all."""
    for row in session.scalars(select(RulesRow).where(RulesRow.world == world)):
        if robots is not None and row.robot not in robots:
            continue
        row.delivery = PENDING
        row.detail = ""
        row.followed = {}
        row.played = ""


def _no_rules(world: str, spec: RobotSpec) -> RulesRow:
    """What the robot starts with."""
    role = spec.role
    added = {} if role is None or role.rules is None else {role.name: role.rules}
    return RulesRow(
        world=world,
        robot=spec.name,
        version=0,
        files=[list(one) for one in spec.rules.items()],
        role="" if role is None else role.name,
        role_files=[list(one) for one in added.items()],
        followed={},
        played="",
        delivery=UNTOUCHED,
        detail="",
        comment="",
    )


def _ruled(row: RulesRow) -> RuledRobot:
    from robots.deliberative.reader import digest_of

    files = dict(row.files)
    added = dict(row.role_files)
    return RuledRobot(
        robot=row.robot,
        world=row.world,
        version=row.version,
        files=files,
        role=row.role,
        role_files=added,
        digests={name: digest_of(text) for name, text in {**files, **added}.items()},
        followed=row.followed,
        delivery=row.delivery,
        detail=row.detail,
        comment=row.comment,
        decided_by=row.decided_by,
        decided_at=row.decided_at,
    )
