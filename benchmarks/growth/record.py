"""Fills a service's record with copies of a goal, its plan and its mission that were really carried out."""

import itertools
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, MetaData, Table, insert, select, text

from app.domain.clock import iso_utc
from app.store import Database, EventRow, GoalRow, MessageRow, MissionRow, PlanRow, ScriptRow

CHUNK = 2000
APART_S = 25.0
"""Between the submissions of two goals."""
ONE_OF_TEN = 10
Row = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Size:
    """How much a record holds. Each goal beyond the missions and the open ones was withdrawn or is unsolvable."""

    events: int
    goals: int
    missions: int
    open_goals: int = 20

    def __str__(self) -> str:
        return f"{self.events:,} events, {self.goals:,} goals, {self.missions:,} missions"


SMALL = Size(events=1000, goals=300, missions=150)
LARGE = Size(events=1_000_000, goals=100_000, missions=10_000)


def fill(url: str, size: Size) -> None:
    """Copy the record's only mission, with all that belongs to it, until the record has the size.

    Also the workflow engine's finished workflows, one for each goal and mission.
    """
    database = Database(url)
    schema = "dbos" if database.shared else None
    with database.engine.connect() as connection:
        if not database.shared:
            connection.exec_driver_sql("BEGIN IMMEDIATE")
        originals = _Originals.read(connection, schema)
        _insert(connection, originals.goals, (originals.goal(n, size) for n in range(1, size.goals)))
        planned = [n for n in range(1, size.goals) if _kind(n, size) != WITHDRAWN]
        _insert(connection, originals.plans, (originals.plan(n, size) for n in planned))
        carried_out = range(1, size.missions)
        _insert(connection, originals.missions, (originals.mission(n) for n in carried_out))
        _insert(connection, originals.scripts, _each(originals.script, carried_out, originals.script_rows))
        _insert(connection, originals.messages, _each(originals.message, carried_out, originals.message_rows))
        workflows = _each(originals.workflow, range(1, size.goals), originals.workflow_rows)
        _insert(connection, originals.workflows, (one for one in workflows if one))
        missing = max(0, size.events - len(originals.event_rows))
        _insert(connection, originals.events, itertools.islice(originals.events_of(size), missing))
        connection.commit()
        if database.shared:  # as the server does by itself, in a while
            connection.execute(text("ANALYZE"))
            connection.commit()
    database.close()


MISSION, OPEN, REJECTED, WITHDRAWN = "mission", "open", "rejected", "withdrawn"


def _kind(number: int, size: Size) -> str:
    """What became of a goal: the first ones, which are the newest, were carried out."""
    if number < size.missions:
        return MISSION
    if number < size.missions + size.open_goals:
        return OPEN
    return REJECTED if number % ONE_OF_TEN == 0 else WITHDRAWN


def _each(make: Callable[[int, Row], Row], numbers: Iterable[int], rows: list[Row]) -> Iterator[Row]:
    return (make(number, row) for number in numbers for row in rows)


def _insert(connection: Connection, table: Table, rows: Iterable[Row]) -> None:
    rows = iter(rows)
    while chunk := list(itertools.islice(rows, CHUNK)):
        connection.execute(insert(table), chunk)


def _renamed(name: str, names: Mapping[str, str]) -> str:
    """The name with other ids in it."""
    for known, other in names.items():
        name = name.replace(known, other)
    return name


@dataclass(frozen=True, slots=True, kw_only=True)
class _Originals:
    """The rows that are copied, and their tables."""

    goals: Table
    plans: Table
    missions: Table
    scripts: Table
    messages: Table
    events: Table
    workflows: Table
    goal_row: Row
    plan_row: Row
    mission_row: Row
    script_rows: list[Row]
    message_rows: list[Row]
    event_rows: list[Row]
    workflow_rows: list[Row]
    now_s: float

    @classmethod
    def read(cls, connection: Connection, schema: str | None) -> "_Originals":
        tables: Any = {
            name: row.__table__
            for name, row in (
                ("goals", GoalRow),
                ("plans", PlanRow),
                ("missions", MissionRow),
                ("scripts", ScriptRow),
                ("messages", MessageRow),
                ("events", EventRow),
            )
        }
        workflows = Table("workflow_status", MetaData(), schema=schema, autoload_with=connection)

        def rows(table: Any) -> list[Row]:
            return [dict(row) for row in connection.execute(select(table)).mappings()]

        goal = rows(tables["goals"])[0]
        return cls(
            **tables,
            workflows=workflows,
            goal_row=goal,
            plan_row=rows(tables["plans"])[0],
            mission_row=rows(tables["missions"])[0],
            script_rows=rows(tables["scripts"]),
            message_rows=rows(tables["messages"]),
            event_rows=rows(tables["events"]),
            workflow_rows=[row for row in rows(workflows) if row["status"] == "SUCCESS"],
            now_s=time.time(),
        )

    def at(self, number: int) -> str:
        """When that goal was submitted."""
        return iso_utc(self.now_s - number * APART_S)

    def names(self, number: int) -> dict[str, str]:
        """The originals' ids, and those of a copy."""
        return {
            self.goal_row["id"]: f"goal-{number:012x}",
            self.plan_row["id"]: f"plan-{number:012x}",
            self.mission_row["workflow"]: f"life-{number:012x}",
            self.mission_row["id"]: f"mission-{number:012x}",  # a mission's first workflow may have its id
        }

    def goal(self, number: int, size: Size) -> Row:
        kind = _kind(number, size)
        changes: Row = {
            "id": f"goal-{number:012x}",
            "plan_id": None if kind == WITHDRAWN else f"plan-{number:012x}",
            "mission_id": f"mission-{number:012x}" if kind == MISSION else None,
            "auto_approve": kind == MISSION,
            "created_at": self.at(number),
            "updated_at": self.at(number),
        }
        if kind == OPEN:
            changes |= {"state": "planned", "outcome": None}
        elif kind != MISSION:
            is_unsolvable = kind == WITHDRAWN and number % 3 == 0
            changes |= (
                {"state": "unsolvable", "outcome": "unsolvable", "reason": "no robot reaches it"}
                if is_unsolvable
                else {"state": "withdrawn", "outcome": kind}
            )
        return self.goal_row | changes

    def plan(self, number: int, size: Size) -> Row:
        state = {MISSION: "approved", OPEN: "proposed", REJECTED: "rejected"}[_kind(number, size)]
        names = self.names(number)
        return self.plan_row | {
            "id": f"plan-{number:012x}",
            "goal_id": f"goal-{number:012x}",
            "state": state,
            "body": self.plan_row["body"]
            | {one: names[self.plan_row["body"][one]] for one in ("id", "goal_id")},
            "created_at": self.at(number),
        }

    def mission(self, number: int) -> Row:
        return self.mission_row | {
            "id": f"mission-{number:012x}",
            "workflow": f"life-{number:012x}",
            "goal_id": f"goal-{number:012x}",
            "plan_id": f"plan-{number:012x}",
            "state": "failed" if number % ONE_OF_TEN == 0 else "completed",
            "created_at": self.at(number),
        }

    def script(self, number: int, row: Row) -> Row:
        names = self.names(number)
        changes = {key: _renamed(row[key], names) for key in ("id", "mission_id", "plan_id")}
        return (
            row | changes | {"body": row["body"] | {"id": changes["id"], "mission_id": changes["mission_id"]}}
        )

    def message(self, number: int, row: Row) -> Row:
        return row | {"id": f"{number:x}-{row['id']}", "recorded_at": self.at(number)}

    def workflow(self, number: int, row: Row) -> Row:
        names = self.names(number)
        workflow_id = _renamed(row["workflow_uuid"], names)
        return row | {"workflow_uuid": workflow_id} if workflow_id != row["workflow_uuid"] else {}

    def events_of(self, size: Size) -> Iterator[Row]:
        """Each mission's events, again and again, so that each mission has as many."""
        for number in itertools.cycle(range(1, size.missions)):
            names = self.names(number)
            for row in self.event_rows:
                yield {
                    "time": self.at(number),
                    "type": row["type"],
                    "subject": _renamed(row["subject"], names),
                    "data": row["data"],
                }
