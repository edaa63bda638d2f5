"""What the pool of planning processes is doing, for operators."""

from collections.abc import Callable, Mapping
from enum import StrEnum

from pydantic import BaseModel

from app.background_compilation import Stage
from app.planning.pool.waiting_line import Job


class ProcessState(StrEnum):
    """The state of a planning process."""

    STARTING = "starting"
    """It loads the planner."""
    FREE = "free"
    """It is warm and without work."""
    BUSY = "busy"
    """It does work."""


class ProcessStatus(BaseModel):
    """A planning process; `memory_mb` includes native engines, `world` and `priority` are those of its work."""

    pid: int
    compiled: bool
    state: ProcessState
    memory_mb: int
    world: str = ""
    priority: str = ""


class WaitingStatus(BaseModel):
    """Work that waits, counted by world, priority and size."""

    world: str
    priority: str
    large: bool
    count: int
    waits_for: str


class PoolStatus(BaseModel):
    """The planning processes of one process of the service, and the work that waits for one of them.

    `compilation` is the stage of the planner's compilation on its machine.
    """

    compilation: Stage
    processes: tuple[ProcessStatus, ...] = ()
    waiting: tuple[WaitingStatus, ...] = ()


def waiting_jobs(counts: Mapping[Job, int], why: Callable[[Job], str]) -> tuple[WaitingStatus, ...]:
    """The waiting work, what is planned first before the rest."""
    ordered = sorted(counts.items(), key=lambda one: (one[0].priority, one[0].world, one[0].is_large))
    return tuple(
        WaitingStatus(
            world=job.world,
            priority=job.priority.name.lower(),
            large=job.is_large,
            count=count,
            waits_for=why(job),
        )
        for job, count in ordered
    )
