"""Learned durations in the database: updated by robots' reports of finished packets, read for planning."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.durations import Durations, Kind, Learned
from app.store import DurationRow, PlanRow, ScriptRow
from app.store.world_summary import summary_of


def learned_durations(session: Session, world: str) -> Durations:
    """Learned durations of a world by action and team size, in alphabetical order."""
    if not summary_of(session, world).has_durations:
        return {}
    query = (
        select(DurationRow).where(DurationRow.world == world).order_by(DurationRow.action, DurationRow.team)
    )
    return {(row.action, row.team): _learned(row) for row in session.scalars(query)}


def learn(session: Session, world: str, script: ScriptRow, packet_id: str) -> None:
    """Learn from how long a finished packet ran; the caller passes each packet once, when its times are recorded.

    Waiting for its sensor pre-conditions does not count. Scripts that were ever ordered to pause or stop are ignored:
    how long their robots stood still is not known exactly; so are actions that last as long as a number needs. Of an
    action in phases it learns at the end of the last one, from all together: times within actions are not scaled by
    what is learned.
    """
    plan = session.get_one(PlanRow, script.plan_id)
    actions = {action["id"]: action for action in plan.body["actions"]}
    action = actions[packet_id]
    is_elastic = action.get("level") is not None
    if script.orders or is_elastic or action.get("phase", 0) != action.get("phases", 0):
        return
    order = [packet["id"] for packet in script.body["packets"]]
    last = order.index(packet_id) + 1
    parts = order[max(0, last - max(1, action.get("phases", 0))) : last]
    spans = [_span_s(script.packets.get(one, {})) for one in parts]
    if len(parts) < action.get("phases", 0) or not all(spans):
        return
    kind = (action["tag"], len(action["agents"]))
    # The plan's durations were scaled by factors learned before; the ratio is to the knowledge base's durations.
    planned_s = sum(actions[one]["duration_s"] for one in parts)
    expected_s = planned_s / plan.duration_factors.get(key_of(kind), 1.0)
    _add(session, world, kind, sum(spans) / expected_s)


def _span_s(times: Mapping[str, Any]) -> float:
    """How long a packet ran; 0 if its start or end was never reported."""
    started_s, finished_s = times.get("started_at_s"), times.get("finished_at_s")
    return 0.0 if started_s is None or finished_s is None else max(0.0, finished_s - started_s)


def key_of(kind: Kind) -> str:
    """The kind as a JSON key: `DOCK/1`."""
    return f"{kind[0]}/{kind[1]}"


def _add(session: Session, world: str, kind: Kind, ratio: float) -> None:
    action, team = kind
    row = session.get(DurationRow, (world, action, team), with_for_update=True)
    if row is None:
        row = DurationRow(world=world, action=action, team=team, samples=0, mean=1.0, variance=0.0)
        session.add(row)
    after = _learned(row).with_sample(ratio)
    row.samples = after.samples
    row.mean = after.mean
    row.variance = after.variance


def _learned(row: DurationRow) -> Learned:
    return Learned(samples=row.samples, mean=row.mean, variance=row.variance)
