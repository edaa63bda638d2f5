"""How long the engine improves a plan, and that more effort never gives a worse one. No test measures time."""

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from benchmarks.planner.instances import FAMILIES
from planner import (
    Objective,
    Observer,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    Progress,
    load_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from tests.planner.engines.hierarchical.judging import judged
from tests.planner.stepped_clock import TickingClock

BASE = load_knowledge_base()
ENGINE = HierarchicalEngine(BASE)
EFFORTS_S = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3)
"""By a ticking clock: about as many chunks of trials as milliseconds."""


def instance(family: str, samples: int, seed: int) -> PlanningProblem:
    return FAMILIES[family](samples, seed).problem(BASE)


class Elapsed(Observer):
    """Keeps when each improvement was reported."""

    def __init__(self) -> None:
        self.seen_s: list[float] = []

    def progress(self, progress: Progress) -> None:
        self.seen_s.append(progress.elapsed_s)


def planned(problem: PlanningProblem, *, observer: Observer | None = None, **wishes: object) -> PlanNet:
    request = PlanningRequest(clock=TickingClock(), **wishes)  # type: ignore[arg-type]
    plan_net = ENGINE.plan(problem, request, observer or Observer()).plan_net
    assert plan_net is not None
    return plan_net


@settings(max_examples=6, deadline=None, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(
    case=st.sampled_from(
        [
            *(("mixed", 3), ("mixed", 8), ("mixed", 20), ("store", 6), ("swap", 4), ("blocked", 2)),
            *(("relocation", 3), ("full", 6), ("rearranged", 12), ("rearranged", 16)),
        ]
    ),
    seed=st.integers(100, 999),
    search=st.integers(0, 9),
)
def test_more_effort_never_gives_a_worse_plan(case: tuple[str, int], seed: int, search: int) -> None:
    problem = instance(*case, seed)
    makespans = [planned(problem, effort_s=effort_s, seed=search).makespan_s for effort_s in EFFORTS_S]
    assert makespans == sorted(makespans, reverse=True)


def test_a_mended_plan_is_not_lost_when_a_better_schedule_is_found() -> None:
    """The first schedules have redundant actions; without them one is quicker than better ones found after it."""
    problem = instance("full", 6, 117)
    makespans = [planned(problem, effort_s=effort_s, seed=8).makespan_s for effort_s in EFFORTS_S]
    assert makespans == sorted(makespans, reverse=True)


def test_more_effort_gives_a_better_plan_in_the_end() -> None:
    problem = instance("full", 6, 117)
    least, *_, most = (judged(planned(problem, effort_s=effort_s), problem, BASE) for effort_s in EFFORTS_S)
    assert most.makespan_s < 0.9 * least.makespan_s


@pytest.mark.parametrize("objective", [Objective.ROBOTS, Objective.ENERGY])
def test_more_effort_never_gives_a_worse_plan_by_another_objective(objective: Objective) -> None:
    problem = instance("mixed", 4, 7)
    nets = [planned(problem, effort_s=effort_s, objective=objective) for effort_s in EFFORTS_S]
    costs = [len(net.robots) if objective is Objective.ROBOTS else net.energy_j for net in nets]
    assert costs == sorted(costs, reverse=True)


@pytest.mark.parametrize(("family", "samples"), [("mixed", 6), ("full", 6), ("swap", 4)])
@pytest.mark.parametrize("effort_s", [0.1, 0.5])
def test_the_effort_is_kept_to_a_tenth(family: str, samples: int, effort_s: float) -> None:
    elapsed = Elapsed()
    planned(instance(family, samples, 0), observer=elapsed, effort_s=effort_s)
    assert elapsed.seen_s[-1] - elapsed.seen_s[0] == pytest.approx(effort_s, rel=0.1)


@pytest.mark.parametrize("time_limit_s", [1.0, 3.0])
def test_the_time_limit_is_kept_to_a_tenth(time_limit_s: float) -> None:
    """Whatever the effort; what is left is for checking the plan."""
    clock = TickingClock()
    ENGINE.plan(
        instance("mixed", 6, 0), PlanningRequest(effort_s=1e6, time_limit_s=time_limit_s, clock=clock)
    )
    assert 0.9 * time_limit_s <= clock.readings / 1000 <= 1.1 * time_limit_s


def test_the_same_plan_comes_of_the_same_number_of_trials_whatever_the_clock_says() -> None:
    problem = instance("mixed", 4, 3)
    assert planned(problem) == ENGINE.plan(problem, PlanningRequest()).plan_net
