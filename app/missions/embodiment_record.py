"""The record of moves of minds: the newest of a robot, and the end of those that have lost their minds."""

from collections.abc import Collection

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from app.domain.events import EmbodimentChanged
from app.domain.lifecycles.embodiment import OPEN, EmbodimentState, end_anew
from app.store import EmbodimentRow
from app.store.event_log import EventLog
from app.store.tables import utc_now
from robots.world import WorldFile


def newest_move(
    session: Session, world: str, robot: str, *, before: int | None = None
) -> EmbodimentRow | None:
    """:param before: only of those with a lower fencing number; None: of all."""
    query = select(EmbodimentRow).where(EmbodimentRow.world == world, EmbodimentRow.robot == robot)
    if before is not None:
        query = query.where(EmbodimentRow.fence < before)
    return session.scalar(query.order_by(EmbodimentRow.fence.desc()).limit(1))


def has_body(world: WorldFile, row: EmbodimentRow) -> bool:
    """Whether the robot has, in this edition, the body that the move leads to."""
    return world.robot(row.robot).body.model_dump(mode="json") == row.body


def tell_of_move(session: Session, events: EventLog, row: EmbodimentRow) -> None:
    changed = EmbodimentChanged(
        subject=row.robot,
        world=row.world,
        fence=row.fence,
        state=EmbodimentState(row.state),
        body=row.body["kind"],
        former=row.former["kind"],
        edition=row.edition,
        actor=row.actor,
        reason=row.reason,
    )
    events.append(session, changed)


def begin_anew(session: Session, events: EventLog, world: WorldFile, reason: str) -> None:
    """End the moves under way: the world's run has ended, and robots know of no lease."""
    _end_moves(session, events, world, {one.name for one in world.robots}, reason)
    session.execute(
        update(EmbodimentRow)
        .where(EmbodimentRow.world == world.name)
        .values(lease_until_s=None, lease_told_s=None)
    )


def end_for_replaced(session: Session, events: EventLog, world: WorldFile, robots: Collection[str]) -> None:
    """End moves and leases of robots for which other software speaks from now on."""
    _end_moves(session, events, world, robots, "other software speaks for the robot")
    session.execute(
        update(EmbodimentRow)
        .where(EmbodimentRow.world == world.name, EmbodimentRow.robot.in_(robots))
        .values(lease_s=None, lease_until_s=None, lease_told_s=None)
    )


def forget_absent(session: Session, world: WorldFile) -> None:
    """Drop the moves of robots that the world does not have."""
    here = [one.name for one in world.robots]
    session.execute(
        delete(EmbodimentRow).where(EmbodimentRow.world == world.name, EmbodimentRow.robot.not_in(here))
    )


def _end_moves(
    session: Session, events: EventLog, world: WorldFile, robots: Collection[str], reason: str
) -> None:
    query = select(EmbodimentRow).where(
        EmbodimentRow.world == world.name, EmbodimentRow.state.in_(OPEN), EmbodimentRow.robot.in_(robots)
    )
    for row in session.scalars(query.with_for_update()).all():
        end_anew(row, has_body=has_body(world, row), reason=reason)
        if row.state == EmbodimentState.RETURNED:
            before = newest_move(session, row.world, row.robot, before=row.fence)
            row.lease_s = None if before is None else before.lease_s
        row.ended_at = utc_now()
        tell_of_move(session, events, row)
