"""The record of moves of minds: the newest of a robot, and the end of those that have lost their minds.

A simulated body is recorded as in a world file; a real one, with software of its own, as `{"kind": "real"}`, with the
body that its world's file gives it as `spec`.
"""

from collections.abc import Collection, Mapping
from typing import Any

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from app.domain.events import EmbodimentChanged
from app.domain.lifecycles.embodiment import OPEN, EmbodimentState, end_anew
from app.domain.world_model.edits import ChangeRobot
from app.store import EmbodimentRow
from app.store.event_log import EventLog
from app.store.tables import utc_now
from robots.wire import MindPiece, Program
from robots.world import RobotSpec, WorldFile
from robots.world.bodies import BodyKind, BodySpec


def newest_move(
    session: Session, world: str, robot: str, *, before: int | None = None
) -> EmbodimentRow | None:
    """:param before: only of those with a lower fencing number; None: of all."""
    query = select(EmbodimentRow).where(EmbodimentRow.world == world, EmbodimentRow.robot == robot)
    if before is not None:
        query = query.where(EmbodimentRow.fence < before)
    return session.scalar(query.order_by(EmbodimentRow.fence.desc()).limit(1))


def body_record(spec: RobotSpec) -> dict[str, Any]:
    """The body that the robot has."""
    body = spec.body.model_dump(mode="json")
    return {"kind": BodyKind.REAL.value, "spec": body} if spec.external else body


def wanted_record(body: BodySpec | None, spec: RobotSpec) -> dict[str, Any]:
    """A body that the robot is to have; None: its real one."""
    if body is not None:
        return body.model_dump(mode="json")
    return {"kind": BodyKind.REAL.value, "spec": spec.body.model_dump(mode="json")}


def is_real(body: Mapping[str, Any]) -> bool:
    return bool(body["kind"] == BodyKind.REAL)


def program_of(body: Mapping[str, Any]) -> Program:
    """The program in which a mind with this body is."""
    return Program.OWN if is_real(body) else Program.WORLD


def crosses(row: EmbodimentRow) -> bool:
    """Whether the mind moves from one program to another."""
    return is_real(row.body) is not is_real(row.former)


def exchange_edit(robot: str, body: Mapping[str, Any], *, replaces: bool) -> ChangeRobot:
    """The edit by which the robot gets the body.

    :param replaces: another program speaks for it then.
    :raises ValidationError: if it is no body.
    """
    spec = body["spec"] if is_real(body) else body
    external = {"external": is_real(body)} if replaces else {}
    return ChangeRobot.model_validate({"name": robot, "body": spec, **external})


def has_body(world: WorldFile, row: EmbodimentRow) -> bool:
    """Whether the robot has, in this edition, the body that the move leads to."""
    spec = world.robot(row.robot)
    return spec.external if is_real(row.body) else body_record(spec) == row.body


def keep_piece(row: EmbodimentRow, piece: MindPiece) -> None:
    """Keep a piece of the mind's document; one of another document, or out of turn, does not count."""
    known = row.mind
    if known is None or known["digest"] != piece.digest:
        known = {"digest": piece.digest, "count": piece.count, "texts": []}
    if piece.number == len(known["texts"]):
        known = {**known, "texts": [*known["texts"], piece.text]}
    row.mind = known


def is_complete(row: EmbodimentRow) -> bool:
    """Whether all pieces of the mind's document are there."""
    return row.mind is not None and len(row.mind["texts"]) == row.mind["count"]


def next_piece(row: EmbodimentRow) -> MindPiece:
    """The piece that the other program does not have yet."""
    assert row.mind is not None
    number = row.taken
    return MindPiece(
        number=number,
        count=row.mind["count"],
        digest=row.mind["digest"],
        text=row.mind["texts"][number],
    )


def mind_text(row: EmbodimentRow) -> str:
    """The whole document."""
    assert row.mind is not None
    return "".join(row.mind["texts"])


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
        row.mind = None
        tell_of_move(session, events, row)
