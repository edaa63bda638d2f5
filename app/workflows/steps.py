"""What a workflow is made of: steps whose results are kept, and waiting until a message comes."""

import logging
import threading
from collections.abc import Callable
from contextvars import ContextVar
from typing import Any

from dbos import DBOS
from dbos import error as dbos_error

from app.store import is_away

WAKE = "wake"
STEP_ATTEMPTS = 4
AWAY_S = 0.5
"""Pause before a step that found the database away is tried again."""
CLOSING: ContextVar[threading.Event] = ContextVar("closing")
"""Inside a workflow: set once the process ends."""

logger = logging.getLogger(__name__)


class StepFailed(Exception):
    """Raised when a step has failed as often as it is tried; the message says which and why."""


def step(name: str, function: Callable[[], Any]) -> Any:
    """Run a step of the current workflow: its result, JSON data, is kept and not computed again on replay.

    A step that fails is tried again a few times, ever later; while the database is away, as often as it takes.

    :raises StepFailed: if it failed every time.
    """

    def logged() -> Any:
        while True:
            try:
                return function()
            except Exception as error:
                if not is_away(error):
                    logger.exception("step %r failed", name)
                    raise
                logger.warning("step %r waits for the database: %s", name, error)
                if CLOSING.get().wait(AWAY_S):
                    raise

    try:
        return DBOS.run_step(
            {"name": name, "retries_allowed": True, "interval_seconds": 0.5, "max_attempts": STEP_ATTEMPTS},
            logged,
        )
    except dbos_error.DBOSMaxStepRetriesExceeded as error:
        raise StepFailed(f"step {name!r} failed {STEP_ATTEMPTS} times; the log says why") from error


def or_give_up(work: Callable[[], None], give_up: Callable[[str], None]) -> None:
    """Take a workflow's steps; if one keeps failing, the step that gives up, with the reason, in place of the rest."""
    try:
        work()
    except StepFailed as failure:
        reason = str(failure)
        step("give up", lambda: give_up(reason))


def this_workflow() -> str:
    """Inside a workflow, its id."""
    workflow_id = DBOS.workflow_id
    assert workflow_id is not None
    return workflow_id


def sleep_until_woken(timeout_s: float) -> None:
    """Wait inside a workflow for a message on `WAKE`, `timeout_s` at most; the instant it ends at is durable."""
    DBOS.recv(WAKE, timeout_seconds=timeout_s)
