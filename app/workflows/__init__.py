"""Durable workflows: the one package that knows DBOS.

The domain tables are the record; a workflow is the mechanism that carries a goal or a mission on, also after a crash.
A workflow and a message to it are started inside the transaction that makes them necessary, so neither can be lost.
"""

from app.workflows.engine import Workflows
from app.workflows.queues import MISSIONS, PLANNING, QUEUES, WAITING, Queue
from app.workflows.steps import StepFailed, or_give_up, sleep_until_woken, step, this_workflow

__all__ = [
    "MISSIONS",
    "PLANNING",
    "QUEUES",
    "WAITING",
    "Queue",
    "StepFailed",
    "Workflows",
    "or_give_up",
    "sleep_until_woken",
    "step",
    "this_workflow",
]
