"""The tables. JSON columns hold bodies of the wire and the API; times ending in `_s` are the world's clock."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

from pydantic_core import from_json
from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    ColumnElement,
    Dialect,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    String,
    Text,
    TypeDecorator,
    cast,
    column,
    false,
    true,
    type_coerce,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

from app.domain.clock import SYSTEM_CLOCK, iso_utc

ID = String(120)


def utc_now() -> str:
    """The default of columns that hold an instant."""
    return iso_utc(SYSTEM_CLOCK.epoch_s())


class WrittenOnce(TypeDecorator[dict[str, Any]]):
    """JSON that never changes: read again, it is shared and not parsed again. Readers leave it as it is."""

    impl = JSON
    cache_ok = True
    KEPT = 512
    """The most values that are remembered."""

    def column_expression(self, column: ColumnElement[Any]) -> ColumnElement[Any]:
        return type_coerce(cast(column, Text), self)

    def result_processor(self, dialect: Dialect, coltype: object) -> Callable[[Any], Any]:
        return _parsed_once


@lru_cache(WrittenOnce.KEPT)
def _parsed_once(text: str | None) -> Any:
    return None if text is None else from_json(text)


class Base(DeclarativeBase):
    type_annotation_map = {dict[str, Any]: JSON, list[Any]: JSON}  # noqa: RUF012


UNLISTED = {"listed": False}
"""`info` of columns that lists leave out: nobody shows them, and they are JSON to be parsed."""
ABANDONED = column("abandoned", Boolean) == true()


def newest_first(table: str, *filters: Sequence[str]) -> tuple[Index, ...]:
    """Indices for pages of rows, newest first, one for each combination of columns that a page can be filtered by."""
    return tuple(
        Index("_".join(("ix", table, *columns, "newest")), *columns, "created_at", "id")
        for columns in filters
    )


class WorldRow(Base):
    """A world.

    `version` counts the changes of its facts, `releases` how often something in it became free; `run` is the id of the
    run that the facts belong to, None if it cannot be continued. `numbers_version` counts the changes of its numeric
    facts. `announced_run` is the run that the service announces or has announced itself, `announced_from` the epoch
    seconds at which that run's time was 0. `waiting_workflow` is the workflow that is to plan the world's waiting
    goals, until it begins. `layout`, long in large worlds, is read once it is asked for.
    """

    __tablename__ = "worlds"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    title: Mapped[str]
    layout: Mapped[dict[str, Any]] = mapped_column(deferred=True)
    version: Mapped[int] = mapped_column(default=1)
    releases: Mapped[int] = mapped_column(default=0)
    waiting_workflow: Mapped[str | None] = mapped_column(String(64))
    run: Mapped[str | None] = mapped_column(String(64))
    numbers_version: Mapped[int] = mapped_column(default=0, server_default="0")
    announced_run: Mapped[str | None] = mapped_column(String(64))
    announced_from: Mapped[float | None]


class FactRow(Base):
    """A believed fact, in the planner's form, with its source and time (world's clock).

    `instead_of`: earlier beliefs that it contradicts, newest first, each with source and time.
    """

    __tablename__ = "facts"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    atom: Mapped[str] = mapped_column(String(400), primary_key=True)
    predicate: Mapped[str]
    args: Mapped[list[Any]]
    source: Mapped[str]
    at_s: Mapped[float]
    instead_of: Mapped[list[Any]] = mapped_column(default=list)
    recorded_at: Mapped[str] = mapped_column(default=utc_now)


class NumberRow(Base):
    """A numeric fact with its source and time (world's clock); `term` is `battery(rover_1)`, `version` the world's
    `numbers_version` with which it came to this value.
    """

    __tablename__ = "numbers"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    term: Mapped[str] = mapped_column(String(400), primary_key=True)
    quantity: Mapped[str]
    args: Mapped[list[Any]]
    value: Mapped[float]
    source: Mapped[str]
    at_s: Mapped[float]
    version: Mapped[int]
    recorded_at: Mapped[str] = mapped_column(default=utc_now)


class UnknownRow(Base):
    """An object or robot without a believed place.

    `believed` is the last belief, with its own `instead_of`; `believed_by` and `believed_at_s` are its source and time,
    `source` and `since_s` those of its contradiction.
    """

    __tablename__ = "unknowns"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    name: Mapped[str] = mapped_column(String(64), primary_key=True)
    believed: Mapped[dict[str, Any]]
    believed_by: Mapped[str]
    believed_at_s: Mapped[float]
    source: Mapped[str]
    since_s: Mapped[float]


class LostRobotRow(Base):
    """A robot that an operator declared lost; one that was `silent` is restored once it is heard again."""

    __tablename__ = "lost_robots"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    silent: Mapped[bool]
    since_s: Mapped[float]
    declared_by: Mapped[str]
    comment: Mapped[str]
    declared_at: Mapped[str] = mapped_column(default=utc_now)


class UnaskedRobotRow(Base):
    """A robot that does not understand status queries, so that it is not asked; until it announces itself anew."""

    __tablename__ = "unasked_robots"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    reason: Mapped[str]
    noted_at: Mapped[str] = mapped_column(default=utc_now)


class SignatureCounterRow(Base):
    """The counters of a robot's signed messages on one topic: the two greatest accepted, the last one's signature.

    Decimals, as text: they may exceed an integer of the database. `key_id`: which key they are of.
    """

    __tablename__ = "signature_counters"
    topic: Mapped[str] = mapped_column(String(300), primary_key=True)
    world: Mapped[str] = mapped_column(String(64), index=True)
    key_id: Mapped[str] = mapped_column(String(64))
    before: Mapped[str] = mapped_column(String(32))
    last: Mapped[str] = mapped_column(String(32))
    signature: Mapped[str] = mapped_column(String(64))


class OutOfServiceRow(Base):
    """A robot that an operator has taken out of service: it ends what it has begun and is not recruited."""

    __tablename__ = "robots_out_of_service"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    since_s: Mapped[float]
    taken_by: Mapped[str]
    reason: Mapped[str]
    taken_at: Mapped[str] = mapped_column(default=utc_now)


class HoldRow(Base):
    """Places of a world that are kept empty and facts that are kept true; see `app.domain.lifecycles.hold`.

    `places` as they were stated, `kept` the berths that they mean; `until` as it was stated; `ends_at` (seconds since
    1970, wall clock) or `ends_at_s` (world's clock): when its time comes, if a time ends it. `goal_id`: the goal that
    stated it, which may have been deleted since; `text`: its sentence. `ending`: why it ended, `ended_by`: the operator
    who ended it.

    `facts`: what is kept true, `achieved`: those of them that have been true, `lost`: those that have ceased to be
    (`app.domain.kept_record`), `losses`: the number of the newest loss.
    """

    __tablename__ = "holds"
    __table_args__ = (Index("ix_holds_world_state", "world", "state"),)
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"))
    places: Mapped[list[Any]]
    kept: Mapped[list[Any]]
    facts: Mapped[list[Any]] = mapped_column(default=list)
    achieved: Mapped[list[Any]] = mapped_column(default=list)
    lost: Mapped[list[Any]] = mapped_column(default=list)
    losses: Mapped[int] = mapped_column(default=0)
    until: Mapped[dict[str, Any]]
    ends_at: Mapped[float | None]
    ends_at_s: Mapped[float | None]
    state: Mapped[str]
    goal_id: Mapped[str] = mapped_column(ID)
    text: Mapped[str]
    created_by: Mapped[str]
    created_at: Mapped[str] = mapped_column(default=utc_now)
    ending: Mapped[str | None]
    ended_by: Mapped[str | None]
    ended_at: Mapped[str | None]
    comment: Mapped[str] = mapped_column(default="")


class FactsheetRow(Base):
    """The newest factsheet of a robot, of one that the world has or of one that would come.

    `run`: of the world, that it came in; `message_id` of the message that brought it, `is_told`: that was answered.
    `edition`: that it has made, if any. For the others see `app.domain.lifecycles.factsheet`.
    """

    __tablename__ = "factsheets"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    run: Mapped[str] = mapped_column(String(64))
    message_id: Mapped[str] = mapped_column(ID)
    number: Mapped[int] = mapped_column(BigInteger)
    sheet: Mapped[dict[str, Any]] = mapped_column(WrittenOnce)
    state: Mapped[str]
    reason: Mapped[str] = mapped_column(default="")
    edition: Mapped[int | None]
    decided_by: Mapped[str | None]
    is_told: Mapped[bool] = mapped_column(default=False)
    at_s: Mapped[float]
    came_at: Mapped[str] = mapped_column(default=utc_now)


class EditionRow(Base):
    """An edition of a world: what changes have made of its file, by edits or by another file.

    `document` is the whole world as JSON; `file_digest` of the file that it goes back to. `edits` as they were made,
    none if the world file was replaced; `undo`: the edits that take them back; `undoes`, `undone_by`: the editions of
    which this is one's reversal, and which is this one's. `delivery`: pending, taken_up or refused by the world.
    """

    __tablename__ = "world_editions"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    edition: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    document: Mapped[dict[str, Any]]
    file_digest: Mapped[str] = mapped_column(String(64))
    edits: Mapped[list[Any]]
    undo: Mapped[list[Any]]
    actor: Mapped[str]
    reason: Mapped[str]
    at_s: Mapped[float]
    made_at: Mapped[str] = mapped_column(default=utc_now)
    undoes: Mapped[int | None]
    undone_by: Mapped[int | None]
    delivery: Mapped[str] = mapped_column(default="pending")
    detail: Mapped[str] = mapped_column(default="")


class AddedWorldRow(Base):
    """A world that was added while the service ran, and starts again with it.

    `document` is its file as JSON; `rate`: world seconds per wall-clock second, None: the service's. Of one that was
    removed, `removed_at` and who did it and why are kept until it is added again.
    """

    __tablename__ = "added_worlds"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    document: Mapped[dict[str, Any]]
    rate: Mapped[float | None]
    added_by: Mapped[str]
    reason: Mapped[str]
    added_at: Mapped[str] = mapped_column(default=utc_now)
    removed_at: Mapped[str | None]
    removed_by: Mapped[str | None]
    removal_reason: Mapped[str | None]


class GoalRow(Base):
    """A goal.

    `releases_seen`: the world's `releases` at its last planning; `limits`: the requested planning options; `planning`:
    the progress while planning runs; `planned_by`: the workflow that plans it now; `stop_requested`: planning is to end
    with the best plan so far; `alternatives`: the state of the search for alternatives; `waits_for`: the blockers that
    a waiting goal waits for; `terms`: its constraints, and how its sentence was read; `allocation`: how its robots are
    chosen; `tender`: the bids for it, see `app.domain.tender_document`; `joint_goal`: the goal whose mission carries it
    out, too, though that may have failed.
    """

    __tablename__ = "goals"
    __table_args__ = newest_first("goals", (), ("state",), ("world",), ("world", "state"))
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"))
    text: Mapped[str]
    goal: Mapped[list[Any]]
    priority: Mapped[int]
    deadline_s: Mapped[float | None]
    deadline_at_s: Mapped[float | None]
    auto_approve: Mapped[bool]
    recovery: Mapped[str] = mapped_column(default="never")
    state: Mapped[str]
    reason: Mapped[str] = mapped_column(default="")
    outcome: Mapped[str | None]
    attempts: Mapped[int] = mapped_column(default=0)
    releases_seen: Mapped[int] = mapped_column(default=0)
    limits: Mapped[dict[str, Any]] = mapped_column(default=dict, info=UNLISTED)
    planning: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    planned_by: Mapped[str | None] = mapped_column(info=UNLISTED)
    stop_requested: Mapped[bool] = mapped_column(default=False)
    alternatives: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    waits_for: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True), info=UNLISTED)
    terms: Mapped[dict[str, Any]] = mapped_column(default=dict)
    allocation: Mapped[str] = mapped_column(default="central", server_default="central")
    tender: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True), info=UNLISTED)
    joint_goal: Mapped[str | None] = mapped_column(ID)
    plan_id: Mapped[str | None]
    mission_id: Mapped[str | None]
    created_by: Mapped[str]
    created_at: Mapped[str] = mapped_column(default=utc_now)
    updated_at: Mapped[str] = mapped_column(default=utc_now, onupdate=utc_now)


class PlanRow(Base):
    """A plan-net as proposed: `body` is the API's, `duration_factors` are the factors on its durations.

    `label` and `comparison` compare it with the goal's alternatives; `explanation` is stored once requested.
    """

    __tablename__ = "plans"
    __table_args__ = newest_first("plans", (), ("state",), ("goal_id", "state"))
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    goal_id: Mapped[str] = mapped_column(ForeignKey("goals.id"))
    world: Mapped[str]
    state: Mapped[str]
    reason: Mapped[str] = mapped_column(default="")
    body: Mapped[dict[str, Any]]
    world_version: Mapped[int]
    duration_factors: Mapped[dict[str, Any]] = mapped_column(default=dict)
    label: Mapped[str] = mapped_column(default="")
    comparison: Mapped[str] = mapped_column(default="")
    explanation: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    comment: Mapped[str | None]
    decided_by: Mapped[str | None]
    decided_at: Mapped[str | None]
    created_at: Mapped[str] = mapped_column(default=utc_now)


class MissionRow(Base):
    """A mission. At `enquire_at_s` (world's clock) robots are asked; `asked_at`: when they last were (wall clock).

    `plan_id` is its current plan, `revision` counts its plans and `revised_at_s` is when it got the current one, if not
    the first. `recovery` is the recovery policy, `recovery_step` the current step, `tries_left` the number of tries
    left, `attempts` the recovery attempts with their outcomes; `stopped_for`: why its robots were stopped, in words, if
    none of them had failed; `replanning`, `joined_goals`: see `app.domain.lifecycles.recovery`; `better_plan`: what
    planning it again would save, see `app.missions.better_plans`. `contradictions` in its
    robots' reports: see `app.domain.contradictions`. `workflow` is the id of its current workflow, `results` the number
    of its results. `delegate`: robots in the field may put legs of their scripts to each other.
    """

    __tablename__ = "missions"
    __table_args__ = newest_first("missions", (), ("state",), ("world",), ("world", "state"))
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    workflow: Mapped[str]
    goal_id: Mapped[str] = mapped_column(ForeignKey("goals.id"), index=True)
    plan_id: Mapped[str] = mapped_column(ForeignKey("plans.id"), unique=True)
    world: Mapped[str]
    state: Mapped[str]
    reason: Mapped[str] = mapped_column(default="")
    failure: Mapped[str | None]
    resume_to: Mapped[str | None]
    estimate_s: Mapped[float]
    original_estimate_s: Mapped[float]
    margin_s: Mapped[float]
    started_at_s: Mapped[float | None]
    deadline_s: Mapped[float | None]
    ended_at_s: Mapped[float | None]
    enquire_at_s: Mapped[float | None]
    asked_at: Mapped[float | None]
    cancel_requested: Mapped[bool] = mapped_column(default=False)
    is_overdue: Mapped[bool] = mapped_column(default=False)
    revision: Mapped[int] = mapped_column(default=1)
    revised_at_s: Mapped[float | None]
    stopped_for: Mapped[str] = mapped_column(default="")
    replanning: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    joined_goals: Mapped[list[Any]] = mapped_column(default=list, server_default="[]")
    better_plan: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    recovery: Mapped[str] = mapped_column(default="never")
    recovery_step: Mapped[str | None]
    tries_left: Mapped[int] = mapped_column(default=0)
    attempts: Mapped[list[Any]] = mapped_column(default=list)
    contradictions: Mapped[list[Any]] = mapped_column(default=list, server_default="[]")
    results: Mapped[int] = mapped_column(default=0, server_default="0")
    delegate: Mapped[bool] = mapped_column(default=False, server_default=false())
    created_at: Mapped[str] = mapped_column(default=utc_now)


class ScriptRow(Base):
    """A behaviour script of one of a mission's plans and the record of its execution.

    `packets`: each packet's reported state and times; `cleared`: the actions whose end is reported to the robot by
    clearance; `given_at_s`: when it was made (world's clock). For the others see `app.domain.lifecycles.script`.
    """

    __tablename__ = "scripts"
    __table_args__ = (
        Index("ix_scripts_abandoned", "mission_id", sqlite_where=ABANDONED, postgresql_where=ABANDONED),
    )
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    mission_id: Mapped[str] = mapped_column(ForeignKey("missions.id"), index=True)
    plan_id: Mapped[str] = mapped_column(ForeignKey("plans.id"), index=True)
    robot: Mapped[str]
    body: Mapped[dict[str, Any]] = mapped_column(WrittenOnce)
    delivery: Mapped[str]
    control: Mapped[str | None]
    control_number: Mapped[int | None]
    orders: Mapped[int] = mapped_column(default=0)
    stopping: Mapped[bool] = mapped_column(default=False)
    state: Mapped[str | None]
    packets: Mapped[dict[str, Any]]
    detail: Mapped[str] = mapped_column(default="")
    category: Mapped[str | None]
    perceived: Mapped[list[Any]] = mapped_column(info=UNLISTED)
    question: Mapped[str | None]
    cleared: Mapped[list[Any]] = mapped_column(default=list)
    clearance: Mapped[str | None]
    abandoned: Mapped[bool] = mapped_column(default=False)
    heard_at_s: Mapped[float | None]
    given_at_s: Mapped[float | None]
    doubt: Mapped[str] = mapped_column(default="")


class ResultRow(Base):
    """What a packet of a mission has brought, `of` a place, sample or robot: the image of the camera `name`, with its
    `content`, or the `value` of the quantity `name`.
    """

    __tablename__ = "results"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    mission_id: Mapped[str] = mapped_column(ForeignKey("missions.id"), index=True)
    script_id: Mapped[str] = mapped_column(ForeignKey("scripts.id"), index=True)
    packet_id: Mapped[str]
    robot: Mapped[str]
    kind: Mapped[str]
    name: Mapped[str]
    of: Mapped[str]
    at_s: Mapped[float]
    media_type: Mapped[str | None]
    size_bytes: Mapped[int | None]
    content: Mapped[bytes | None] = mapped_column(LargeBinary, info=UNLISTED)
    value: Mapped[float | None]
    unit: Mapped[str] = mapped_column(default="")
    created_at: Mapped[str] = mapped_column(default=utc_now)


class DurationRow(Base):
    """The learned durations of an action: samples, mean and variance of the ratio of actual to expected."""

    __tablename__ = "durations"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    action: Mapped[str] = mapped_column(String(64), primary_key=True)
    team: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    samples: Mapped[int]
    mean: Mapped[float]
    variance: Mapped[float]


class TuningRow(Base):
    """Operators' overrides of the parameters of a robot's packets, and the state of their `delivery`."""

    __tablename__ = "tunings"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    version: Mapped[int]
    tuning: Mapped[dict[str, Any]] = mapped_column(default=dict)
    delivery: Mapped[str] = mapped_column(default="pending")
    detail: Mapped[str] = mapped_column(default="")
    comment: Mapped[str] = mapped_column(default="")
    decided_by: Mapped[str | None]
    decided_at: Mapped[str | None]

    def set(self, tuning: dict[str, Any], *, actor: str, comment: str) -> None:
        """Set the overrides as a new version, to be delivered."""
        self.version += 1
        self.tuning = tuning
        self.delivery = "pending"
        self.detail = ""
        self.comment = comment
        self.decided_by = actor
        self.decided_at = utc_now()


class RulesRow(Base):
    """The rule files of a robot's deliberative level, as pairs of name and text in order of rank, the state of their
    `delivery`, and the digests of the files that the robot said to follow.

    `role`: that is sent with them, empty if none; `role_files`: what it adds to the files; `played`: the role that the
    robot said to play.
    """

    __tablename__ = "rules"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    version: Mapped[int]
    files: Mapped[list[Any]] = mapped_column(default=list)
    followed: Mapped[dict[str, Any]] = mapped_column(default=dict)
    role: Mapped[str] = mapped_column(default="")
    role_files: Mapped[list[Any]] = mapped_column(default=list)
    played: Mapped[str] = mapped_column(default="")
    delivery: Mapped[str] = mapped_column(default="pending")
    detail: Mapped[str] = mapped_column(default="")
    comment: Mapped[str] = mapped_column(default="")
    decided_by: Mapped[str | None]
    decided_at: Mapped[str | None]

    def set(self, files: Mapping[str, str], *, actor: str, comment: str) -> None:
        """Set the files as a new version, to be delivered."""
        self.version += 1
        self.files = [list(one) for one in files.items()]
        self.delivery = "pending"
        self.detail = ""
        self.comment = comment
        self.decided_by = actor
        self.decided_at = utc_now()

    def play(self, role: str, files: Mapping[str, str]) -> None:
        """Send this role with the files as a new version, to be delivered.

        :param files: that the role adds.
        """
        self.version += 1
        self.role = role
        self.role_files = [list(one) for one in files.items()]
        self.delivery = "pending"
        self.detail = ""


class RoleRow(Base):
    """The role that operators have given a robot; an empty `role`: none, though the world's file may state one.

    `tags`: what it is recruited for, None: all that it can; `home`: that the role brings, None: it brings none;
    `former_home`: the robot's before; `rules`: the text of the role's rule file, if one was given.
    """

    __tablename__ = "roles"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    version: Mapped[int]
    role: Mapped[str]
    tags: Mapped[list[Any] | None] = mapped_column(JSON(none_as_null=True))
    home: Mapped[str | None]
    former_home: Mapped[str | None]
    rules: Mapped[str | None]
    comment: Mapped[str]
    decided_by: Mapped[str | None]
    decided_at: Mapped[str | None]


class EmbodimentRow(Base):
    """A move of a robot's mind into another body, by its fencing number, which counts up for each robot.

    `state`, `reason`: see `app.domain.lifecycles.embodiment`. `body`, `former`: see `app.missions.embodiment_record`.
    `mind`: the document that one program hands over to another, as far as it has come: `digest`, `count` and `texts`
    of its pieces; None: none has. `taken`: how many pieces the other program has; `asked_s`: since when it is asked to
    take them (world's clock). `edition`: of the world, which exchanges the bodies; None: none was made. `lease_s`: how
    long the robot may act without hearing of the service, None: without end; `lease_until_s`: the latest time that it
    was promised, `lease_told_s`: that it has confirmed, both by the world's clock.
    """

    __tablename__ = "embodiments"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    fence: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    state: Mapped[str]
    reason: Mapped[str] = mapped_column(default="")
    body: Mapped[dict[str, Any]]
    former: Mapped[dict[str, Any]]
    edition: Mapped[int | None]
    lease_s: Mapped[float | None]
    lease_until_s: Mapped[float | None]
    lease_told_s: Mapped[float | None]
    mind: Mapped[dict[str, Any] | None]
    taken: Mapped[int] = mapped_column(default=0)
    asked_s: Mapped[float | None]
    actor: Mapped[str]
    comment: Mapped[str] = mapped_column(default="")
    created_at: Mapped[str] = mapped_column(default=utc_now)
    ended_at: Mapped[str | None]


class ConversationRow(Base):
    """A conversation of the service with a robot, by an interaction protocol of FIPA.

    `is_ours`, `is_due`, `state`, `is_over`, `reason`: see `app.domain.lifecycles.conversation`. `opener`: the part of
    the service that its answers are passed to. `about`: the goal, plan or mission that it is about; empty: the robot.
    `speaker`: the person on whose behalf the service speaks. `said`: the messages, oldest first.
    """

    __tablename__ = "conversations"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    world: Mapped[str] = mapped_column(String(64))
    protocol: Mapped[str] = mapped_column(String(64))
    is_ours: Mapped[bool]
    state: Mapped[str]
    is_over: Mapped[bool] = mapped_column(default=False)
    is_due: Mapped[bool] = mapped_column(default=False)
    reason: Mapped[str] = mapped_column(default="")
    opener: Mapped[str] = mapped_column(default="")
    about: Mapped[str] = mapped_column(ID, default="")
    speaker: Mapped[str] = mapped_column(default="")
    said: Mapped[list[Any]] = mapped_column(default=list)
    reply_by_s: Mapped[float | None]
    opened_at: Mapped[str] = mapped_column(default=utc_now)
    __table_args__ = (
        Index("ix_conversations_open", "world", "is_over"),
        Index("ix_conversations_robot", "world", "robot", "opened_at"),
    )


class DialogueRow(Base):
    """What a person says to one robot: `state` and `reason` see `app.domain.lifecycles.dialogue`.

    `text`: what was said, with what was answered in its place. `asked`: the clarification that is awaited, empty
    without one. `packets`: the script that is shown or carried out. `lines`: who has said what, oldest first.
    `conversation`: with the robot, once there is one. `said_by`: the person.
    """

    __tablename__ = "dialogues"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    world: Mapped[str] = mapped_column(String(64))
    robot: Mapped[str] = mapped_column(String(64))
    state: Mapped[str]
    reason: Mapped[str] = mapped_column(default="")
    text: Mapped[str]
    asked: Mapped[dict[str, Any]] = mapped_column(default=dict)
    packets: Mapped[list[Any]] = mapped_column(default=list)
    lines: Mapped[list[Any]] = mapped_column(default=list)
    conversation: Mapped[str] = mapped_column(ID, default="")
    said_by: Mapped[str]
    idempotency_key: Mapped[str | None] = mapped_column(String(200), unique=True)
    created_at: Mapped[str] = mapped_column(default=utc_now)
    __table_args__ = (
        Index("ix_dialogues_newest", "robot", "created_at", "id"),
        Index("ix_dialogues_conversation", "conversation"),
    )


class MessageRow(Base):
    """A recorded message of a robot; its id prevents it from being recorded twice."""

    __tablename__ = "messages"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    robot: Mapped[str]
    kind: Mapped[str]
    body: Mapped[dict[str, Any]]
    recorded_at: Mapped[str] = mapped_column(default=utc_now, index=True)


class ExecutorRow(Base):
    """A process that runs workflows of the queues it serves; `seen_at`: its last heartbeat (database's clock).

    `planning`: what its planning processes did then; None if it has none. `packs`: the digests of its domain packs, by
    name; None of an earlier version.
    """

    __tablename__ = "executors"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    serves: Mapped[list[Any]]
    host: Mapped[str]
    pid: Mapped[int]
    started_at: Mapped[str]
    seen_at: Mapped[float]
    planning: Mapped[dict[str, Any] | None]
    packs: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))


class LeaseRow(Base):
    """Which executor holds the lease of a world: it delivers to its robots and records their reports."""

    __tablename__ = "leases"
    world: Mapped[str] = mapped_column(String(64), primary_key=True)
    holder: Mapped[str] = mapped_column(ID)


class EventRow(Base):
    """An event; the source of the event stream and the audit record."""

    __tablename__ = "events"
    seq: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=True)
    time: Mapped[str] = mapped_column(default=utc_now)
    type: Mapped[str]
    subject: Mapped[str]
    data: Mapped[dict[str, Any]]
    __table_args__ = (Index("ix_events_subject", "subject"),)
