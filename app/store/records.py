"""Queries of goals, missions and lost robots that several services share."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from operator import attrgetter, itemgetter
from typing import Any, TypeVar, cast

from sqlalchemy import Row as SelectedRow
from sqlalchemy import Select, bindparam, inspect, select, tuple_
from sqlalchemy.orm import Session
from sqlalchemy.orm.interfaces import ORMOption

from app.domain.errors import Invalid, UnknownWorld, unrecorded
from app.domain.lifecycles.mission import OPEN
from app.domain.lifecycles.script import DELIVERABLE, TERMINAL_SCRIPTS
from app.store.tables import (
    AddedWorldRow,
    DialogueRow,
    GoalRow,
    LostRobotRow,
    MissionRow,
    OutOfServiceRow,
    PlanRow,
    ResultRow,
    ScriptRow,
    UnaskedRobotRow,
    WorldRow,
)
from app.store.world_summary import forget_summary, summary_of

Row = TypeVar("Row", GoalRow, PlanRow, MissionRow, DialogueRow)
Shown = TypeVar("Shown", GoalRow, PlanRow, MissionRow, ScriptRow, ResultRow, DialogueRow)

UNENDED_SCRIPT = (
    ScriptRow.delivery.in_(DELIVERABLE),
    ScriptRow.state.is_(None) | ScriptRow.state.not_in(TERMINAL_SCRIPTS),
)
"""Conditions on scripts: given to a robot, which has not reported their end."""


_LOCKED_WORLDS = "locked worlds"
"""Key of `Session.info`: the rows of the worlds that the transaction has locked, by their names."""
# Made once: making a select() takes as long as executing it.
_LOCKING_WORLD = (
    select(WorldRow)
    .where(WorldRow.id == bindparam("world"))
    .with_for_update()
    .execution_options(populate_existing=True)
)
_LOCKING_GOAL = (
    select(GoalRow)
    .where(
        GoalRow.id
        == select(MissionRow.goal_id).where(MissionRow.id == bindparam("mission")).scalar_subquery()
    )
    .with_for_update()
    .execution_options(populate_existing=True)
)


def lock_world(session: Session, world: str) -> WorldRow:
    """The world's row, locked until the end of the transaction."""
    locked: dict[str, WorldRow] = session.info.setdefault(_LOCKED_WORLDS, {})
    if world not in locked:
        forget_summary(session, world)
        locked[world] = session.scalars(_LOCKING_WORLD, {"world": world}).one()
    return locked[world]


def refuse_removed(session: Session, world: str) -> None:
    """Hold the world against removal until the end of the transaction.

    :raises UnknownWorld: if it was removed meanwhile.
    """
    query = select(AddedWorldRow.removed_at).where(AddedWorldRow.world == world)
    if session.scalar(query.with_for_update(read=True)) is not None:
        raise UnknownWorld(world)


def joint_goal_of(session: Session, goal: GoalRow) -> GoalRow | None:
    """The goal that the service stated to carry this one out together with others; None if there is none."""
    return None if goal.joint_goal is None else session.get(GoalRow, goal.joint_goal)


def lock_goal(session: Session, goal_id: str) -> GoalRow:
    """The goal's row, locked.

    :raises NotFound: if there is none.
    """
    row = session.get(GoalRow, goal_id, with_for_update=True)
    if row is None:
        raise unrecorded("goal", goal_id)
    return row


def lock_goals(session: Session, goal_ids: Iterable[str]) -> Mapping[str, GoalRow]:
    """The rows of these goals, by id, locked in the order of the ids; those that are not recorded are left out."""
    query = select(GoalRow).where(GoalRow.id.in_(set(goal_ids))).order_by(GoalRow.id).with_for_update()
    return {goal.id: goal for goal in session.scalars(query.execution_options(populate_existing=True))}


def lock_mission(session: Session, mission_id: str) -> MissionRow:
    """The mission's row, locked; its goal's row is locked before it, in the order that all transactions keep."""
    session.scalars(_LOCKING_GOAL, {"mission": mission_id}).one()
    return session.get_one(MissionRow, mission_id, with_for_update=True)


def lock_running_missions(session: Session, world: str) -> Sequence[MissionRow]:
    """The missions of a world that have not ended, locked one after the other in the order of their ids."""
    query = select(MissionRow).where(MissionRow.world == world, MissionRow.state.in_(OPEN))
    return session.scalars(query.order_by(MissionRow.id).with_for_update()).all()


def lost_robots(session: Session, world: str) -> Sequence[LostRobotRow]:
    """The robots of a world that were declared lost, in alphabetical order."""
    if not summary_of(session, world).has_lost:
        return ()
    query = select(LostRobotRow).where(LostRobotRow.world == world).order_by(LostRobotRow.robot)
    return session.scalars(query).all()


def lost_robot_reasons(session: Session, world: str) -> Mapping[str, str]:
    """The lost robots of a world, each with the reason why it is not recruited, in words."""
    return {row.robot: f"which {row.declared_by} declared lost" for row in lost_robots(session, world)}


def robots_out_of_service(session: Session, world: str) -> Sequence[OutOfServiceRow]:
    """The robots of a world that were taken out of service, in alphabetical order."""
    if not summary_of(session, world).has_out_of_service:
        return ()
    query = select(OutOfServiceRow).where(OutOfServiceRow.world == world).order_by(OutOfServiceRow.robot)
    return session.scalars(query).all()


def unasked_robots(session: Session, world: str) -> Sequence[UnaskedRobotRow]:
    """The robots of a world that do not understand status queries, in alphabetical order."""
    if not summary_of(session, world).has_unasked:
        return ()
    query = select(UnaskedRobotRow).where(UnaskedRobotRow.world == world).order_by(UnaskedRobotRow.robot)
    return session.scalars(query).all()


def withdrawn_robot_reasons(session: Session, world: str) -> Mapping[str, str]:
    """The robots of a world that operators do not want recruited, lost or out of service, each with why, in words."""
    resting = {
        row.robot: f"which {row.taken_by} took out of service: {row.reason}"
        for row in robots_out_of_service(session, world)
    }
    return {**resting, **lost_robot_reasons(session, world)}


def read_only(table: type[Shown]) -> Select[Shown]:
    """A query of the table's columns, for `all_of`; those that lists leave out are not read."""
    return select(*(one for one in inspect(table).columns if one.info.get("listed", True)))


def all_of(session: Session, query: Select[Shown]) -> Sequence[Shown]:
    """The rows of a `read_only` query: with its columns as attributes, and cheaper than objects of the session."""
    return cast(Sequence[Shown], session.connection().execute(query).all())


def values_of(row: object, names: tuple[str, ...]) -> tuple[Any, ...]:
    """These attributes of a table's row; of the rows of `all_of` twenty times as fast as one after the other."""
    if isinstance(row, SelectedRow):
        return _picker(row._fields, names)(row)
    return attrgetter(*names)(row)


@cache
def _picker(fields: tuple[str, ...], names: tuple[str, ...]) -> Callable[[Any], tuple[Any, ...]]:
    return itemgetter(*(fields.index(name) for name in names))


def page(
    session: Session,
    table: type[Row],
    *,
    limit: int,
    after: str | None,
    options: Sequence[ORMOption] = (),
    **equal: str | None,
) -> tuple[Sequence[Row], str | None]:
    """A page of rows, newest first: `limit` rows after the continuation token, and the next page's token or None.

    :param options: of the query, such as columns to leave out.
    :param equal: columns and the values they must have; None leaves a column open.
    :raises Invalid: if the token is malformed.
    """
    query = select(table).options(*options) if options else read_only(table)
    query = query.where(*(getattr(table, name) == v for name, v in equal.items() if v is not None))
    if after is not None:
        created_at, _, row_id = after.partition("~")
        if not row_id:
            raise Invalid(f"no such continuation token: {after!r}", code="unknown-token")
        # As one comparison: an index leads to its first row.
        query = query.where(tuple_(table.created_at, table.id) < (created_at, row_id))
    query = query.order_by(table.created_at.desc(), table.id.desc()).limit(limit + 1)
    rows = session.scalars(query).all() if options else all_of(session, query)
    if len(rows) <= limit:
        return rows, None
    last = rows[limit - 1]
    return rows[:limit], f"{last.created_at}~{last.id}"
