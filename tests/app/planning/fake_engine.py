"""An engine for planning processes of tests: what it does is the only fact of its problem."""

import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

from app.domain.world_model import planning_problem
from app.planning.pool.process import Tell
from planner import (
    UNOBSERVED,
    Fact,
    Observer,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
)
from planner.repair import NOT_BEGUN, repair
from robots.compilation import compiles
from tests.app.planning.store_engine import StoreEngine
from tests.app.sample_store import Store

PLAN = PlanNet(goals=(), actions=(), causal_links=(), orderings=(), recruitment={})


def problem(deed: str, *words: str) -> PlanningProblem:
    return PlanningProblem(objects={}, facts=frozenset({Fact(deed, words)}), goals=())


class FakeEngine:
    name = "fake"

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        (fact,) = problem.facts
        getattr(self, fact.predicate)(observer, *fact.args)
        return PlanningResult(
            status=PlanningStatus.SOLVED, engine=f"{self.name} {os.getpid()}", planning_s=0.0, plan_net=PLAN
        )

    def answer(self, _: Observer) -> None:
        """At once."""

    def is_compiled(self, _: Observer) -> None:
        assert compiles()

    def is_uncompiled(self, _: Observer) -> None:
        assert not compiles()

    def improve(self, observer: Observer) -> None:
        """Tell of ever shorter plans until told to stop."""
        makespan_s = 100.0
        while not observer.should_stop():
            makespan_s -= 1
            observer.progress(Progress(engine=self.name, elapsed_s=100 - makespan_s, makespan_s=makespan_s))
            time.sleep(0.001)

    def hang(self, _: Observer) -> None:
        time.sleep(600)

    def die(self, _: Observer) -> None:
        os._exit(7)

    def die_once(self, _: Observer, file: str) -> None:
        if not Path(file).exists():
            Path(file).touch()
            os._exit(7)

    def slip(self, _: Observer) -> None:
        raise ZeroDivisionError("a slip")

    def hang_deaf(self, observer: Observer, file: str) -> None:
        """Never return, nor hear of being ended, with a native engine that runs for long."""
        import signal

        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        self.run_a_child(observer, file)

    def eat(self, _: Observer) -> None:
        """Take ever more memory."""
        eaten = []
        while True:
            eaten.append(bytes(bytearray(os.urandom(1)) * 20_000_000))
            time.sleep(0.02)

    def have_a_child_eat(self, _: Observer) -> None:
        """A native engine that takes ever more memory."""
        eat = "eaten = []\nwhile True: eaten.append(bytearray(b'x' * 20_000_000)); __import__('time').sleep(0.02)"
        subprocess.run([sys.executable, "-c", eat], check=True)

    def run_a_child(self, observer: Observer, file: str) -> None:
        """A native engine that runs for long, as `planner.native_process` runs them."""
        from planner.native_process import Limits, run

        script = f"echo $$ > {file}.new; mv {file}.new {file}; exec sleep 600"
        run(["/bin/sh", "-c", script], folder=Path("/"), limits=Limits(600))


def make_fake_engine(_: Tell) -> FakeEngine:
    return FakeEngine()


def make_no_engine(_: Tell) -> FakeEngine:
    raise subprocess.SubprocessError("no engine here")


class PatientEngine:
    """Has a plan of the sample store at once, and then a bound that rises until it is told to stop."""

    name = "patient"

    def __init__(self) -> None:
        self._engine = StoreEngine()
        self._warm_up()

    def _warm_up(self) -> None:
        """Repair a plan once: the first repair of a process loads compiled code."""
        store = Store()
        problem = planning_problem(store.world, store.facts, (store.fact("in(sample_1, bay_7)"),))
        plan_net = store.store_sample_1()
        repair(self._engine, store.base, plan_net, problem, NOT_BEGUN, PlanningRequest())

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        result = self._engine.plan(problem, request)
        makespan_s = result.plan_net.makespan_s if result.plan_net else None
        begun_s = time.monotonic()
        bound_s = 0.0
        while not observer.should_stop() and time.monotonic() < begun_s + request.time_limit_s:
            bound_s += 0.01
            observer.progress(
                Progress(
                    engine=self.name,
                    elapsed_s=time.monotonic() - begun_s,
                    makespan_s=makespan_s,
                    lower_bound_s=bound_s,
                )
            )
            time.sleep(0.01)
        return replace(result, lower_bound_s=bound_s, engine=f"{request.objective} {request.effort_s}")


def make_patient_engine(_: Tell) -> PatientEngine:
    return PatientEngine()
