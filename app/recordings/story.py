"""What the record says of missions: which are to be recorded, what is about each, how it all began."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select

from app.domain.lifecycles.mission import ENDED
from app.store import Database, EventRow, GoalRow, MissionRow, PlanRow, ScriptRow

MISSION_ID = re.compile(r"mission-[0-9a-f]+")


@dataclass(frozen=True, slots=True, kw_only=True)
class Chapter:
    """A mission as it stands, with its goal, all plans that were made for it, and its scripts."""

    mission: MissionRow
    goal: GoalRow
    plans: tuple[str, ...]
    scripts: tuple[ScriptRow, ...]


class Story:
    """Reads the record."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def under_way(self) -> Collection[str]:
        with self._database.read() as session:
            return session.scalars(select(MissionRow.id).where(MissionRow.state.not_in(ENDED))).all()

    def missions(self, ids: Collection[str]) -> Sequence[MissionRow]:
        if not ids:
            return ()
        with self._database.read() as session:
            return session.scalars(select(MissionRow).where(MissionRow.id.in_(ids))).all()

    def chapters(self, missions: Sequence[MissionRow]) -> list[Chapter]:
        if not missions:
            return []
        goal_ids, ids = [one.goal_id for one in missions], [one.id for one in missions]
        with self._database.read() as session:
            goals = session.scalars(select(GoalRow).where(GoalRow.id.in_(goal_ids))).all()
            made = select(PlanRow.id, PlanRow.goal_id).where(PlanRow.goal_id.in_(goal_ids))
            plans = session.execute(made.order_by(PlanRow.created_at)).all()
            scripts = session.scalars(select(ScriptRow).where(ScriptRow.mission_id.in_(ids))).all()
        return [
            Chapter(
                mission=one,
                goal=next(goal for goal in goals if goal.id == one.goal_id),
                plans=tuple(plan for plan, goal in plans if goal == one.goal_id),
                scripts=tuple(script for script in scripts if script.mission_id == one.id),
            )
            for one in missions
        ]

    def events(self, chapter: Chapter, *, after: int, before: int) -> Sequence[EventRow]:
        """What happened to the goal, its plans and the mission, between two numbers of events."""
        about = [chapter.goal.id, *chapter.plans, chapter.mission.id]
        wanted = select(EventRow).where(
            EventRow.subject.in_(about), EventRow.seq > after, EventRow.seq < before
        )
        with self._database.read() as session:
            return session.scalars(wanted.order_by(EventRow.seq)).all()


def names_in(event: EventRow) -> frozenset[str]:
    """What an event is about: missions that it names, its subject, and its goal."""
    named = {event.subject, event.data.get("goal"), event.data.get("mission")} - {None}
    missions = {match[0] for one in named if (match := MISSION_ID.match(str(one)))}
    return frozenset(map(str, named)) | missions


def told(event: EventRow) -> dict[str, Any]:
    """The event as the API has it."""
    return {
        "seq": event.seq,
        "time": event.time,
        "type": event.type,
        "subject": event.subject,
        "data": event.data,
    }
