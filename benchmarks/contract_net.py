"""Plans by contract net beside plans by planning alone: `python -m benchmarks.contract_net [--sets N] [--seed S]`.

Each set has one to three random goals of the sample store. The goals are planned centrally, and again by what simulated
robots bid for the legs of a first plan; both with the service's own planner, effort and record. Ratios are those of
the contract net to planning alone. Messages are counted once each, however often they were repeated, from the calls to
the awards and rejections. CPU time is that of planning and of the service's part in the conversations; what the robots
need to make their bids is left out.
"""

import argparse
import random
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.cli.trials.random_goals import drawn_goals
from app.store import Database
from app.store.migrate import migrate
from planner import PlanningEngine, load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from robots.world import load_world
from tests.app.planning.tendering import GOAL, Tendering
from tests.app.sample_store import Store

MOST_GOALS = 3
ALONE = "goal-alone"
LIMIT_S = 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """A plan's figures. `work_s`: the time that its robots are at work, together; `cpu_s`: of planning it."""

    makespan_s: float
    work_s: float
    robots: tuple[str, ...]
    cpu_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """A set of goals, planned both ways. `legs` put to tender; `messages`: from calls to awards and rejections."""

    goals: int
    alone: Planned
    tendered: Planned
    state: str
    legs: int
    messages: int


def compare(world_name: str, seed: int, engine: PlanningEngine) -> Compared | str:
    """Plan a random set of goals both ways; why not, if there is no plan."""
    world = load_world(world_name)
    store = Store(world)
    chance = random.Random(seed)
    goals = drawn_goals(world, store.facts, chance.randint(1, MOST_GOALS), seed, store.base)
    with tempfile.TemporaryDirectory(prefix="macta-contract-net-") as folder:
        url = f"sqlite:///{Path(folder) / 'record.sqlite'}"
        database = Database(url)
        migrate(database)
        database.close()
        tendering = Tendering(url, world, engine=engine, seed=seed)
        try:
            return _compared(tendering, [str(goal) for goal in goals])
        finally:
            tendering.close()


def _compared(tendering: Tendering, facts: Sequence[str]) -> Compared | str:
    cpu_s, _ = _timed(lambda: tendering.submit(*facts, id=ALONE, allocation="central"))
    plan_id = tendering.goal(ALONE).plan_id
    if plan_id is None:
        return tendering.goal(ALONE).reason
    alone = _figures(tendering, plan_id, cpu_s)
    tendering.services.plans.reject(plan_id, actor="benchmark")
    first_s, _ = _timed(lambda: tendering.submit(*facts))
    began_s = tendering.simulation.clock.now_s()
    asked_s = 0.0
    while tendering.goal().state == "planning" and tendering.simulation.clock.now_s() < began_s + LIMIT_S:
        tendering.run(0.5)
        spent_s, _ = _timed(lambda: tendering.services.plan_once(GOAL))
        asked_s += spent_s
    plan_id = tendering.goal().plan_id
    if plan_id is None:
        return tendering.goal().reason
    tender = tendering.tender
    _, mission_id = tendering.services.plans.approve(plan_id, actor="benchmark")
    tendering.run(0.5)
    rows = [*tendering.conversations(), *tendering.conversations(about=mission_id)]
    return Compared(
        goals=len(facts),
        alone=alone,
        tendered=_figures(tendering, plan_id, first_s + asked_s),
        state=tender.state,
        legs=len(tender.legs),
        messages=sum(len(row.said) for row in rows),
    )


def _figures(tendering: Tendering, plan_id: str, cpu_s: float) -> Planned:
    body = tendering.services.plans.get(plan_id).body
    work_s = sum(action["duration_s"] * len(action["agents"]) for action in body["actions"])
    return Planned(
        makespan_s=body["makespan_s"], work_s=work_s, robots=tuple(sorted(body["robots"])), cpu_s=cpu_s
    )


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    begun_s = time.process_time()
    result = work()
    return time.process_time() - begun_s, result


def _quartiles(values: Sequence[float], digits: int = 2) -> str:
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f}, most {max(values):.{digits}f})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--sets", type=int, default=100, help="sets of goals")
    parser.add_argument("--seed", type=int, default=0, help="of the first set")
    parser.add_argument("--world", default="sample_store")
    asked = parser.parse_args()
    engine = HierarchicalEngine(load_knowledge_base())
    engine.warm_up()
    found: list[Compared] = []
    failed: list[str] = []
    for seed in range(asked.seed, asked.seed + asked.sets):
        one = compare(asked.world, seed, engine)
        if isinstance(one, str):
            failed.append(f"set {seed}: {one}")
        else:
            found.append(one)
        print(f"\r{len(found)} of {asked.sets} sets", end="", flush=True)
    print()
    for words in failed:
        print(f"no plan for {words}")
    rows = {
        "makespan, planning alone, s": _quartiles([one.alone.makespan_s for one in found], 1),
        "makespan, contract net, s": _quartiles([one.tendered.makespan_s for one in found], 1),
        "makespan, ratio": _quartiles([one.tendered.makespan_s / one.alone.makespan_s for one in found], 3),
        "sum of work, planning alone, s": _quartiles([one.alone.work_s for one in found], 1),
        "sum of work, contract net, s": _quartiles([one.tendered.work_s for one in found], 1),
        "sum of work, ratio": _quartiles([one.tendered.work_s / one.alone.work_s for one in found], 3),
        "legs put to tender": _quartiles([one.legs for one in found], 0),
        "messages, contract net": _quartiles([one.messages for one in found], 0),
        "CPU time, planning alone, s": _quartiles([one.alone.cpu_s for one in found]),
        "CPU time, contract net, s": _quartiles([one.tendered.cpu_s for one in found]),
    }
    for name, figure in rows.items():
        print(f"{name:34} {figure}")
    longer = sum(one.tendered.makespan_s > one.alone.makespan_s + 0.05 for one in found)
    shorter = sum(one.tendered.makespan_s < one.alone.makespan_s - 0.05 for one in found)
    other = sum(one.tendered.robots != one.alone.robots for one in found)
    print(f"longer plans {longer}, shorter {shorter}, of {len(found)}; by other robots {other}")
    print(f"tenders that ended {dict(Counter(one.state for one in found))}")
    print(f"sets by their number of goals {dict(sorted(Counter(one.goals for one in found).items()))}")


if __name__ == "__main__":
    main()
