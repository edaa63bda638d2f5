"""One planner on one problem, in a process of its own: its first and its best plan, wall and CPU time."""

import contextlib
import ctypes
import os
import signal
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.domains.catalogue import DOMAINS
from benchmarks.domains.judge import fault_of, quality_of
from benchmarks.domains.model import Form
from benchmarks.domains.planners import OURS, PLANNERS

START_S = 120.0
"""For imports and, where nothing is compiled yet, compilation; beyond the planner's own time."""
GRACE = 1.5
"""A planner is ended after so many times its limit, and a second."""
PR_SET_CHILD_SUBREAPER = 36
"""Linux: processes whose parent has ended become this process's children."""
LATEST = 1.1
"""Plans that come later than so many limits do not count."""
TICKS = os.sysconf("SC_CLK_TCK")
RUNNING = "running"


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """One run of a planner."""

    planner: str
    domain: str
    form: Form
    size: int
    seed: int
    limit_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """The result: seconds from the problem to the first plan, to the best, and to the end, and CPU seconds of all
    processes together. A plan counts if it is valid and not later than a tenth over the limit. `rejected`: how many
    plans were looked at and are not valid; `fault`: what is wrong with one of them."""

    task: Task
    status: str = RUNNING
    first_s: float | None = None
    first: float | None = None
    best_s: float | None = None
    best: float | None = None
    final_s: float | None = None
    cpu_s: float = 0.0
    fault: str | None = None
    rejected: int = 0

    @property
    def is_solved(self) -> bool:
        return self.best is not None


def measured(task: Task) -> Measure:
    """Carry out a task in a fresh process; what still runs after its limit is ended, its files are removed."""
    with TemporaryDirectory() as folder:
        return _measured(task, folder)


def _measured(task: Task, folder: str) -> Measure:
    context = get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_answer, args=(task, there, folder))
    process.start()
    there.close()
    measure = Measure(task=task)
    plans = []
    assert process.pid is not None
    try:
        if not here.poll(START_S):
            return replace(measure, status="not started")
        before_s = here.recv()
        deadline = time.monotonic() + GRACE * task.limit_s + 1.0
        while here.poll(max(0.0, deadline - time.monotonic())):
            elapsed_s, status, plan = here.recv()
            if plan is not None:
                plans.append((elapsed_s, plan))
            measure = replace(measure, status=status)
            if status != RUNNING:
                measure = replace(measure, final_s=elapsed_s)
                break
        measure = replace(measure, cpu_s=cpu_of(process.pid) - before_s)
    except EOFError:
        measure = replace(measure, status="died")
    finally:
        _end(process.pid)
        process.join()
    return _judged(measure, plans)


def _judged(measure: Measure, plans: list[tuple[float, Any]]) -> Measure:
    """With the first and the best valid plan of those that came in time."""
    task = measure.task
    good = [
        (elapsed_s, quality_of(plan), plan) for elapsed_s, plan in plans if elapsed_s <= LATEST * task.limit_s
    ]
    if not good:
        return measure
    problem = DOMAINS[task.domain](task.size, task.seed, task.form)
    faults: list[str] = []

    def valid(found: Iterable[tuple[float, float, Any]]) -> tuple[float, float] | None:
        for elapsed_s, quality, plan in found:
            fault = fault_of(problem, _of(problem, plan))
            if fault is None:
                return elapsed_s, quality
            faults.append(fault)
        return None

    first, best = valid(good), valid(sorted(good, key=lambda item: item[1]))
    if first is None or best is None:
        return replace(measure, fault=faults[0], rejected=len(good))
    return replace(
        measure,
        first_s=first[0],
        first=first[1],
        best_s=best[0],
        best=best[1],
        fault=faults[0] if faults else None,
        rejected=len(faults),
    )


def _of(problem: Any, plan: Any) -> Any:
    """The plan, which another process has made, as one of this process's problem."""
    objects = problem.environment.expression_manager.ObjectExp

    def own(instance: Any) -> Any:
        from unified_planning.plans import ActionInstance

        names = [part.object().name for part in instance.actual_parameters]
        return ActionInstance(
            problem.action(instance.action.name), tuple(objects(problem.object(name)) for name in names)
        )

    return plan.replace_action_instances(own)


def _answer(task: Task, there: Connection, folder: str) -> None:
    """In the process: send the CPU time of the start, then each plan as it comes, then how it ended.

    :param folder: the process's own, for some planners leave files where they run.
    """
    os.setsid()
    os.chdir(folder)
    ctypes.CDLL(None).prctl(
        PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0
    )  # what a driver leaves behind is ours to count
    from unified_planning.environment import get_environment

    get_environment().credits_stream = None
    planner = PLANNERS[task.planner].make()
    planner.skip_checks = True  # LPG takes the metric for the makespan, but does not say so
    if task.planner == OURS:
        small = DOMAINS[task.domain](2, 0, task.form)
        planner.solve(small, timeout=1.0)  # imports and, the first time, compiles
    problem = DOMAINS[task.domain](task.size, task.seed, task.form)
    there.send(cpu_of(os.getpid()))
    begun = time.perf_counter()
    last = "no answer"
    try:
        for result in planner.get_solutions(problem, timeout=task.limit_s):
            last = result.status.name.lower()
            there.send((time.perf_counter() - begun, RUNNING, result.plan))
    except Exception as error:
        last = f"{type(error).__name__}: {error}"
    elapsed_s = time.perf_counter() - begun
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    there.send((elapsed_s, last, None))
    with contextlib.suppress(EOFError):
        there.recv()  # what it used can be read until it is ended


def cpu_of(pid: int) -> float:
    """CPU seconds of a process and of all that it has started, ended or not."""
    total = 0
    children = _children()
    waiting = [pid]
    while waiting:
        one = waiting.pop()
        waiting += children.get(one, [])
        with contextlib.suppress(OSError):
            total += sum(int(word) for word in _stat(one)[11:15])
    return total / TICKS


def _stat(pid: int) -> list[str]:
    """The fields of a process after its name: state, parent, …"""
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()


def _children() -> dict[int, list[int]]:
    children: dict[int, list[int]] = {}
    for pid in _pids():
        with contextlib.suppress(OSError):
            children.setdefault(int(_stat(pid)[1]), []).append(pid)
    return children


def _pids() -> Iterator[int]:
    return (int(path.name) for path in Path("/proc").iterdir() if path.name.isdecimal())


def _end(pid: int) -> None:
    """End a process and all that it has started."""
    children = _children()
    waiting = [pid]
    while waiting:
        one = waiting.pop()
        waiting += children.get(one, [])
        with contextlib.suppress(ProcessLookupError):
            os.kill(one, signal.SIGKILL)
