"""The parts of a workflow: steps that are tried again, and waiting until it is woken.

Nothing of them is recorded: the service's own tables say how far a goal or mission is. A workflow that another process
takes over, or the next one, begins at its first step, and each step finds what has been done.
"""

import logging
import threading
from collections.abc import Callable
from contextvars import ContextVar
from typing import TypeVar

from app.store import is_unavailable

STEP_ATTEMPTS = 4
RETRY_S = 0.5
"""Pause before a step that has failed is tried again, doubled after each failure."""
UNAVAILABLE_RETRY_S = 0.5
"""Pause before a step that found the database unavailable is tried again."""

logger = logging.getLogger(__name__)
Result = TypeVar("Result")


class StepFailed(Exception):
    """Raised when a step has failed `STEP_ATTEMPTS` times; the message names it."""


class Interrupted(BaseException):
    """Ends a workflow's run in this process; the workflow itself stays pending.

    It is no `Exception`, so that nothing takes it for the failure of a step, or for the outcome of the workflow.
    """


class Run:
    """One run of a workflow in this process."""

    def __init__(self, workflow_id: str) -> None:
        self.workflow_id = workflow_id
        self._interrupted = threading.Event()
        self._woken = threading.Event()

    def wake(self) -> None:
        """End its sleep, or the next one if it does not sleep now."""
        self._woken.set()

    def interrupt(self) -> None:
        """End the run at its next pause or sleep."""
        self._interrupted.set()
        self._woken.set()

    def pause(self, timeout_s: float) -> None:
        """:raises Interrupted: if the run is to end."""
        if self._interrupted.wait(timeout_s):
            raise Interrupted

    def sleep(self, timeout_s: float) -> None:
        """Sleep until woken. :raises Interrupted: if the run is to end."""
        self._woken.wait(timeout_s)
        self._woken.clear()
        self.pause(0.0)


CURRENT_RUN: ContextVar[Run] = ContextVar("current_run")
"""The run that a workflow's thread carries out."""


def step(name: str, function: Callable[[], Result]) -> Result:
    """Run a step of the current workflow; it may run again after a crash, from its beginning.

    A step that fails is tried again after increasing pauses; while the database is unavailable, without limit.

    :raises StepFailed: if it failed `STEP_ATTEMPTS` times.
    """
    run = CURRENT_RUN.get()
    run.pause(0.0)
    failures = 0
    while True:
        try:
            return function()
        except Exception as error:
            if is_unavailable(error):
                logger.warning("step %r waits for the database: %s", name, error)
                pause_s = UNAVAILABLE_RETRY_S
            else:
                logger.exception("step %r failed", name)
                failures += 1
                if failures >= STEP_ATTEMPTS:
                    raise StepFailed(
                        f"step {name!r} failed {STEP_ATTEMPTS} times; the log says why"
                    ) from error
                pause_s = RETRY_S * 2 ** (failures - 1)
        run.pause(pause_s)


def or_give_up(work: Callable[[], None], give_up: Callable[[str], None]) -> None:
    """Run a workflow's steps; if one fails for good, run `give_up` with the reason as the last step."""
    try:
        work()
    except StepFailed as failure:
        reason = str(failure)
        step("give up", lambda: give_up(reason))


def current_workflow() -> str | None:
    """The id of the workflow that this thread carries out; None if it carries out none."""
    run = CURRENT_RUN.get(None)
    return None if run is None else run.workflow_id


def sleep_until_woken(timeout_s: float) -> None:
    """Wait inside a workflow until it is woken, `timeout_s` at most. A wake since the last wait ends it at once."""
    CURRENT_RUN.get().sleep(timeout_s)
