"""What is not known of a world: objects and robots without a believed place, robots that are lost or do not answer."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.script import TERMINAL_SCRIPTS, Delivery
from app.domain.world_model.beliefs import OBJECT_POSITION, ROBOT_POSITION
from app.domain.world_model.timeliness import DatedFact
from app.store.records import lost_robots
from app.store.tables import MissionRow, ScriptRow, UnknownRow
from planner import Fact

PLACED = (OBJECT_POSITION, ROBOT_POSITION)
INSTEAD_OF = "instead_of"
"""The key under which the last belief about an unknown thing keeps the beliefs that it had replaced."""


def unknown_rows(session: Session, world: str) -> Sequence[UnknownRow]:
    """Objects and robots that lost their believed place, in alphabetical order."""
    query = select(UnknownRow).where(UnknownRow.world == world).order_by(UnknownRow.name)
    return session.scalars(query).all()


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknown:
    """A sample or robot whose place or state is not known.

    :param last: its last believed place.
    :param earlier: the beliefs that this one had replaced, newest first.
    """

    name: str
    reason: str
    since_s: float | None
    last: DatedFact | None
    earlier: Sequence[DatedFact] = ()


def list_unknowns(
    session: Session,
    world: str,
    *,
    known: Sequence[DatedFact],
    samples: Collection[str],
    under_way: Collection[str],
) -> list[Unknown]:
    """What is not known of a world, in alphabetical order, each name once.

    :param known: every fact that is believed.
    :param samples: the names of the world's samples.
    :param under_way: the predicates that hold between the phases of an action: its robot has left one place on its way
        to another.
    """
    placed = {one.fact.args[0]: one for one in known if one.fact.predicate == ROBOT_POSITION}
    on_ways = {one.fact.args[0] for one in known if one.fact.predicate in under_way}
    rows = unknown_rows(session, world)
    found = {row.name: _misplaced(row) for row in rows if row.name not in on_ways}
    located = {one.fact.args[0] for one in known if one.fact.predicate == OBJECT_POSITION}
    for name in set(samples) - located - found.keys():
        found[name] = Unknown(name=name, reason="its place was never reported", since_s=None, last=None)
    for row in lost_robots(session, world):
        reason = f"{row.declared_by} declared it lost" + (f": {row.comment}" if row.comment else "")
        last = placed.get(row.robot)
        found[row.robot] = Unknown(name=row.robot, reason=reason, since_s=row.since_s, last=last)
        for held in (one for one in known if one.fact.predicate == OBJECT_POSITION):
            sample, _, ref = held.fact.args
            if ref == row.robot:
                why = f"it was in {ref}, which {row.declared_by} declared lost"
                found[sample] = Unknown(name=sample, reason=why, since_s=row.since_s, last=held)
    for robot, mission_id, heard_at_s in _silent(session, world):
        reason = f"it has not answered a query or an order of mission {mission_id}"
        silent = Unknown(name=robot, reason=reason, since_s=heard_at_s, last=placed.get(robot))
        found.setdefault(robot, silent)
    return [found[name] for name in sorted(found)]


def _misplaced(row: UnknownRow) -> Unknown:
    last = DatedFact(fact=_fact(row.believed), source=row.believed_by, at_s=row.believed_at_s)
    before = row.believed.get(INSTEAD_OF, ())
    earlier = [DatedFact(fact=_fact(one), source=one["source"], at_s=one["at_s"]) for one in before]
    reason = f"it is not where it was believed to be ({row.source})"
    return Unknown(
        name=row.name,
        reason=reason,
        since_s=row.since_s,
        last=last,
        earlier=[one for one in earlier if one.fact.predicate in PLACED and one.fact.args[0] == row.name],
    )


def _fact(belief: Mapping[str, Any]) -> Fact:
    return Fact(belief["predicate"], tuple(belief["args"]))


def _silent(session: Session, world: str) -> Sequence[tuple[str, str, float | None]]:
    """Robots of missions in `unknown` that owe an answer: robot, mission, last report (world's clock)."""
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
