"""Reads missions and what belongs to them from the database, for their recordings."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from sqlalchemy import select

from app.domain.lifecycles.mission import OPEN
from app.store import Database, EventRow, GoalRow, MissionRow, PlanRow, ResultRow, ScriptRow

MISSION_ID = re.compile(r"mission-[0-9a-f]+")


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRecord:
    """A mission with its goal, the ids of all plans made for it, and its scripts."""

    mission: MissionRow
    goal: GoalRow
    plans: tuple[str, ...]
    scripts: tuple[ScriptRow, ...]


class MissionReader:
    """Reads missions from the database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def open_missions(self) -> Collection[str]:
        """The ids of missions that have not ended."""
        with self._database.read() as session:
            return session.scalars(select(MissionRow.id).where(MissionRow.state.in_(OPEN))).all()

    def missions(self, ids: Collection[str]) -> Sequence[MissionRow]:
        if not ids:
            return ()
        with self._database.read() as session:
            return session.scalars(select(MissionRow).where(MissionRow.id.in_(ids))).all()

    def records(self, missions: Sequence[MissionRow]) -> list[MissionRecord]:
        if not missions:
            return []
        goal_ids = [mission.goal_id for mission in missions]
        ids = [mission.id for mission in missions]
        with self._database.read() as session:
            goals = session.scalars(select(GoalRow).where(GoalRow.id.in_(goal_ids))).all()
            made = select(PlanRow.id, PlanRow.goal_id).where(PlanRow.goal_id.in_(goal_ids))
            plans = session.execute(made.order_by(PlanRow.created_at)).all()
            scripts = session.scalars(select(ScriptRow).where(ScriptRow.mission_id.in_(ids))).all()
        return [
            MissionRecord(
                mission=one,
                goal=next(goal for goal in goals if goal.id == one.goal_id),
                plans=tuple(plan for plan, goal in plans if goal == one.goal_id),
                scripts=tuple(script for script in scripts if script.mission_id == one.id),
            )
            for one in missions
        ]

    def result(self, result_id: str) -> ResultRow | None:
        """A result with its content; None if it was deleted."""
        with self._database.read() as session:
            return session.get(ResultRow, result_id)

    def events(self, record: MissionRecord, *, after: int, before: int) -> Sequence[EventRow]:
        """The events of the goal, its plans and the mission with `after` < seq < `before`."""
        subjects = [record.goal.id, *record.plans, record.mission.id]
        query = select(EventRow).where(
            EventRow.subject.in_(subjects), EventRow.seq > after, EventRow.seq < before
        )
        with self._database.read() as session:
            return session.scalars(query.order_by(EventRow.seq)).all()


def names_in(event: EventRow) -> frozenset[str]:
    """The subject, the goal and the missions that an event names."""
    named = {event.subject, event.data.get("goal"), event.data.get("mission")} - {None}
    missions = {match[0] for one in named if (match := MISSION_ID.match(str(one)))}
    return frozenset(map(str, named)) | missions
