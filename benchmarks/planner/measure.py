"""One engine on one instance, in a process of its own: times, makespans, memory, and the plan-net checked again."""

import resource
import time
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection

from benchmarks.planner.check import fault_of
from benchmarks.planner.instances import FAMILIES
from planner import (
    KnowledgeBase,
    Observer,
    PlanningEngine,
    PlanningRequest,
    Progress,
    load_knowledge_base,
    warm_up,
)
from planner.engines.registry import engine_named

OURS = "macta"
GRACE_S = 60.0
"""For start, warm-up and checks, beyond the engine's own time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """One run of an engine. `effort_s` None: the engine decides."""

    engine: str
    family: str
    samples: int
    seed: int
    limit_s: float
    effort_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """The run's result; times from the world's facts to the validated plan-net, seconds. `fault`: what the
    benchmark's own check finds wrong with the plan-net. `cpu_s`: what this process used of `final_s`."""

    task: Task
    status: str = "killed"
    reason: str = ""
    robots: int = 0
    first_s: float | None = None
    first_makespan_s: float | None = None
    final_s: float | None = None
    cpu_s: float | None = None
    makespan_s: float | None = None
    bound_s: float | None = None
    actions: int = 0
    memory_mib: float = 0.0
    fault: str | None = None

    @property
    def is_solved(self) -> bool:
        return self.makespan_s is not None and self.fault is None


def measured(task: Task) -> Measure:
    """Carry out a task in a fresh process that is ended if it exceeds its limit."""
    context = get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(task, there))
    process.start()
    there.close()
    try:
        return here.recv() if here.poll(2 * task.limit_s + GRACE_S) else Measure(task=task)
    except EOFError:
        return Measure(task=task, status="died")
    finally:
        process.kill()
        process.join()


def _answer(task: Task, there: Connection) -> None:
    knowledge_base = load_knowledge_base()
    engine = engine_named(task.engine, knowledge_base)
    warm_up(engine)
    there.send(run(task, engine, knowledge_base))


class _FirstPlan(Observer):
    """Records when the engine first reports a plan."""

    def __init__(self) -> None:
        self.begun = time.perf_counter()
        self.seen: tuple[float, float] | None = None

    def progress(self, progress: Progress) -> None:
        if self.seen is None and progress.makespan_s is not None:
            self.seen = (time.perf_counter() - self.begun, progress.makespan_s)


def run(task: Task, engine: PlanningEngine, knowledge_base: KnowledgeBase) -> Measure:
    """Carry out a task in this process, with an engine that is warm."""
    instance = FAMILIES[task.family](task.samples, task.seed)
    request = PlanningRequest(time_limit_s=task.limit_s, effort_s=task.effort_s, seed=task.seed)
    first: tuple[float, float] | None = None
    if task.engine == OURS:
        # Without effort: an engine reports its first plan before validating it, and answers after that.
        begun = time.perf_counter()
        result = engine.plan(instance.problem(knowledge_base), replace(request, effort_s=0.0))
        if result.plan_net is not None:
            first = (time.perf_counter() - begun, result.plan_net.makespan_s)
    watch = _FirstPlan()
    problem = instance.problem(knowledge_base)
    cpu_s = time.process_time()
    result = engine.plan(problem, request, watch)
    cpu_s = time.process_time() - cpu_s
    final_s = time.perf_counter() - watch.begun
    measure = Measure(
        task=task,
        status=result.status.value,
        reason=result.reason,
        robots=instance.robots,
        final_s=final_s,
        cpu_s=cpu_s,
    )
    if (net := result.plan_net) is not None:
        seen = first or watch.seen or (final_s, net.makespan_s)
        measure = replace(measure, first_s=seen[0], first_makespan_s=seen[1], makespan_s=net.makespan_s)
        measure = replace(measure, bound_s=result.lower_bound_s, actions=len(net.actions))
    kib = sum(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    fault = fault_of(net, problem, knowledge_base) if net is not None else None
    return replace(measure, memory_mib=kib / 1024, fault=fault)
