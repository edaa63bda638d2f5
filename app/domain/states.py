"""The states of goals, plans, missions and connections, as every client sees them."""

from enum import StrEnum

from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import ENDED, MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.script import TERMINAL_SCRIPTS

__all__ = [
    "ENDED",
    "TERMINAL_SCRIPTS",
    "Connection",
    "GoalState",
    "MissionState",
    "PlanState",
]


class Connection(StrEnum):
    ONLINE = "online"
    OFFLINE = "offline"
    HIBERNATING = "hibernating"
    CONNECTION_BROKEN = "connection_broken"
