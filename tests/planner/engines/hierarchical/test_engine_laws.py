"""Laws of the hierarchical engine over random worlds, instances and requests."""

import os
import random
import subprocess
import sys
import time
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.planner.instances import FAMILIES
from planner import (
    Fact,
    Objective,
    Observer,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    Progress,
    load_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.registry import portfolio
from tests.planner.engines.hierarchical.judging import honest, judged, planned
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside

BASE = load_knowledge_base()
ENGINE = HierarchicalEngine(BASE)
"""Shared by all examples: what it planned before must not matter."""
FIRST = PlanningRequest(time_limit_s=60.0, effort_s=0.0)


def instance(family: str, samples: int, seed: int) -> PlanningProblem:
    return FAMILIES[family](samples, seed).problem(BASE)


@settings(max_examples=5, deadline=None, derandomize=True)
@given(
    aisles=st.integers(1, 3),
    yard_robots=st.integers(1, 3),
    store_robots=st.integers(1, 2),
    interchanges=st.integers(1, 2),
    goals=st.integers(1, 3),
    seed=st.integers(0, 9999),
)
def test_random_stores(
    aisles: int, yard_robots: int, store_robots: int, interchanges: int, goals: int, seed: int
) -> None:
    """Samples and robots anywhere, goals about both: a faultless plan-net or a word why not."""
    world = Store(
        aisles=aisles, yard_robots=yard_robots, store_robots=store_robots, interchanges=interchanges
    )
    chance = random.Random(seed)
    doors = ["door_0", "door_1"]
    bays = [f"bay_{a}_{n}" for a in range(aisles) for n in range(6)]
    samples = {f"s{n}": place for n, place in enumerate(chance.sample(doors + bays, 5))}
    wanted = [
        inside(sample, place)
        for sample, place in zip(
            chance.sample(list(samples), goals), chance.sample(doors + bays, goals), strict=True
        )
    ]
    yard = [f"yard_{n}" for n in range(yard_robots)]
    borders = [f"interchange_{a}_0" for a in range(aisles)]
    standing = dict(zip(yard, chance.sample(doors + borders, len(yard)), strict=True)) if seed % 2 else {}
    if seed % 3 == 0:
        wanted.append(Fact("robot_position", (yard[0], "near", chance.choice(["home_yard_0", *borders]))))
    problem = world.problem(wanted, samples, robots_at=standing)
    honest(ENGINE.plan(problem, FIRST), problem, BASE)


@pytest.mark.parametrize("samples", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("family", ["store", "mixed", "retrieve", "paper"])
def test_goals_that_do_not_interact_are_always_reached(family: str, samples: int) -> None:
    for seed in range(2):
        problem = instance(family, samples, seed)
        plan_net = ENGINE.plan(problem, FIRST).plan_net
        assert plan_net is not None
        judged(plan_net, problem, BASE)


@pytest.mark.parametrize(
    ("family", "samples"),
    [
        ("blocked", 1),
        ("blocked", 2),
        ("blocked", 3),
        ("swap", 2),
        ("swap", 4),
        ("relocation", 1),
        ("relocation", 4),
    ],
)
def test_goals_that_interact_are_reached(family: str, samples: int) -> None:
    for seed in (0, 4):
        problem = instance(family, samples, seed)
        result = honest(ENGINE.plan(problem, FIRST), problem, BASE)
        assert result.plan_net is not None, result.reason


@pytest.mark.parametrize("family", ["mixed", "swap"])
def test_the_portfolio_hands_on_what_the_engine_finds(family: str) -> None:
    problem = instance(family, 2, 0)
    result = honest(portfolio(BASE).plan(problem, FIRST), problem, BASE)
    assert result.engine == HierarchicalEngine.name


def test_the_portfolio_says_why_there_is_no_plan() -> None:
    problem = instance("store", 2, 0)
    without = frozenset(f for f in problem.facts if f.predicate != "can" or f.args[1] != "RELEASE2")
    result = honest(portfolio(BASE).plan(replace(problem, facts=without), FIRST), problem, BASE)
    assert result.status is PlanningStatus.UNSOLVABLE


@pytest.mark.parametrize(
    ("family", "samples"), [("mixed", 4), ("swap", 2), ("blocked", 2), ("relocation", 3)]
)
def test_the_same_request_gives_the_same_plan_net_whatever_was_planned_before(
    family: str, samples: int
) -> None:
    request = PlanningRequest(seed=3)
    problem = instance(family, samples, 1)
    fresh = HierarchicalEngine(BASE).plan(problem, request).plan_net
    ENGINE.plan(instance("blocked", 2, 3), FIRST)
    assert fresh is not None
    assert ENGINE.plan(problem, request).plan_net == fresh


PRINT_PLAN_NETS = """
from benchmarks.planner.instances import FAMILIES
from planner import PlanningRequest, load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
base = load_knowledge_base()
for family, samples in (("mixed", 2), ("swap", 2)):
    print(HierarchicalEngine(base).plan(FAMILIES[family](samples, 1).problem(base), PlanningRequest(seed=3)).plan_net)
"""


def test_two_processes_find_the_same_plan_net() -> None:
    """Neither the hashing of names nor the order of sets matters."""
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", PRINT_PLAN_NETS],
            env={**os.environ, "PYTHONHASHSEED": seed},
            stdout=subprocess.PIPE,
            text=True,
        )
        for seed in ("1", "2")
    ]
    one, other = (process.communicate()[0] for process in processes)
    assert "PlanNet" in one
    assert one == other


class Watching(Observer):
    """Keeps the progress reports and asks to stop after a number of them."""

    def __init__(self, patience: int = 10**9) -> None:
        self.reports: list[Progress] = []
        self._patience = patience

    def progress(self, progress: Progress) -> None:
        self.reports.append(progress)

    def should_stop(self) -> bool:
        return len(self.reports) >= self._patience


def test_progress_only_gets_better() -> None:
    watching = Watching()
    ENGINE.plan(instance("mixed", 4, 0), PlanningRequest(effort_s=0.5), watching)
    makespans = [p.makespan_s for p in watching.reports if p.makespan_s is not None]
    elapsed = [p.elapsed_s for p in watching.reports]
    assert len(makespans) > 1
    assert makespans == sorted(makespans, reverse=True)
    assert elapsed == sorted(elapsed)


def test_who_says_stop_gets_the_best_plan_so_far() -> None:
    problem = instance("mixed", 4, 0)
    watching = Watching(patience=2)
    result = honest(
        ENGINE.plan(problem, PlanningRequest(effort_s=300.0, time_limit_s=600.0), watching), problem, BASE
    )
    assert result.status is PlanningStatus.SOLVED
    assert len(watching.reports) < 10


def test_who_says_stop_at_once_is_answered() -> None:
    problem = instance("swap", 4, 0)
    result = honest(ENGINE.plan(problem, PlanningRequest(), Watching(patience=0)), problem, BASE)
    assert result.status in (PlanningStatus.SOLVED, PlanningStatus.NOT_FOUND)


def test_no_time_is_no_plan() -> None:
    problem = instance("swap", 4, 0)
    result = honest(ENGINE.plan(problem, PlanningRequest(time_limit_s=0.0)), problem, BASE)
    assert result.status is PlanningStatus.TIMED_OUT


def test_effort_ends_with_the_time_limit() -> None:
    """An effort without end: only the limit ends it."""
    problem = instance("mixed", 3, 0)
    request = PlanningRequest(effort_s=1e6, time_limit_s=2.0, clock=time.process_time)
    begun = time.process_time()
    result = honest(ENGINE.plan(problem, request), problem, BASE)
    assert result.status is PlanningStatus.SOLVED
    assert result.planning_s <= time.process_time() - begun


def test_fewer_robots_where_robots_are_to_be_few() -> None:
    few = most = 0
    for seed in range(3):
        problem = instance("store", 4, seed)
        few += len(_with(problem, Objective.ROBOTS).robots)
        most += len(_with(problem, Objective.MAKESPAN).robots)
    assert few < most


def test_less_energy_where_energy_is_to_be_saved() -> None:
    for seed in range(3):
        problem = instance("mixed", 4, seed)
        saving = _with(problem, Objective.ENERGY)
        quick = _with(problem, Objective.MAKESPAN)
        assert saving.energy_j <= quick.energy_j
        assert quick.makespan_s <= saving.makespan_s + 0.01


def _with(problem: PlanningProblem, objective: Objective) -> PlanNet:
    return planned(BASE, problem, PlanningRequest(objective=objective))


@pytest.mark.parametrize("urgent", range(3))
def test_what_is_due_first_is_served_first(urgent: int) -> None:
    world = Store(aisles=1, yard_robots=1, doors=3)
    goals = [inside(f"s{n}", f"bay_0_{n}") for n in range(3)]
    problem = world.problem(goals, {f"s{n}": f"door_{n}" for n in range(3)})
    alone = planned(BASE, world.problem([goals[urgent]], {f"s{n}": f"door_{n}" for n in range(3)}))
    due = replace(problem, deadlines_s={goals[urgent]: alone.makespan_s + 1.0})
    plan_net = planned(BASE, due, PlanningRequest())
    assert plan_net.late == {}
    assert _end(plan_net, goals[urgent]) == min(_end(plan_net, goal) for goal in goals)


@pytest.mark.parametrize("urgent", range(3))
def test_of_what_is_late_the_more_urgent_is_served_first(urgent: int) -> None:
    world = Store(aisles=1, yard_robots=1, doors=3)
    goals = [inside(f"s{n}", f"bay_0_{n}") for n in range(3)]
    problem = world.problem(goals, {f"s{n}": f"door_{n}" for n in range(3)})
    due = replace(problem, deadlines_s=dict.fromkeys(goals, 0.0), priorities={goals[urgent]: 80})
    plan_net = planned(BASE, due, PlanningRequest())
    assert _end(plan_net, goals[urgent]) == min(_end(plan_net, goal) for goal in goals)


def _end(plan_net: PlanNet, goal: Fact) -> float:
    return max(a.earliest_end_s for a in plan_net.actions if goal in a.intended_effects)
