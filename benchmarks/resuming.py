"""What is left of plans, planned from their middle: `python -m benchmarks.resuming [--goals 6] [--seeds 5]`.

Plans of random stores of which a part of the time is over, once all that has begun has ended, as when an operator has a
mission planned again. First table: what is left is planned from scratch; how many have a plan, its makespan over what
was left of the old one, and CPU seconds. Second table: the old plan had to do without one of its yard robots, which is
back now; what planning again saves of what is left, with a kept action worth as much as in repairs after failures, and
as much as where an operator asks (`planner.repair.KEPT_ON_REQUEST_S`).
"""

import argparse
import random
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from statistics import median

from benchmarks.planner.instances import FAMILIES
from benchmarks.planner.scheduled_progress import after
from planner import (
    KEPT_S,
    KnowledgeBase,
    PlanNet,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    load_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.repair import KEPT_ON_REQUEST_S, Remaining, repair

REQUEST = PlanningRequest(time_limit_s=10.0)
NAMES = ("store", "mixed", "two_ways")
SHARES = (0.15, 0.35, 0.6)


def resumed(
    engine: PlanningEngine,
    base: KnowledgeBase,
    plans: Sequence[tuple[PlanNet, PlanningProblem]],
    share: float,
) -> str:
    """A row of the first table."""
    longer, cpu_s = [], []
    for plan, problem in plans:
        now, progress = after(plan, problem, share)
        left = Remaining(plan, now, progress, base).problem
        began = time.process_time()
        found = engine.plan(left, replace(REQUEST, resumes=True)).plan_net
        cpu_s.append(time.process_time() - began)
        if found is not None:
            longer.append(found.makespan_s / (plan.makespan_s - progress.elapsed_s))
    return (
        f"| {share:.0%} | {len(longer)} of {len(plans)} | {_median_and_worst(longer)} "
        f"| {_median_and_worst(cpu_s)} |"
    )


def returned(
    engine: PlanningEngine,
    base: KnowledgeBase,
    plans: Sequence[tuple[PlanNet, PlanningProblem]],
    share: float,
) -> str:
    """A row of the second table."""
    saved: dict[float, list[float]] = {KEPT_S: [], KEPT_ON_REQUEST_S: []}
    for number, (plan, problem) in enumerate(plans):
        used = sorted(
            {robot for action in plan.actions for robot in action.agents if robot.startswith("yard")}
        )
        robot = random.Random(number).choice(used)
        able = {fact for fact in problem.facts if fact.predicate == "can" and fact.args[0] == robot}
        lacking = replace(problem, facts=problem.facts - able)
        old = engine.plan(lacking, REQUEST).plan_net
        if old is None:
            continue
        now, progress = after(old, lacking, share)
        back = replace(now, facts=now.facts | able)
        for kept_s, shares in saved.items():
            found = repair(
                engine, base, old, back, progress, REQUEST, stability_s=kept_s, is_thorough=True
            ).plan_net
            assert found is not None
            shares.append(1 - found.makespan_s / (old.makespan_s - progress.elapsed_s))
    columns = (
        f"{median(shares):.0%} | {sum(one > 0.1 for one in shares)} of {len(shares)}"
        for shares in saved.values()
    )
    return f"| {share:.0%} | {' | '.join(columns)} |"


def _median_and_worst(values: Sequence[float]) -> str:
    return f"{median(values):.2f}, {max(values):.2f}" if values else "–"


def _plans(
    engine: PlanningEngine, base: KnowledgeBase, goals: int, seeds: int
) -> Iterator[tuple[PlanNet, PlanningProblem]]:
    for name in NAMES:
        for seed in range(seeds):
            problem = FAMILIES[name](goals, 700 + seed).problem(base)
            plan = engine.plan(problem, REQUEST).plan_net
            assert plan is not None, f"{name} {seed}"
            yield plan, problem


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--goals", type=int, default=6)
    options.add_argument("--seeds", type=int, default=5, help="stores of each family")
    given = options.parse_args()
    base = load_knowledge_base()
    engine = HierarchicalEngine(base)
    engine.warm_up()
    plans = list(_plans(engine, base, given.goals, given.seeds))
    print("| over | with a plan | makespan over what was left, median and worst | CPU s, median and worst |")
    print("|---|---|---|---|")
    for share in SHARES:
        print(resumed(engine, base, plans, share), flush=True)
    print("\n| over | saved, median | more than 10 % | saved where an operator asks | more than 10 % |")
    print("|---|---|---|---|---|")
    for share in SHARES:
        print(returned(engine, base, plans, share), flush=True)


if __name__ == "__main__":
    main()
