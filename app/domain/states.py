"""The states of goals, plans, missions and connections, as every client sees them."""

from enum import StrEnum

from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.plan import PlanState
from robots.wire import ScriptState

__all__ = [
    "ENDED",
    "TERMINAL_SCRIPTS",
    "Connection",
    "GoalState",
    "MissionState",
    "PlanState",
]


class MissionState(StrEnum):
    PENDING = "pending"
    DISPATCHING = "dispatching"
    RUNNING = "running"
    PAUSED = "paused"
    UNKNOWN = "unknown"
    RECOVERING = "recovering"
    COMPLETED = "completed"
    PARTIALLY_COMPLETED = "partially_completed"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def ended(self) -> bool:
        return self in ENDED


ENDED = frozenset(
    {
        MissionState.COMPLETED,
        MissionState.PARTIALLY_COMPLETED,
        MissionState.FAILED,
        MissionState.CANCELLED,
    }
)


TERMINAL_SCRIPTS = frozenset({ScriptState.FINISHED, ScriptState.FAILED, ScriptState.CANCELLED})


class Connection(StrEnum):
    ONLINE = "online"
    OFFLINE = "offline"
    HIBERNATING = "hibernating"
    CONNECTION_BROKEN = "connection_broken"
