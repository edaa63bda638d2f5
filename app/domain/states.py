"""The states of goals, plans, missions and connections, as every client sees them."""

from enum import StrEnum

from robots.wire import ScriptState


class GoalState(StrEnum):
    SUBMITTED = "submitted"  # waits for the planner or, with a reason, for a running mission
    PLANNING = "planning"
    PLANNED = "planned"
    UNSOLVABLE = "unsolvable"
    COMMITTED = "committed"
    FINISHED = "finished"
    WITHDRAWN = "withdrawn"


class PlanState(StrEnum):
    PROPOSED = "proposed"
    APPROVED = "approved"
    REJECTED = "rejected"
    SUPERSEDED = "superseded"
    EXPIRED = "expired"


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
