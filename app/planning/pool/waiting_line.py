"""Who is next when a planning process is free: by priority, then world by world in turn, then by arrival."""

import threading
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Generic, TypeVar

SMALL_GOALS = 8
"""A problem of at most this number of goals is small. Uncompiled it takes seconds, and its plan is at most a tenth
longer; with more goals the plan is longer by more than the compilation takes."""
SMALL_EFFORT_S = 10.0
"""… unless the request asks for a longer search."""


class Priority(IntEnum):
    """What is planned first."""

    RECOVERY = 1
    """The repair of a running mission's plan."""
    GOAL = 2
    """The plan of a goal."""
    EXPLANATION = 3
    """The costs in the explanation of a plan, which a request waits for."""
    ALTERNATIVES = 4
    """Alternatives to a plan that there is already."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """What the line needs to know of work.

    :param is_large: whether it may take long.
    :param binds: whether its result may reserve what other work of its world would use, without anybody's decision.
    """

    world: str = ""
    priority: Priority = Priority.GOAL
    is_large: bool = False
    binds: bool = False


def is_large(*, goals: int, effort_s: float | None) -> bool:
    """True if planning may take long.

    :param goals: their number.
    :param effort_s: as requested; None leaves it to the engine.
    """
    return goals > SMALL_GOALS or (effort_s or 0.0) > SMALL_EFFORT_S


Member = TypeVar("Member")


class Ticket(Generic[Member]):
    """A job's place in the line. Once `called` is set, `member` does the job."""

    def __init__(self, job: Job, *, since_s: float = 0.0, bound_before: int = 0) -> None:
        """
        :param since_s: when it joined the line, monotonic.
        :param bound_before: how many results of its world that bind were recorded by then.
        """
        self.job = job
        self.since_s = since_s
        self.bound_before = bound_before
        self.called = threading.Event()
        self.member: Member | None = None
        self.has_waited = False

    def call(self, member: Member) -> None:
        self.member = member
        self.called.set()


class WaitingLine(Generic[Member]):
    """The jobs that wait for a planning process. Not thread-safe."""

    def __init__(self) -> None:
        self._tickets: list[Ticket[Member]] = []
        self._turns: dict[str, int] = {}
        self._turn = 0

    def join(self, ticket: Ticket[Member]) -> None:
        self._tickets.append(ticket)

    def leave(self, ticket: Ticket[Member]) -> None:
        """Give the place up; safe to call again."""
        if ticket in self._tickets:
            self._tickets.remove(ticket)

    def next(self, may_begin: Callable[[Ticket[Member]], bool]) -> Ticket[Member] | None:
        """Take the next job out of the line: of the highest priority, of the world whose last turn is longest ago.

        :param may_begin: the jobs that come into question.
        """
        waiting = [ticket for ticket in self._tickets if may_begin(ticket)]
        if not waiting:
            return None
        found = min(waiting, key=lambda ticket: (ticket.job.priority, self._turns.get(ticket.job.world, 0)))
        self._tickets.remove(found)
        self._turn += 1
        self._turns[found.job.world] = self._turn
        return found

    def any(self, may_begin: Callable[[Ticket[Member]], bool]) -> bool:
        """True if a job waits that comes into question."""
        return any(may_begin(ticket) for ticket in self._tickets)

    def counts(self) -> Mapping[Job, int]:
        """How many jobs of each kind wait, whether or not they bind."""
        return Counter(replace(ticket.job, binds=False) for ticket in self._tickets)
