"""The rule files of robots' deliberative levels (docs/rules.md): stored, and delivered until the robot answers."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.agents.tuning import ACKNOWLEDGED, PENDING, REFUSED, UNTOUCHED, robot_and_world
from app.core import Core
from app.domain.errors import Invalid, Outdated
from app.domain.events import RulesAcknowledged, RulesRefused, RulesSet
from app.store import RulesRow
from robots.errors import RuleError
from robots.repertoire import Repertoire
from robots.wire import Performative, RulesReport
from robots.world import WorldFile


@dataclass(frozen=True, slots=True, kw_only=True)
class RuledRobot:
    """A robot's rules.

    :param files: the text of each by the name of its agent or role, agents in order of rank.
    :param digests: of `files`, by name.
    :param followed: the digests of the files that the robot followed when it answered last.
    :param delivery: untouched, pending, acknowledged or refused by the robot.
    :param detail: why the robot refused.
    """

    robot: str
    world: str
    version: int
    files: Mapping[str, str]
    digests: Mapping[str, str]
    followed: Mapping[str, str]
    delivery: str
    detail: str
    comment: str
    decided_by: str | None
    decided_at: str | None


class RuleService:
    """Reads and sets robots' rules. The agent models deliver the pending ones and pass the robots' answers to it."""

    def __init__(self, core: Core, *, worlds: Mapping[str, WorldFile], repertoire: Repertoire) -> None:
        """:param repertoire: the packets of the robots' software."""
        self._database = core.database
        self._events = core.events
        self._worlds = worlds
        self._check_files = rule_check(repertoire)

    def get(self, robot: str) -> RuledRobot:
        """Its rules; until others are set, those of its world file, as version 0."""
        spec, world = robot_and_world(self._worlds, robot)
        with self._database.read() as session:
            return _ruled(session.get(RulesRow, (world, robot)) or _no_rules(world, robot, spec.rules))

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
            row = session.get(RulesRow, (world, robot), with_for_update=True)
            if row is None:
                row = _no_rules(world, robot, spec.rules)
                session.add(row)
            if expected_version not in (None, row.version):
                detail = (
                    f"the rules of {robot} are at version {row.version}, the request was made from version "
                    f"{expected_version}; read them again"
                )
                raise Outdated(detail, code="rules-changed")
            row.set(files, actor=actor, comment=comment)
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

    def pending(self, world: str) -> Sequence[RulesRow]:
        """The rules still to be delivered to robots of the world."""
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


def renew_rules(session: Session, world: str, robots: Collection[str] | None = None) -> None:
    """Mark the rules of a world for delivery again after these robots were restarted or replaced; None: all."""
    for row in session.scalars(select(RulesRow).where(RulesRow.world == world)):
        if robots is not None and row.robot not in robots:
            continue
        row.delivery = PENDING
        row.detail = ""
        row.followed = {}


def _no_rules(world: str, robot: str, files: Mapping[str, str]) -> RulesRow:
    """:param files: that the robot starts with."""
    return RulesRow(
        world=world,
        robot=robot,
        version=0,
        files=[list(one) for one in files.items()],
        followed={},
        delivery=UNTOUCHED,
        detail="",
        comment="",
    )


def _ruled(row: RulesRow) -> RuledRobot:
    from robots.deliberative.reader import digest_of

    files = dict(row.files)
    return RuledRobot(
        robot=row.robot,
        world=row.world,
        version=row.version,
        files=files,
        digests={name: digest_of(text) for name, text in files.items()},
        followed=row.followed,
        delivery=row.delivery,
        detail=row.detail,
        comment=row.comment,
        decided_by=row.decided_by,
        decided_at=row.decided_at,
    )
