"""The parts of a workflow: steps whose results are recorded, and waiting for a message."""

import logging
import threading
from collections.abc import Callable
from contextvars import ContextVar
from typing import Any

from dbos import DBOS
from dbos import error as dbos_error

from app.store import is_unavailable

WAKE = "wake"
STEP_ATTEMPTS = 4
UNAVAILABLE_RETRY_S = 0.5
"""Pause before a step that found the database unavailable is tried again."""
CLOSING: ContextVar[threading.Event] = ContextVar("closing")
"""Inside a workflow: the event that is set once the process ends."""

logger = logging.getLogger(__name__)


class StepFailed(Exception):
    """Raised when a step has failed `STEP_ATTEMPTS` times; the message names it."""


def step(name: str, function: Callable[[], Any]) -> Any:
    """Run a step of the current workflow. Its result, JSON data, is recorded and not computed again on replay.

    A step that fails is retried with increasing pauses; while the database is unavailable, without limit.

    :raises StepFailed: if it failed `STEP_ATTEMPTS` times.
    """

    def logged() -> Any:
        while True:
            try:
                return function()
            except Exception as error:
                if not is_unavailable(error):
                    logger.exception("step %r failed", name)
                    raise
                logger.warning("step %r waits for the database: %s", name, error)
                if CLOSING.get().wait(UNAVAILABLE_RETRY_S):
                    raise

    try:
        return DBOS.run_step(
            {"name": name, "retries_allowed": True, "interval_seconds": 0.5, "max_attempts": STEP_ATTEMPTS},
            logged,
        )
    except dbos_error.DBOSMaxStepRetriesExceeded as error:
        raise StepFailed(f"step {name!r} failed {STEP_ATTEMPTS} times; the log says why") from error


def or_give_up(work: Callable[[], None], give_up: Callable[[str], None]) -> None:
    """Run a workflow's steps; if one fails for good, run `give_up` with the reason as the last step."""
    try:
        work()
    except StepFailed as failure:
        reason = str(failure)
        step("give up", lambda: give_up(reason))


def this_workflow() -> str:
    """The id of the workflow that calls this."""
    workflow_id = DBOS.workflow_id
    assert workflow_id is not None
    return workflow_id


def sleep_until_woken(timeout_s: float) -> None:
    """Wait inside a workflow for a message, `timeout_s` at most; the end of the wait is recorded."""
    DBOS.recv(WAKE, timeout_seconds=timeout_s)
