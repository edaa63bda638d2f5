"""The tables. JSON columns hold the wire and API bodies as they were; times ending in `_s` are the world's clock."""

from typing import Any

from sqlalchemy import JSON, ForeignKey, Index, Integer, String
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

from app.domain.clock import SYSTEM_CLOCK, iso_utc

ID = String(120)


def utc_now() -> str:
    """The default of columns that hold an instant."""
    return iso_utc(SYSTEM_CLOCK.epoch_s())


class Base(DeclarativeBase):
    type_annotation_map = {dict[str, Any]: JSON, list[Any]: JSON}  # noqa: RUF012


class WorldRow(Base):
    """A world; `version` counts the changes of its facts, `releases` how often something in it became free; `run` names
    what of the world the facts tell of: as it was built once, and resumed since. None: it is not to go on.
    """

    __tablename__ = "worlds"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    title: Mapped[str]
    layout: Mapped[dict[str, Any]]
    version: Mapped[int] = mapped_column(default=1)
    releases: Mapped[int] = mapped_column(default=0)
    run: Mapped[str | None] = mapped_column(String(64))


class FactRow(Base):
    """A fact that holds, in the planner's form, with its source and the world's time it was learned at.

    `instead_of`: what was believed before and contradicted by it, newest first, each with source and time.
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


class UnknownRow(Base):
    """An object or robot of which no place is believed: what was believed last (and `instead_of` what), by whom, who
    said otherwise when.
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
    """A robot that an operator declared lost; one that was `silent` counts again once it is heard."""

    __tablename__ = "lost_robots"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    robot: Mapped[str] = mapped_column(String(64), primary_key=True)
    silent: Mapped[bool]
    since_s: Mapped[float]
    declared_by: Mapped[str]
    comment: Mapped[str]
    declared_at: Mapped[str] = mapped_column(default=utc_now)


class GoalRow(Base):
    """A goal and what came of it.

    `releases_seen` are the world's releases it was last planned after; `limits` what was asked of the planning,
    `planning` how far that is, while it runs, and `stop_requested` that its best plan so far is to be taken;
    `alternatives` how the search for other plans than the proposed one stands; `waits_for` what it waits for, of a goal
    that does and may be planned once that is free.
    """

    __tablename__ = "goals"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), index=True)
    text: Mapped[str]
    goal: Mapped[list[Any]]
    priority: Mapped[int]
    deadline_s: Mapped[float | None]
    deadline_at_s: Mapped[float | None]
    auto_approve: Mapped[bool]
    recovery: Mapped[str] = mapped_column(default="never")
    state: Mapped[str] = mapped_column(index=True)
    reason: Mapped[str] = mapped_column(default="")
    outcome: Mapped[str | None]
    attempts: Mapped[int] = mapped_column(default=0)
    releases_seen: Mapped[int] = mapped_column(default=0)
    limits: Mapped[dict[str, Any]] = mapped_column(default=dict)
    planning: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    stop_requested: Mapped[bool] = mapped_column(default=False)
    alternatives: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    waits_for: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    plan_id: Mapped[str | None]
    mission_id: Mapped[str | None]
    created_by: Mapped[str]
    created_at: Mapped[str] = mapped_column(default=utc_now)
    updated_at: Mapped[str] = mapped_column(default=utc_now, onupdate=utc_now)


class PlanRow(Base):
    """A plan-net as proposed: `body` is the API's, `duration_factors` what its durations were scaled by.

    `label` and `comparison` say how it stands among the goal's alternatives; `explanation` is kept once asked for.
    """

    __tablename__ = "plans"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    goal_id: Mapped[str] = mapped_column(ForeignKey("goals.id"), index=True)
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
    """A mission. At `enquire_at_s` (world's clock) robots are asked; `asked_at`: when they last were (wall).

    `plan_id` is the plan it carries out now, `revision` counts its plans and `revised_at_s` is when it got this one, if
    it is not the first. `recovery` is the operator's policy, `recovery_step` where a recovery stands, `tries_left` how
    often it is still recovered, `attempts` what was tried so far and what came of it; `stopped_for` why its robots were
    told to stop, in words, if none of them had failed. `workflow` is the id of the one that carries it on.
    """

    __tablename__ = "missions"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    workflow: Mapped[str]
    goal_id: Mapped[str] = mapped_column(ForeignKey("goals.id"), index=True)
    plan_id: Mapped[str] = mapped_column(ForeignKey("plans.id"), unique=True)
    world: Mapped[str] = mapped_column(index=True)
    state: Mapped[str] = mapped_column(index=True)
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
    recovery: Mapped[str] = mapped_column(default="never")
    recovery_step: Mapped[str | None]
    tries_left: Mapped[int] = mapped_column(default=0)
    attempts: Mapped[list[Any]] = mapped_column(default=list)
    created_at: Mapped[str] = mapped_column(default=utc_now)


class ScriptRow(Base):
    """A behaviour script of one of a mission's plans and what is known of its execution.

    `packets`: each packet's state and times as reported; `cleared`: the actions whose end it is to know of;
    `given_at_s`: when it was made (world's clock). The others are explained by the script's life cycle.
    """

    __tablename__ = "scripts"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    mission_id: Mapped[str] = mapped_column(ForeignKey("missions.id"), index=True)
    plan_id: Mapped[str] = mapped_column(ForeignKey("plans.id"), index=True)
    robot: Mapped[str]
    body: Mapped[dict[str, Any]]
    delivery: Mapped[str] = mapped_column(index=True)
    control: Mapped[str | None]
    control_number: Mapped[int | None]
    orders: Mapped[int] = mapped_column(default=0)
    stopping: Mapped[bool] = mapped_column(default=False)
    state: Mapped[str | None]
    packets: Mapped[dict[str, Any]]
    detail: Mapped[str] = mapped_column(default="")
    category: Mapped[str | None]
    perceived: Mapped[list[Any]]
    question: Mapped[str | None]
    cleared: Mapped[list[Any]] = mapped_column(default=list)
    clearance: Mapped[str | None]
    abandoned: Mapped[bool] = mapped_column(default=False)
    heard_at_s: Mapped[float | None]
    given_at_s: Mapped[float | None]
    doubt: Mapped[str] = mapped_column(default="")


class DurationRow(Base):
    """What was learned of an action's durations: samples, mean and variance of actual to expected."""

    __tablename__ = "durations"
    world: Mapped[str] = mapped_column(ForeignKey("worlds.id"), primary_key=True)
    action: Mapped[str] = mapped_column(String(64), primary_key=True)
    team: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    samples: Mapped[int]
    mean: Mapped[float]
    variance: Mapped[float]


class TuningRow(Base):
    """What operators have overridden of a robot's packets, and how far it has come: `delivery` as of a script."""

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
        """Make it a new version that is to be delivered."""
        self.version += 1
        self.tuning = tuning
        self.delivery = "pending"
        self.detail = ""
        self.comment = comment
        self.decided_by = actor
        self.decided_at = utc_now()


class MessageRow(Base):
    """A robot's message that is recorded; its id keeps it from being taken twice."""

    __tablename__ = "messages"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    robot: Mapped[str]
    kind: Mapped[str]
    body: Mapped[dict[str, Any]]
    recorded_at: Mapped[str] = mapped_column(default=utc_now)


class ExecutorRow(Base):
    """A process that runs workflows from the queues it serves; `seen_at`: when it last said so (database's clock)."""

    __tablename__ = "executors"
    id: Mapped[str] = mapped_column(ID, primary_key=True)
    serves: Mapped[list[Any]]
    host: Mapped[str]
    pid: Mapped[int]
    started_at: Mapped[str]
    seen_at: Mapped[float]


class LeaseRow(Base):
    """Which executor holds the lease of a world: it delivers to its robots and records their reports."""

    __tablename__ = "leases"
    world: Mapped[str] = mapped_column(String(64), primary_key=True)
    holder: Mapped[str] = mapped_column(ID)


class EventRow(Base):
    """What happened, in order; the source of the event stream and the audit record."""

    __tablename__ = "events"
    seq: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=True)
    time: Mapped[str] = mapped_column(default=utc_now)
    type: Mapped[str]
    subject: Mapped[str]
    data: Mapped[dict[str, Any]]
    __table_args__ = (Index("ix_events_subject", "subject"),)
