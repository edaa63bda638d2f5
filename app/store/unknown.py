"""What is not known of a world, in one list: samples without a place, robots that are lost or do not answer."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.script import TERMINAL_SCRIPTS, Delivery
from app.domain.world_model.beliefs import OBJECT_POSITION, ROBOT_POSITION
from app.domain.world_model.timeliness import Dated
from app.store import MissionRow, ScriptRow, UnknownRow
from app.store.doubts import unknowns
from app.store.lost_robots import lost_rows
from planner import Fact


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknown:
    """A thing of which something is not known; `last` is where it was believed to be."""

    name: str
    reason: str
    since_s: float | None
    last: Dated | None


def not_known(
    session: Session, world: str, *, known: Sequence[Dated], samples: Collection[str]
) -> list[Unknown]:
    """In alphabetical order, each thing once.

    :param known: every fact that is believed.
    :param samples: of the world.
    """
    placed = {one.fact.args[0]: one for one in known if one.fact.predicate == ROBOT_POSITION}
    found = {row.name: _misplaced(row) for row in unknowns(session, world)}
    located = {one.fact.args[0] for one in known if one.fact.predicate == OBJECT_POSITION}
    for name in set(samples) - located - found.keys():
        found[name] = Unknown(name=name, reason="nobody has said where it is", since_s=None, last=None)
    for row in lost_rows(session, world):
        reason = f"{row.declared_by} declared it lost" + (f": {row.comment}" if row.comment else "")
        last = placed.get(row.robot)
        found[row.robot] = Unknown(name=row.robot, reason=reason, since_s=row.since_s, last=last)
        for held in (one for one in known if one.fact.predicate == OBJECT_POSITION):
            sample, _, ref = held.fact.args
            if ref == row.robot:
                why = f"it was in {ref}, which {row.declared_by} declared lost"
                found[sample] = Unknown(name=sample, reason=why, since_s=row.since_s, last=held)
    for robot, mission_id, heard_at_s in _silent(session, world):
        reason = f"it has not answered what mission {mission_id} asked or ordered"
        silent = Unknown(name=robot, reason=reason, since_s=heard_at_s, last=placed.get(robot))
        found.setdefault(robot, silent)
    return [found[name] for name in sorted(found)]


def _misplaced(row: UnknownRow) -> Unknown:
    last = Dated(
        fact=Fact(row.believed["predicate"], tuple(row.believed["args"])),
        source=row.believed_by,
        at_s=row.believed_at_s,
    )
    reason = f"it is not where it was believed to be ({row.source})"
    return Unknown(name=row.name, reason=reason, since_s=row.since_s, last=last)


def _silent(session: Session, world: str) -> Sequence[tuple[str, str, float | None]]:
    """Robots of missions in `unknown` that owe an answer, with when they were last heard of it (world's clock)."""
    query = (
        select(ScriptRow.robot, MissionRow.id, ScriptRow.heard_at_s)
        .join(MissionRow, MissionRow.id == ScriptRow.mission_id)
        .where(
            MissionRow.world == world,
            MissionRow.state == MissionState.UNKNOWN,
            ScriptRow.plan_id == MissionRow.plan_id,
            ScriptRow.question.is_not(None)
            | ScriptRow.control.is_not(None)
            | (ScriptRow.delivery == Delivery.PENDING),
            ScriptRow.state.is_(None) | ScriptRow.state.not_in(TERMINAL_SCRIPTS),
        )
    )
    return [(robot, mission, heard_s) for robot, mission, heard_s in session.execute(query)]
