"""A process and all its descendants: their memory, and how to kill them."""

import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

PROCESSES = Path("/proc")
PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True, slots=True)
class Running:
    """A process by its id and start time, in the kernel's ticks, because ids are reused."""

    pid: int
    began: str

    @property
    def is_alive(self) -> bool:
        return _began(self.pid) == self.began

    @property
    def name(self) -> str:
        """What it calls itself, cut to 15 bytes by the kernel; empty once it has ended."""
        try:
            return (PROCESSES / str(self.pid) / "comm").read_text().strip()
        except OSError:
            return ""

    @property
    def memory_mb(self) -> float:
        """Its resident memory; 0 once it has ended."""
        try:
            return int((PROCESSES / str(self.pid) / "statm").read_text().split()[1]) * PAGE_BYTES / 2**20
        except (OSError, IndexError):
            return 0.0


def tree_of(pid: int) -> list[Running]:
    """The process and its running descendants, itself first; empty if it has ended or there is no /proc."""
    return [Running(one, began) for one in _pids(pid) if (began := _began(one))]


def kill(tree: list[Running]) -> None:
    """Send SIGKILL to those that still run."""
    for one in tree:
        if one.is_alive:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(one.pid, signal.SIGKILL)


def _pids(pid: int) -> Iterator[int]:
    yield pid
    try:
        threads = list((PROCESSES / str(pid) / "task").iterdir())
    except OSError:  # the process has ended, or there is no /proc
        return
    for thread in threads:
        try:
            children = (thread / "children").read_text().split()
        except OSError:  # this thread has ended
            continue
        for child in children:
            yield from _pids(int(child))


def _began(pid: int) -> str:
    """The start time of the process; empty if it does not exist or is a zombie."""
    try:
        fields = (PROCESSES / str(pid) / "stat").read_text().rsplit(")", 1)[1].split()
    except (OSError, IndexError):
        return ""
    return "" if fields[0] in "ZX" else fields[19]
