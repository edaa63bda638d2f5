"""Durable workflows: the only package that uses DBOS.

The service's own tables are authoritative; a workflow only processes a goal or mission further, also after a crash. A
workflow is created, and is woken, by the transaction that makes it necessary.
"""

from app.workflows.engine import Workflows
from app.workflows.queues import (
    BETTER_PLANS,
    FIND_ALTERNATIVES,
    LARGE_PLANNING,
    MISSION_LIFE,
    MISSIONS,
    PLAN_GOAL,
    PLAN_WAITING,
    PLANNING,
    QUEUES,
    RECOVER_MISSION,
    SEEK_BETTER_PLANS,
    WAITING,
    Queue,
)
from app.workflows.steps import StepFailed, current_workflow, or_give_up, sleep_until_woken, step

__all__ = [
    "BETTER_PLANS",
    "FIND_ALTERNATIVES",
    "LARGE_PLANNING",
    "MISSIONS",
    "MISSION_LIFE",
    "PLANNING",
    "PLAN_GOAL",
    "PLAN_WAITING",
    "QUEUES",
    "RECOVER_MISSION",
    "SEEK_BETTER_PLANS",
    "WAITING",
    "Queue",
    "StepFailed",
    "Workflows",
    "current_workflow",
    "or_give_up",
    "sleep_until_woken",
    "step",
]
