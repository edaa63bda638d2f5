"""Durable workflows: the one package that knows DBOS.

The domain tables are the record; a workflow is the mechanism that carries a goal or a mission on, also after a crash.
A workflow and a message to it are started inside the transaction that makes them necessary, so neither can be lost.
"""

from app.durable.queues import MISSIONS, PLANNING, QUEUES, WAITING, Queue
from app.durable.steps import StepFailed, or_give_up, sleep_until_woken, step, this_workflow
from app.durable.workflows import Workflows

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
