"""Missions and scripts as plain objects, for tests of their life cycles."""

from dataclasses import dataclass, field
from typing import Any

from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.recovery import Attempt
from app.domain.lifecycles.script import Delivery


@dataclass
class PlainMission:
    state: str = MissionState.PENDING
    plan_id: str = "plan-1"
    resume_to: str | None = None
    reason: str = ""
    failure: str | None = None
    is_overdue: bool = False
    ended_at_s: float | None = None
    recovery_step: str | None = None
    tries_left: int = 4
    attempts: list[Attempt] = field(default_factory=list)
    stopped_for: str = ""
    replanning: dict[str, Any] | None = None
    joined_goals: list[str] = field(default_factory=list)


@dataclass
class PlainScript:
    id: str = "m-fred"
    plan_id: str = "plan-1"
    delivery: str = Delivery.PENDING
    state: str | None = None
    detail: str = ""
    category: str | None = None
    perceived: list[Any] = field(default_factory=list)
    heard_at_s: float | None = None
    stopping: bool = False
    abandoned: bool = False
    orders: int = 0
    control: str | None = None
    control_number: int | None = None
    question: str | None = None
    clearance: str | None = None
    doubt: str = ""
