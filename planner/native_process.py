"""Runs native planners as separate processes, limited in time and memory and ended as a group.

The licences of several planners forbid linking, and all of them sometimes overrun their limits.
"""

import math
import os
import signal
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from planner.problem.timer import Clock, Timer

POLL_S = 0.1
"""Interval at which a running process is polled."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessEnd:
    """How a process ended; `code` is None if we ended it, at the deadline or once `is_enough()`."""

    code: int | None
    output: str


class Limits(Timer):
    """What a process may use: time from now on, and memory."""

    def __init__(self, limit_s: float, clock: Clock = time.monotonic, *, memory_mb: int = 2048) -> None:
        super().__init__(limit_s, clock)
        self.memory_mb = memory_mb


def never() -> bool:
    return False


def run(
    command: Sequence[str],
    *,
    folder: Path,
    limits: Limits,
    stdin: Path | None = None,
    environment: Mapping[str, str] | None = None,
    is_enough: Callable[[], bool] = never,
) -> ProcessEnd:
    """Run a command in a folder until it ends, its time is over, or `is_enough()`.

    :param environment: beside our own environment.
    :param is_enough: called several times a second.
    """
    with open(stdin or os.devnull, "rb") as source:
        process = subprocess.Popen(
            _limited(command, limits),
            cwd=folder,
            env={**os.environ, **(environment or {})},
            stdin=source,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        while not limits.is_over:
            try:
                output, _ = process.communicate(timeout=max(0.01, min(POLL_S, limits.left_s)))
                return ProcessEnd(code=process.returncode, output=output.decode(errors="replace"))
            except subprocess.TimeoutExpired as still_running:
                if is_enough():
                    return ProcessEnd(
                        code=None, output=(still_running.output or b"").decode(errors="replace")
                    )
        return ProcessEnd(code=None, output="")
    finally:
        _end(process)


def _limited(command: Sequence[str], limits: Limits) -> list[str]:
    """The command under a shell that sets its limits.

    Setting them between fork and exec is not safe in a process with threads. The limit on processor time ends
    what is left should we ourselves be killed.
    """
    cpu_s = math.ceil(max(1.0, limits.left_s)) * (os.cpu_count() or 1)
    script = f'ulimit -v {limits.memory_mb * 1024} 2>/dev/null; ulimit -t {cpu_s} 2>/dev/null; exec "$@"'
    return ["/bin/sh", "-c", script, "sh", *command]


def _end(process: "subprocess.Popen[bytes]") -> None:
    """End whatever of the process group still runs: a process that ended may have left others."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    if process.returncode is None:
        process.communicate()
