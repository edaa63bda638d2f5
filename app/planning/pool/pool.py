"""The pool of planning processes: kept warm to avoid imports, several so that a long problem does not block short ones.

One is started with the service, the others when work finds none free. As long as the planner is not compiled, they run
it as Python and do small work only; once it is, compiled ones replace them.
"""

import logging
import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial

from app.background_compilation import BackgroundCompilation, Stage
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Unavailable
from app.planning.pool.process import (
    CANCELLED,
    GRACE_S,
    MEMORY_MB,
    POLL_S,
    MakeEngine,
    PlanningProcess,
    ProcessDied,
    Tell,
    Watch,
)
from app.planning.pool.status import PoolStatus, ProcessState, ProcessStatus, waiting_jobs
from app.planning.pool.waiting_line import Job, Priority, Ticket, WaitingLine
from app.planning.pool.work import PLANNER, Answer, Work, WorkResult
from planner import PlanningStatus

logger = logging.getLogger(__name__)

ATTEMPTS = 2
"""Attempts at work whose process ends unexpectedly, and at starting a process that ends at its start."""
LONG_S = 3.0
"""Work that takes longer no longer counts against the number of processes: small work gets another one."""
IN_TURN_S = 0.25
"""Longest wait for other work of the world whose result binds. Short work is done in turn: two goals planned at
the same time often take the same robots, and one of them is planned again. Long work is worth the attempt."""
RENEWED_AFTER_S = 1.0
"""Work that has waited longer is renewed though no result has bound its world meanwhile: there may be reports."""

COMPILATION_S = 120.0
"""Large work waits no longer for the compiler: on a machine so busy a worse plan is better than none."""

FREE_PROCESS = "a free planning process"
LARGE_WORK = "the end of other large planning work"
COMPILATION = "the compilation of the planner, as it is a large problem"


class WorkerClosed(Exception):
    """Raised when the worker is closed before work has a result."""


@dataclass(slots=True, kw_only=True, eq=False)
class _Member:
    """A process of the pool.

    :param since_s: when it began the present job.
    """

    process: PlanningProcess
    is_compiled: bool
    is_ready: bool = False
    job: Job | None = None
    since_s: float = 0.0


def _ignore(_: object) -> None:
    """Conclude nothing."""


class PlanningWorker:
    """Does work in warm processes, each replaced when it ends or hangs. Thread-safe; work waits for a free process.

    At most `processes` work at the same time, large work in all but one of them, if there are several. While work takes
    long, up to as many more are started for small work, and end after it.
    """

    def __init__(
        self,
        make_engine: MakeEngine,
        *,
        processes: int = 1,
        memory_mb: float = MEMORY_MB,
        grace_s: float = GRACE_S,
        tell: Tell = logger.info,
        compilation: BackgroundCompilation | None = None,
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param make_engine: picklable; builds the warm engine inside a process.
        :param processes: the usual maximum; if 0, one is started with the first work, such as a plan to explain.
        :param memory_mb: limit of a process's memory beyond that after warm-up, native engines included.
        :param grace_s: a process is ended when its work exceeds its time limit by this.
        :param tell: called with messages about the start of processes, where it takes time.
        :param compilation: of the planner; if None, each process compiles what is not compiled, or waits for it.
        """
        self.doing = "loading"
        """The newest message about the start of a process."""
        self._tell = tell
        self._start_process = partial(
            PlanningProcess, make_engine, memory_mb=memory_mb, grace_s=grace_s, clock=clock
        )
        self._count = processes
        self._compilation = compilation
        self._clock = clock
        self._lock = threading.Lock()
        self._members: list[_Member] = []
        self._line: WaitingLine[_Member] = WaitingLine()
        self._recording = Counter[str]()
        """By world, the results that bind and are being recorded."""
        self._bound = Counter[str]()
        """By world, the results recorded that bind."""
        self._ready: Future[bool] = Future()
        self._started = False
        self._closed = False
        self._failed_starts = 0
        if compilation is not None:
            compilation.when_changed(self._adapt_to_compilation)

    @property
    def pids(self) -> list[int]:
        """The processes' ids."""
        with self._lock:
            return [one.process.pid for one in self._members if one.process.pid is not None]

    @property
    def free_count(self) -> int:
        """The number of processes that are warm and without work."""
        with self._lock:
            return len(self._free())

    def status(self) -> PoolStatus:
        """The processes, and the work that waits for one."""
        with self._lock:
            members = list(self._members)
            waiting = waiting_jobs(self._line.counts(), self._why_waiting)
        return PoolStatus(compilation=self._stage(), processes=tuple(map(_status, members)), waiting=waiting)

    def warm_up(self) -> "Future[bool]":
        """Start the first process; the future is done once it can plan, and raises Unavailable if it does not start."""
        with self._lock:
            was_started = self._started
            self._started = True
        if not was_started:
            if self._count:
                self._add()
            else:
                self._report(None)
        return self._ready

    def do(
        self,
        work: Work[Answer],
        time_limit_s: float,
        watch: Watch | None = None,
        job: Job | None = None,
        *,
        renew: Callable[[], Work[Answer]] | None = None,
        conclude: Callable[[WorkResult[Answer]], None] = _ignore,
    ) -> WorkResult[Answer]:
        """Do the work in a process; if the process ends unexpectedly or hangs, that is a result, too.

        The time limit begins when a process begins the work.

        :param job: decides which work is next.
        :param renew: if the work has waited for a process, called for what to do instead if the world may have changed.
        :param conclude: called with the result, before other work of its world begins if the result binds.
        :raises WorkerClosed: if the worker is closed before there is a result.
        """
        self.warm_up()
        with self._lock:
            needs_first = self._count == 0
            self._count = max(self._count, 1)
        if needs_first:
            self._add()
        watch = watch or Watch()
        job = job or Job()
        cause = ""
        attempts = ATTEMPTS
        spare = self._count
        while attempts:
            ticket = self._turn(job, watch)
            member = ticket.member
            if member is None:
                cancelled: WorkResult[Answer] = WorkResult(status=PlanningStatus.NOT_FOUND, reason=CANCELLED)
                conclude(cancelled)
                return cancelled
            result: WorkResult[Answer] | None = None
            try:
                if renew is not None and self._is_outdated(ticket):
                    work = renew()
                result = member.process.do(work, time_limit_s, watch)
            except ProcessDied as death:
                if self._closed:
                    raise WorkerClosed from death
                cause = str(death)
                if member.process.is_idle and spare:
                    spare -= 1
                else:
                    attempts -= 1
            finally:
                self._give_back(member, recorded=None if result is None else job)
            if result is not None:
                self._record(job, result, conclude)
                return result
        failed: WorkResult[Answer] = WorkResult(
            status=PlanningStatus.FAILED, reason=f"the planning process ended unexpectedly ({cause})"
        )
        conclude(failed)
        return failed

    def close(self) -> None:
        """End the processes; callers of `do` that wait for a result get WorkerClosed."""
        with self._lock:
            self._closed = True
            members = list(self._members)
            self._members.clear()
        for member in members:
            member.process.end()

    def _turn(self, job: Job, watch: Watch) -> Ticket[_Member]:
        """Wait for a process; the ticket is without one if the work is cancelled first."""
        with self._lock:
            bound = self._bound[job.world]
            ticket: Ticket[_Member] = Ticket(job, since_s=self._clock.monotonic_s(), bound_before=bound)
            self._line.join(ticket)
            self._assign()
            ticket.has_waited = ticket.member is None
        try:
            while not self._clock.wait(ticket.called, POLL_S):
                if self._closed:
                    raise WorkerClosed
                if watch.is_cancelled():
                    break
                watch.waits_for(self._why_waiting(job))
                with self._lock:
                    self._assign()
                self._add_if_all_are_busy()
        finally:
            with self._lock:
                self._line.leave(ticket)
        return ticket

    def _record(
        self, job: Job, result: WorkResult[Answer], conclude: Callable[[WorkResult[Answer]], None]
    ) -> None:
        """Have a result recorded; if it binds, work of its world that has waited for that may begin then."""
        try:
            conclude(result)
        finally:
            with self._lock:
                self._recording[job.world] -= job.binds
                self._bound[job.world] += job.binds
                self._assign()

    def _is_outdated(self, ticket: Ticket[_Member]) -> bool:
        """Whether the world may have changed while the work has waited for a process."""
        waited_s = self._clock.monotonic_s() - ticket.since_s
        has_bound = self._bound[ticket.job.world] > ticket.bound_before
        return ticket.has_waited and (has_bound or waited_s > RENEWED_AFTER_S)

    def _assign(self) -> None:
        """Give waiting work to free processes. Call with the lock."""
        for member in self._free():
            if ticket := self._line.next(partial(self._may_begin, is_compiled=member.is_compiled)):
                member.job = ticket.job
                member.since_s = self._clock.monotonic_s()
                ticket.call(member)

    def _may_begin(self, ticket: Ticket[_Member], *, is_compiled: bool) -> bool:
        """Whether a process, compiled or not, may do the work now."""
        if self._has_its_turn_later(ticket):
            return False
        is_able = is_compiled or not self._waits_for_compilation(ticket)
        return not ticket.job.is_large or (is_able and self._has_room_for_large())

    def _has_its_turn_later(self, ticket: Ticket[_Member]) -> bool:
        """Whether it is to be planned with the result of other work; repairs, for which robots wait, never are."""
        job = ticket.job
        if job.priority is Priority.RECOVERY or self._clock.monotonic_s() >= ticket.since_s + IN_TURN_S:
            return False
        jobs = [one.job for one in self._members if one.job is not None]
        is_binding_done = any(one.binds and one.world == job.world for one in jobs)
        return self._recording[job.world] > 0 or (job.binds and is_binding_done)

    def _waits_for_compilation(self, ticket: Ticket[_Member]) -> bool:
        is_patient = self._clock.monotonic_s() < ticket.since_s + COMPILATION_S
        return ticket.job.is_large and is_patient and self._stage() is not Stage.UNCOMPILED

    def _has_room_for_large(self) -> bool:
        large = sum(1 for one in self._members if one.job is not None and one.job.is_large)
        return large < max(1, self._count - 1)

    def _compiles(self) -> bool:
        """True until the planner is compiled; False if it will not be."""
        return self._stage() in (Stage.COMPILING, Stage.WAITING)

    def _stage(self) -> Stage:
        return Stage.COMPILED if self._compilation is None else self._compilation.stage_of(PLANNER.name)

    def _why_waiting(self, job: Job) -> str:
        if job.is_large and self._compiles():
            return COMPILATION
        return LARGE_WORK if job.is_large and not self._has_room_for_large() else FREE_PROCESS

    def _free(self) -> list[_Member]:
        return [one for one in self._members if one.is_ready and one.job is None]

    def _limit(self) -> int:
        """How many processes there may be now."""
        now_s = self._clock.monotonic_s()
        jobs = [(one.job, now_s - one.since_s) for one in self._members if one.job is not None]
        long = sum(1 for job, took_s in jobs if job.is_large or took_s > LONG_S)
        return self._count + min(self._count, long)

    def _add_if_all_are_busy(self) -> None:
        with self._lock:
            is_compiled = self._stage() is Stage.COMPILED
            is_wanted = self._line.any(partial(self._may_begin, is_compiled=is_compiled))
            all_are_busy = all(one.job is not None for one in self._members)
            may_add = is_wanted and all_are_busy and len(self._members) < self._limit()
        if may_add:
            self._add()

    def _give_back(self, member: _Member, *, recorded: Job | None = None) -> None:
        """
        :param recorded: the job whose result is recorded from now on; None if there is no result.
        """
        with self._lock:
            member.job = None
            if recorded is not None:
                self._recording[recorded.world] += recorded.binds
            is_replaced = not member.process.is_alive
            outdated = [one for one in self._members if not one.is_compiled and self._has_compiled()]
            lasting = sum(1 for one in self._members if one.is_ready and one not in outdated)
            is_surplus = not is_replaced and (member in outdated or lasting > self._limit())
            if (is_replaced or is_surplus) and member in self._members:
                self._members.remove(member)
            self._assign()
        if is_surplus:
            member.process.end()
        elif is_replaced:
            self._add()

    def _add(self) -> None:
        """Start one more process, free once it is warm."""
        with self._lock:
            if self._closed:
                return
            is_compiled = self._stage() is Stage.COMPILED
            member = _Member(process=self._start_process(is_compiled=is_compiled), is_compiled=is_compiled)
            self._members.append(member)
        threading.Thread(target=self._take_in, args=(member,), daemon=True).start()

    def _take_in(self, member: _Member) -> None:
        """Make the process available once it is warm."""
        try:
            member.process.wait_until_ready(self._is_told)
        except ProcessDied as death:
            if self._may_try_another():
                self._give_back(member)
                return
            # NOTE: made available nevertheless, so that a waiting caller gets the error and does not wait for ever.
            self._report(Unavailable(f"the planning process does not start ({death}); the log says why"))
        else:
            self._failed_starts = 0
            self._report(None)
        with self._lock:
            member.is_ready = True
            replaced = self._without_uncompiled() if member.is_compiled else []
            self._assign()
        for one in replaced:
            one.process.end()

    def _adapt_to_compilation(self) -> None:
        """Start a compiled process once the planner is compiled; it replaces the uncompiled ones when it is warm."""
        with self._lock:
            is_wanted = (
                bool(self._members)
                and not any(one.is_compiled for one in self._members)
                and self._stage() is Stage.COMPILED
            )
            self._assign()
        if is_wanted:
            self._add()

    def _has_compiled(self) -> bool:
        return any(one.is_compiled and one.is_ready for one in self._members)

    def _without_uncompiled(self) -> list[_Member]:
        """Take the free uncompiled processes out of the pool. Call with the lock."""
        found = [one for one in self._free() if not one.is_compiled]
        self._members = [one for one in self._members if one not in found]
        return found

    def _is_told(self, doing: str) -> None:
        self.doing = doing
        self._tell(doing)

    def _may_try_another(self) -> bool:
        """Count a failed start; True if another is to be tried: the cause may be temporary, e.g. a lack of memory."""
        with self._lock:
            self._failed_starts += 1
            return self._failed_starts < ATTEMPTS

    def _report(self, failure: Exception | None) -> None:
        with self._lock:
            if self._ready.done():
                return
            if failure is None:
                self._ready.set_result(True)
            else:
                self._ready.set_exception(failure)


def _status(member: _Member) -> ProcessStatus:
    state = ProcessState.STARTING
    if member.is_ready:
        state = ProcessState.FREE if member.job is None else ProcessState.BUSY
    return ProcessStatus(
        pid=member.process.pid or 0,
        compiled=member.is_compiled,
        state=state,
        memory_mb=round(member.process.memory_mb()),
        world="" if member.job is None else member.job.world,
        priority="" if member.job is None else member.job.priority.name.lower(),
    )
