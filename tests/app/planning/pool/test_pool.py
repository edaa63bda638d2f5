"""The planning processes: warm, watched, ended at any time, replaced when they die."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

from app.background_compilation import BackgroundCompilation, Stage
from app.domain.errors import Unavailable
from app.planning.pool.pool import IN_TURN_S, RENEWED_AFTER_S, PlanningWorker, WorkerClosed
from app.planning.pool.process import POLL_S, TERMINATE_S, Watch
from app.planning.pool.waiting_line import Job, Priority
from app.planning.pool.work import PLANNER, PlanWork, Solutions, WorkResult
from planner import PlanningRequest, PlanningStatus, Progress
from tests.app.planning.fake_engine import make_fake_engine, make_no_engine, problem
from tests.app.stepped_clock import HeldClock, SteppedClock
from tests.waiting import until

PATIENCE_S = 60.0
LARGE = Job(is_large=True)


class Watching(Watch):
    """Sees progress; stops or cancels once told to."""

    def __init__(self) -> None:
        self.seen: list[Progress] = []
        self.waited_for: set[str] = set()
        self.stop, self.cancel = threading.Event(), threading.Event()

    def waits_for(self, what: str) -> None:
        self.waited_for.add(what)

    def progress(self, progress: Progress) -> None:
        self.seen.append(progress)

    def should_stop(self) -> bool:
        return self.stop.is_set()

    def is_cancelled(self) -> bool:
        return self.cancel.is_set()


def plan(
    worker: PlanningWorker,
    deed: str,
    *words: str,
    watch: Watch | None = None,
    time_limit_s: float = 120.0,
    job: Job | None = None,
) -> WorkResult[Solutions]:
    """What comes of a problem that has the fake engine do the deed."""
    work = PlanWork(problem=problem(deed, *words), request=PlanningRequest(time_limit_s=time_limit_s))
    return worker.do(work, time_limit_s, watch, job)


def gone(pid: int) -> bool:
    """True once the process has ended (a killed one may be nobody's for a moment)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


@pytest.fixture(scope="module")
def worker() -> Iterator[PlanningWorker]:
    worker = PlanningWorker(make_fake_engine, processes=2)
    worker.warm_up().result(timeout=PATIENCE_S)
    start_second(worker)
    yield worker
    worker.close()


def start_second(worker: PlanningWorker) -> None:
    """Have work find no process free."""
    watch = Watching()
    with ThreadPoolExecutor(1) as thread:
        planning = thread.submit(plan, worker, "improve", watch=watch)
        until(lambda: bool(watch.seen))
        assert plan(worker, "answer").answer
        watch.stop.set()
        planning.result(PATIENCE_S)


@pytest.fixture(scope="module")
def threads() -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(4) as threads:
        yield threads


def test_a_second_process_is_started_once_work_finds_none_free() -> None:
    worker = PlanningWorker(make_fake_engine, processes=2)
    worker.warm_up().result(timeout=PATIENCE_S)
    for _ in range(2):
        assert plan(worker, "answer").answer
    assert len(worker.pids) == 1
    start_second(worker)
    assert len(worker.pids) == 2
    worker.close()


@dataclass
class Line:
    """Two processes, and what is told of the work that they do."""

    worker: PlanningWorker
    clock: HeldClock
    threads: ThreadPoolExecutor
    told: list[str] = field(default_factory=list)
    records: threading.Event = field(default_factory=threading.Event)
    """Clear while no result can be recorded."""

    def do(self, name: str, deed: str, job: Job, watch: Watch | None = None) -> Future[object]:
        """Begin the deed; when it is renewed, it is an answer."""
        request = PlanningRequest(time_limit_s=120.0)

        def renew() -> PlanWork:
            self.told.append(f"{name} is renewed")
            return PlanWork(problem=problem("answer"), request=request)

        def conclude(result: WorkResult[Solutions]) -> None:
            assert self.records.wait(PATIENCE_S)
            self.told.append(f"{name}: {result.status.value}")

        work = PlanWork(problem=problem(deed), request=request)
        return self.threads.submit(self.worker.do, work, 120.0, watch, job, renew=renew, conclude=conclude)

    def busy(self, job: Job) -> tuple[Future[object], Watching]:
        """A process has begun such a job, `first`, and goes on until its watch stops it."""
        watch = Watching()
        future = self.do("first", "improve", job, watch)
        until(lambda: bool(watch.seen))
        return future, watch


@pytest.fixture
def line(threads: ThreadPoolExecutor) -> Iterator[Line]:
    clock = HeldClock()
    worker = PlanningWorker(make_fake_engine, processes=2, clock=clock)
    worker.warm_up().result(timeout=PATIENCE_S)
    start_second(worker)
    line = Line(worker, clock, threads)
    line.records.set()
    yield line
    line.records.set()
    worker.close()


BINDING = Job(world="store", binds=True)


def test_a_result_that_binds_is_recorded_before_the_next_such_work_of_its_world_begins_renewed(
    line: Line,
) -> None:
    first, watch = line.busy(BINDING)
    waiting = Watching()
    second = line.do("second", "die", BINDING, waiting)
    until(lambda: bool(waiting.waited_for))
    assert line.worker.free_count == 1, "it waits for the result, not for a process"
    elsewhere = line.do("elsewhere", "answer", replace(BINDING, world="yard"))
    beside = line.do("beside", "answer", Job(world="store"))
    for one in (elsewhere, beside):
        one.result(PATIENCE_S)
    watch.stop.set()
    for one in (first, second):
        one.result(PATIENCE_S)
    assert sorted(line.told[:2]) == ["beside: solved", "elsewhere: solved"]
    assert line.told[2:] == ["first: solved", "second is renewed", "second: solved"]


def test_while_a_result_that_binds_is_recorded_only_other_worlds_are_planned(line: Line) -> None:
    line.records.clear()
    watch, waiting = Watching(), Watching()
    first = line.do("first", "answer", BINDING, watch)
    until(lambda: line.worker.free_count == 2)
    beside = line.do("beside", "die", Job(world="store"), waiting)
    until(lambda: bool(waiting.waited_for))
    elsewhere = line.do("elsewhere", "answer", Job(world="yard"))
    line.records.set()
    for one in (first, beside, elsewhere):
        one.result(PATIENCE_S)
    assert "elsewhere is renewed" not in line.told
    assert [one for one in line.told if "elsewhere" not in one] == [
        "first: solved",
        "beside is renewed",
        "beside: solved",
    ]


def test_a_repair_does_not_wait_for_a_goals_plan(line: Line) -> None:
    first, watch = line.busy(BINDING)
    line.do("repair", "answer", replace(BINDING, priority=Priority.RECOVERY)).result(PATIENCE_S)
    assert line.told == ["repair: solved"]
    watch.stop.set()
    first.result(PATIENCE_S)


def test_what_takes_long_is_planned_beside_other_work_of_its_world(line: Line) -> None:
    first, watch = line.busy(BINDING)
    waiting = Watching()
    second = line.do("second", "answer", BINDING, waiting)
    until(lambda: bool(waiting.waited_for))
    line.clock.now_s += IN_TURN_S
    second.result(PATIENCE_S)
    assert line.told == ["second: solved"], "nothing has bound the world meanwhile"
    watch.stop.set()
    first.result(PATIENCE_S)


def test_work_that_has_waited_long_for_a_process_is_renewed(line: Line) -> None:
    first, watch = line.busy(Job(world="yard"))
    second, other = line.busy(Job(world="yard"))
    waiting = Watching()
    third = line.do("third", "die", Job(world="store"), waiting)
    until(lambda: bool(waiting.waited_for))
    line.clock.now_s += RENEWED_AFTER_S + 0.1
    for one in (watch, other):
        one.stop.set()
    for each in (first, second, third):
        each.result(PATIENCE_S)
    assert [one for one in line.told if "third" in one] == ["third is renewed", "third: solved"]


def test_progress_is_reported_and_a_stop_returns_the_best_plan(
    worker: PlanningWorker, threads: ThreadPoolExecutor
) -> None:
    watch = Watching()
    planning = threads.submit(plan, worker, "improve", watch=watch)
    until(lambda: len(watch.seen) >= 2)
    watch.stop.set()
    assert planning.result(PATIENCE_S).status is PlanningStatus.SOLVED
    spans = [progress.makespan_s or 0.0 for progress in watch.seen]
    assert spans == sorted(spans, reverse=True)
    # More often improved than told: the newest is told, at a bounded rate.
    assert spans[0] - spans[-1] > len(spans)


def test_a_stop_does_not_end_the_next_problem(worker: PlanningWorker) -> None:
    class StopAtOnce(Watch):
        def should_stop(self) -> bool:
            return True

    for _ in range(3):
        assert plan(worker, "answer", watch=StopAtOnce()).answer

    class StopOnceThereIsProgress(Watching):
        def should_stop(self) -> bool:
            return bool(self.seen)

    watch = StopOnceThereIsProgress()
    plan(worker, "improve", watch=watch)
    assert watch.seen


def test_cancelling_ends_the_work_and_all_it_started(
    worker: PlanningWorker, threads: ThreadPoolExecutor, tmp_path: Path
) -> None:
    watch, file = Watching(), tmp_path / "pid"
    planning = threads.submit(plan, worker, "run_a_child", str(file), watch=watch)
    until(file.is_file)
    watch.cancel.set()
    assert "cancelled" in planning.result(PATIENCE_S).reason
    until(lambda: gone(int(file.read_text())))
    assert plan(worker, "answer").answer


def test_cancelling_an_engine_that_never_returns_takes_less_than_a_second(
    worker: PlanningWorker, threads: ThreadPoolExecutor, tmp_path: Path
) -> None:
    watch, file = Watching(), tmp_path / "pid"
    planning = threads.submit(plan, worker, "hang_deaf", str(file), watch=watch)
    until(file.is_file)
    assert POLL_S + TERMINATE_S < 1.0  # what it may take by design; the machine's load comes on top
    watch.cancel.set()
    assert "cancelled" in planning.result(PATIENCE_S).reason
    until(lambda: gone(int(file.read_text())))


@pytest.mark.parametrize("deed", ["eat", "have_a_child_eat"])
def test_an_engine_that_takes_too_much_memory_is_ended_with_that_reason(deed: str) -> None:
    greedy = PlanningWorker(make_fake_engine, memory_mb=200)
    greedy.warm_up().result(timeout=PATIENCE_S)
    (before,) = greedy.pids
    result = plan(greedy, deed)
    assert result.status is PlanningStatus.OUT_OF_MEMORY
    assert "more than 200 MB" in result.reason
    assert gone(before)
    assert plan(greedy, "answer").answer
    greedy.close()


def test_a_long_problem_blocks_no_short_one(worker: PlanningWorker, threads: ThreadPoolExecutor) -> None:
    watch = Watching()
    until(lambda: len(worker.pids) == 2)
    planning = threads.submit(plan, worker, "improve", watch=watch)
    until(lambda: bool(watch.seen))
    assert plan(worker, "answer").answer
    assert not planning.done()
    watch.stop.set()
    planning.result(PATIENCE_S)


def test_large_problems_leave_a_process_to_small_ones(
    worker: PlanningWorker, threads: ThreadPoolExecutor
) -> None:
    first, second = Watching(), Watching()
    planning = [threads.submit(plan, worker, "improve", watch=first, job=LARGE)]
    until(lambda: bool(first.seen))
    planning.append(threads.submit(plan, worker, "improve", watch=second, job=LARGE))
    until(lambda: second.waited_for == {"the end of other large planning work"})
    assert plan(worker, "answer").answer
    assert not second.seen
    for watch in (first, second):
        watch.stop.set()
    assert all(one.result(PATIENCE_S).answer for one in planning)


def test_a_pool_of_one_starts_a_second_process_for_small_work_beside_large_work(
    threads: ThreadPoolExecutor,
) -> None:
    worker = PlanningWorker(make_fake_engine, processes=1)
    watch = Watching()
    planning = threads.submit(plan, worker, "improve", watch=watch, job=LARGE)
    until(lambda: bool(watch.seen))
    assert plan(worker, "answer").answer
    assert len(worker.pids) == 2
    watch.stop.set()
    planning.result(PATIENCE_S)
    until(lambda: len(worker.pids) == 1)
    assert plan(worker, "answer").answer
    worker.close()


class Compiling(BackgroundCompilation):
    """Compiles nothing; the test says when a stage is reached."""

    def __init__(self) -> None:
        self.now = Stage.COMPILING
        self.callbacks: list[Callable[[], None]] = []

    def stage_of(self, name: str) -> Stage:
        assert name == PLANNER.name
        return self.now

    def when_changed(self, callback: Callable[[], None]) -> None:
        self.callbacks.append(callback)

    def reach(self, stage: Stage) -> None:
        self.now = stage
        for callback in self.callbacks:
            callback()


def test_until_the_planner_is_compiled_small_problems_are_planned_and_large_ones_wait(
    threads: ThreadPoolExecutor,
) -> None:
    compilation = Compiling()
    worker = PlanningWorker(make_fake_engine, processes=2, compilation=compilation)
    assert plan(worker, "is_uncompiled").answer
    watch = Watching()
    large = threads.submit(plan, worker, "is_compiled", watch=watch, job=replace(LARGE, world="store"))
    until(lambda: bool(watch.waited_for))
    assert watch.waited_for == {"the compilation of the planner, as it is a large problem"}
    assert plan(worker, "is_uncompiled").answer
    status = worker.status()
    assert status.compilation is Stage.COMPILING
    assert [one.compiled for one in status.processes] == [False]
    (waiting,) = status.waiting
    assert (waiting.world, waiting.priority, waiting.large, waiting.count) == ("store", "goal", True, 1)
    assert waiting.waits_for in watch.waited_for
    compilation.reach(Stage.COMPILED)
    assert large.result(PATIENCE_S).answer
    until(lambda: [one.compiled for one in worker.status().processes] == [True])
    assert plan(worker, "is_compiled").answer
    worker.close()


def test_a_process_finishes_its_work_before_a_compiled_one_replaces_it(threads: ThreadPoolExecutor) -> None:
    compilation = Compiling()
    worker = PlanningWorker(make_fake_engine, processes=1, compilation=compilation)
    watch = Watching()
    planning = threads.submit(
        plan, worker, "improve", watch=watch, job=Job(world="store", priority=Priority.RECOVERY)
    )
    until(lambda: bool(watch.seen))
    compilation.reach(Stage.COMPILED)
    assert plan(worker, "is_compiled").answer
    assert {(one.compiled, one.world, one.priority) for one in worker.status().processes} == {
        (False, "store", "recovery"),
        (True, "", ""),
    }
    watch.stop.set()
    assert planning.result(PATIENCE_S).answer
    until(lambda: [one.compiled for one in worker.status().processes] == [True])
    worker.close()


def test_large_problems_are_planned_uncompiled_if_nothing_will_be_compiled(
    threads: ThreadPoolExecutor,
) -> None:
    compilation = Compiling()
    worker = PlanningWorker(make_fake_engine, compilation=compilation)
    watch = Watching()
    large = threads.submit(plan, worker, "is_uncompiled", watch=watch, job=LARGE)
    until(lambda: bool(watch.waited_for))
    compilation.reach(Stage.UNCOMPILED)
    assert large.result(PATIENCE_S).answer
    worker.close()


def test_large_problems_do_not_wait_for_a_slow_compiler_for_ever() -> None:
    worker = PlanningWorker(make_fake_engine, compilation=Compiling(), clock=SteppedClock())
    watch = Watching()
    assert plan(worker, "is_uncompiled", watch=watch, job=LARGE).answer
    assert "the compilation of the planner, as it is a large problem" in watch.waited_for
    worker.close()


def test_whoever_waits_for_a_turn_may_cancel(worker: PlanningWorker, threads: ThreadPoolExecutor) -> None:
    busy, waiting = [Watching(), Watching()], Watching()
    planning = [threads.submit(plan, worker, "improve", watch=watch) for watch in busy]
    until(lambda: all(watch.seen for watch in busy))
    third = threads.submit(plan, worker, "answer", watch=waiting)
    waiting.cancel.set()
    assert "cancelled" in third.result(PATIENCE_S).reason
    for watch in busy:
        watch.stop.set()
    for one in planning:
        one.result(PATIENCE_S)


def test_an_engine_that_hangs_is_given_up() -> None:
    worker = PlanningWorker(make_fake_engine, grace_s=0.2)
    assert plan(worker, "hang", time_limit_s=0.2).status is PlanningStatus.TIMED_OUT
    worker.close()


def test_a_problem_whose_process_dies_is_tried_again(worker: PlanningWorker, tmp_path: Path) -> None:
    result = plan(worker, "die_once", str(tmp_path / "died"))
    assert result.status is PlanningStatus.SOLVED


def test_processes_that_die_with_nothing_to_do_cost_no_problem_its_plan(
    worker: PlanningWorker, tmp_path: Path
) -> None:
    until(lambda: worker.free_count == 2)
    idle = worker.pids
    for pid in idle:
        os.kill(pid, signal.SIGKILL)
    until(lambda: all(gone(pid) for pid in idle))
    result = plan(worker, "die_once", str(tmp_path / "died"))
    assert result.status is PlanningStatus.SOLVED
    until(lambda: not set(worker.pids) & set(idle))


def test_processes_that_die_before_they_take_a_problem_up_cost_it_no_attempt(
    worker: PlanningWorker, threads: ThreadPoolExecutor, tmp_path: Path
) -> None:
    until(lambda: worker.free_count == 2)
    idle = worker.pids
    for pid in idle:
        os.kill(pid, signal.SIGSTOP)
    planning = threads.submit(plan, worker, "die_once", str(tmp_path / "died"))
    until(lambda: worker.free_count == 1)
    for pid in idle:
        os.kill(pid, signal.SIGKILL)
    assert planning.result(PATIENCE_S).status is PlanningStatus.SOLVED


def test_a_problem_that_kills_every_process_fails_with_the_reason(worker: PlanningWorker) -> None:
    result = plan(worker, "die")
    assert result.status is PlanningStatus.FAILED
    assert "exit code 7" in result.reason


def test_a_defect_is_a_result(worker: PlanningWorker) -> None:
    result = plan(worker, "slip")
    assert result.status is PlanningStatus.FAILED
    assert "a slip" in result.reason


def test_a_worker_that_is_closed_says_so_to_whoever_waits(threads: ThreadPoolExecutor) -> None:
    worker, watch = PlanningWorker(make_fake_engine), Watching()
    planning = threads.submit(plan, worker, "improve", watch=watch)
    until(lambda: bool(watch.seen))
    pids = worker.pids
    worker.close()
    with pytest.raises(WorkerClosed):
        planning.result(PATIENCE_S)
    until(lambda: all(map(gone, pids)))
    with pytest.raises(WorkerClosed):
        plan(worker, "answer")


def test_an_engine_that_cannot_be_made_is_said_at_once(capfd: pytest.CaptureFixture[str]) -> None:
    worker = PlanningWorker(make_no_engine)
    with pytest.raises(Unavailable, match="does not start"):
        worker.warm_up().result(timeout=PATIENCE_S)
    worker.close()
    assert "no engine here" in capfd.readouterr().err


def test_a_process_that_is_killed_as_it_begins_is_replaced() -> None:
    worker = PlanningWorker(make_fake_engine, processes=1)
    ready = worker.warm_up()
    (pid,) = worker.pids
    os.kill(pid, signal.SIGKILL)
    assert ready.result(timeout=PATIENCE_S)
    assert pid not in worker.pids
    assert plan(worker, "answer").status is not PlanningStatus.FAILED
    worker.close()


def test_the_service_process_may_die_and_its_planning_processes_end(tmp_path: Path) -> None:
    """What a killed service leaves behind ends by itself, native engines too."""
    import subprocess
    import sys

    script = (
        "import sys\n"
        "from app.planning.pool.pool import PlanningWorker\n"
        "from tests.app.planning.fake_engine import make_fake_engine\n"
        "from tests.app.planning.pool.test_pool import plan\n"
        "if __name__ == '__main__':\n"
        "    worker = PlanningWorker(make_fake_engine)\n"
        "    worker.warm_up().result(60)\n"
        "    print(worker.pids[0], flush=True)\n"
        "    plan(worker, 'run_a_child', sys.argv[1])\n"
    )
    (tmp_path / "serving.py").write_text(script)
    file = tmp_path / "pid"
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    with subprocess.Popen(
        [sys.executable, str(tmp_path / "serving.py"), str(file)],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    ) as service:
        assert service.stdout is not None
        planning_pid = int(service.stdout.readline())
        until(file.is_file)
        service.kill()
    until(lambda: gone(planning_pid) and gone(int(file.read_text())))
