"""CPU time and memory of other processes, from Linux's clocks and /proc."""

import os
import subprocess
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile

from app.planning.pool.process_tree import tree_of

TICKS_A_S = os.sysconf("SC_CLK_TCK")
CPU_CLOCK = 2
"""Linux's number of a process's clock of user and system time, in the low bits of the clock's id."""


def cpu_s(pid: int) -> float:
    """CPU seconds of all threads of a running process so far, without its children; 0 once it has ended."""
    with suppress(OSError):
        return time.clock_gettime((~pid << 3) | CPU_CLOCK)
    return 0.0


def tree_cpu_s(pid: int) -> float:
    """CPU seconds of a process, its running descendants, and those that they have waited for."""
    return sum(_with_ended_children_s(one.pid) for one in tree_of(pid))


def _with_ended_children_s(pid: int) -> float:
    with suppress(OSError, IndexError):
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        return cpu_s(pid) + (int(fields[13]) + int(fields[14])) / TICKS_A_S
    return 0.0


def pss_mb(pids: Iterable[int]) -> float:
    """Proportional memory of processes: each shared page counts as a part in each process that maps it."""
    return sum(_pss_kb(pid) for pid in pids) / 1024


def _pss_kb(pid: int) -> int:
    with suppress(OSError):
        for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                return int(line.split()[1])
    return 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """What a command took, CPU of it and its descendants and wall-clock seconds, and its standard output."""

    cpu_s: float
    wall_s: float
    said: str


def environment(cache: Path | None = None, **variables: str) -> dict[str, str]:
    """This process's environment without settings of Macta, with a cache of compiled code of its own."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("MACTA_") and name != "VIRTUAL_ENV"
    }
    return kept | ({"XDG_CACHE_HOME": str(cache)} if cache else {}) | variables


def run(
    command: Sequence[str], *, environment: Mapping[str, str] | None = None, folder: Path | None = None
) -> Run:
    """Run a command to its end.

    :raises RuntimeError: if it fails; with the end of what it wrote to standard error.
    """
    begun_s = time.perf_counter()
    with TemporaryFile("w+") as complaints, TemporaryFile("w+") as output:
        process = subprocess.Popen(command, stdout=output, stderr=complaints, env=environment, cwd=folder)
        _, status, used = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - begun_s
        process.returncode = os.waitstatus_to_exitcode(status)
        complaints.seek(0)
        output.seek(0)
        if process.returncode:
            said = complaints.read()[-2000:]
            raise RuntimeError(f"{' '.join(command)} ended with {process.returncode}: {said}")
        return Run(cpu_s=used.ru_utime + used.ru_stime, wall_s=wall_s, said=output.read())
