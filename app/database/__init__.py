"""The record: tables, migrations and transactions. SQLite embedded, PostgreSQL in production."""

from app.database.engine import WRITTEN, Database, after_commit, announce, is_away, write_last
from app.database.tables import (
    Base,
    DurationRow,
    EventRow,
    ExecutorRow,
    FactRow,
    GoalRow,
    LeaseRow,
    LostRobotRow,
    MessageRow,
    MissionRow,
    PlanRow,
    ScriptRow,
    TuningRow,
    UnknownRow,
    WorldRow,
)

__all__ = [
    "WRITTEN",
    "Base",
    "Database",
    "DurationRow",
    "EventRow",
    "ExecutorRow",
    "FactRow",
    "GoalRow",
    "LeaseRow",
    "LostRobotRow",
    "MessageRow",
    "MissionRow",
    "PlanRow",
    "ScriptRow",
    "TuningRow",
    "UnknownRow",
    "WorldRow",
    "after_commit",
    "announce",
    "is_away",
    "write_last",
]
