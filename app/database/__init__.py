"""The record: tables, migrations and transactions. SQLite embedded, PostgreSQL in production."""

from app.database.engine import Database, after_commit
from app.database.tables import (
    Base,
    DurationRow,
    EventRow,
    FactRow,
    GoalRow,
    MessageRow,
    MissionRow,
    PlanRow,
    ScriptRow,
    TuningRow,
    WorldRow,
)

__all__ = [
    "Base",
    "Database",
    "DurationRow",
    "EventRow",
    "FactRow",
    "GoalRow",
    "MessageRow",
    "MissionRow",
    "PlanRow",
    "ScriptRow",
    "TuningRow",
    "WorldRow",
    "after_commit",
]
