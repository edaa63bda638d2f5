"""The book of durations: robots' reports of finished packets in, what was learned of a world out."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.durations import Durations, Kind, Learned
from app.store import DurationRow, PlanRow, ScriptRow


def learned_durations(session: Session, world: str) -> Durations:
    """What was learned in the world, by action and team size, in alphabetical order."""
    query = (
        select(DurationRow).where(DurationRow.world == world).order_by(DurationRow.action, DurationRow.team)
    )
    return {(row.action, row.team): _learned(row) for row in session.scalars(query)}


def learn(session: Session, world: str, script: ScriptRow, packet_id: str, times: Mapping[str, Any]) -> None:
    """Take up how long a finished packet ran; the caller sees to it that each packet comes once.

    Waiting for its sensor pre-conditions does not count. Nothing of a script that was ever told to pause or
    stop does: how long its robot stood still is not known to the second.

    :param times: the packet's `started_at_s` (None if its start was never heard of) and `finished_at_s`.
    """
    started_s, finished_s = times.get("started_at_s"), times["finished_at_s"]
    if script.orders or started_s is None or finished_s <= started_s:
        return
    plan = session.get_one(PlanRow, script.plan_id)
    action = next(action for action in plan.body["actions"] if action["id"] == packet_id)
    kind = action["tag"], len(action["agents"])
    # The plan's durations were scaled by what was known then; learned is the ratio to the knowledge base's own.
    expected_s = action["duration_s"] / plan.duration_factors.get(key_of(kind), 1.0)
    _add(session, world, kind, (finished_s - started_s) / expected_s)


def key_of(kind: Kind) -> str:
    """The kind as a key of JSON: `DOCK/1`."""
    return f"{kind[0]}/{kind[1]}"


def _add(session: Session, world: str, kind: Kind, ratio: float) -> None:
    action, team = kind
    row = session.get(DurationRow, (world, action, team), with_for_update=True)
    if row is None:
        row = DurationRow(world=world, action=action, team=team, samples=0, mean=1.0, variance=0.0)
        session.add(row)
    after = _learned(row).with_sample(ratio)
    row.samples, row.mean, row.variance = after.samples, after.mean, after.variance


def _learned(row: DurationRow) -> Learned:
    return Learned(samples=row.samples, mean=row.mean, variance=row.variance)
