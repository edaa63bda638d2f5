"""Edited plans beside plans made from scratch: `python -m benchmarks.edits [--goals 8] [--seeds 10] [--edits 4]`.

Plans of random stores; for some of their actions another robot is told to do it, its robot is kept from it, the other
interchange of its aisle is to be used for it, what it is done for is put off by half a minute, or comes after what
another is done for that the plan achieves later. For each kind of edit: how many have a plan, seconds and CPU seconds
of the planning (median, 95th percentile), share of the old plan's actions kept, and makespan over the old one's; the
last two also for the same problem planned from scratch with the default effort.

With `--done`, plans of which so much of the time is over, once all that has begun has ended: what is left is planned
again, as for a mission under way.
"""

import argparse
import random
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import mean, median

from benchmarks.planner.instances import FAMILIES
from benchmarks.planner.scheduled_progress import after
from planner import (
    GOAL,
    INITIAL,
    KnowledgeBase,
    PlanNet,
    PlanNetAction,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    load_knowledge_base,
)
from planner.engines.registry import portfolio
from planner.repair import (
    NOT_BEGUN,
    CannotPin,
    MissionProgress,
    Pin,
    PlanHandles,
    compare,
    edit,
    pinned,
    repair,
)

LIMIT_S = 10.0
LATER_S = 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One edit; `kept` and `longer` are None without a plan, likewise those of the plan made from scratch."""

    seconds: float
    cpu_s: float
    kept: float | None
    longer: float | None
    kept_scratch: float | None
    longer_scratch: float | None


def edits_of(
    plan: PlanNet, problem: PlanningProblem, base: KnowledgeBase, chance: random.Random
) -> Iterator[tuple[str, Pin]]:
    """One edit of each kind that the plan allows, of an action drawn for each."""
    handles = PlanHandles(plan, problem, base)
    robots = sorted(base.agents_among(problem.objects))
    ways = [one for one in problem.objects if one.startswith("interchange")]
    aisles = sum(one.startswith("aisle") for one in problem.objects)
    achieved_s = {
        link.fact: plan.action(link.producer).earliest_end_s
        for link in plan.causal_links
        if link.consumer == GOAL and link.producer != INITIAL
    }
    for kind in ("robot", "without", "via", "later", "after"):
        actions = list(plan.actions)
        chance.shuffle(actions)
        for action in actions:
            try:
                goal = handles.goal_of(action.id)
                if kind == "robot":
                    robot = chance.choice([one for one in robots if one not in action.agents])
                    yield kind, Pin(goal=goal, barred=handles.barred_for(action.id, robot))
                elif kind == "without":
                    yield (
                        kind,
                        Pin(goal=goal, barred=handles.without(action.id, chance.choice(action.agents))),
                    )
                elif kind == "later":
                    yield kind, Pin(goal=goal, not_before_s=action.earliest_end_s + LATER_S)
                elif kind == "after":
                    last = [one for one, end_s in achieved_s.items() if end_s > achieved_s[goal]]
                    if not last:
                        continue
                    yield kind, Pin(goal=goal, after=frozenset({chance.choice(last)}))
                else:
                    used = [one for one in action.arguments.values() if one in ways]
                    if not used or len(ways) <= aisles:
                        continue
                    yield kind, Pin(goal=goal, avoided=frozenset(used[:1]))
            except CannotPin:
                continue
            break


def measured(
    engine: PlanningEngine,
    base: KnowledgeBase,
    plan: PlanNet,
    problem: PlanningProblem,
    progress: MissionProgress,
    pin: Pin,
) -> Row:
    wanted = pinned(problem, [pin], base)
    request = PlanningRequest(time_limit_s=LIMIT_S)
    began, cpu = time.perf_counter(), time.process_time()
    if progress == NOT_BEGUN:
        found = edit(engine, base, plan, wanted, request).plan_net
    else:
        found = repair(engine, base, plan, wanted, progress, request, is_thorough=True).plan_net
    seconds, cpu_s = time.perf_counter() - began, time.process_time() - cpu
    scratch = engine.plan(wanted, request).plan_net
    left = [action for action in plan.actions if action.id not in progress.done]
    left_s = plan.makespan_s - progress.elapsed_s
    kept, longer = _figures(left, left_s, found)
    kept_scratch, longer_scratch = _figures(left, left_s, scratch)
    return Row(
        seconds=seconds,
        cpu_s=cpu_s,
        kept=kept,
        longer=longer,
        kept_scratch=kept_scratch,
        longer_scratch=longer_scratch,
    )


def _figures(
    left: Sequence[PlanNetAction], left_s: float, new: PlanNet | None
) -> tuple[float | None, float | None]:
    """:param left: the old plan's actions that are not done; likewise the seconds."""
    if new is None:
        return None, None
    return len(compare(left, new).kept) / len(left), new.makespan_s / left_s


def table(rows: Mapping[str, list[Row]]) -> Iterator[str]:
    yield (
        "| edit | with a plan, from scratch | seconds, median and p95 | CPU s, median and p95 | kept, from scratch "
        "| makespan over the old one's, from scratch |"
    )
    yield "|---|---|---|---|---|---|"
    for kind, those in rows.items():
        solved = [row for row in those if row.kept is not None]
        scratch = [row for row in those if row.kept_scratch is not None]
        both = [row for row in solved if row.kept_scratch is not None]
        yield (
            f"| {kind} | {len(solved)}, {len(scratch)} of {len(those)} "
            f"| {_median_and_p95([row.seconds for row in solved])} "
            f"| {_median_and_p95([row.cpu_s for row in solved])} "
            f"| {_mean([row.kept for row in both])}, {_mean([row.kept_scratch for row in both])} "
            f"| {_mean([row.longer for row in both])}, {_mean([row.longer_scratch for row in both])} |"
        )


def _mean(values: list[float | None]) -> str:
    return f"{mean(value or 0.0 for value in values):.2f}" if values else "–"


def _median_and_p95(values: list[float]) -> str:
    if not values:
        return "–"
    ordered = sorted(values)
    return f"{median(ordered):.2f}, {ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))]:.2f}"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--goals", type=int, default=8)
    options.add_argument("--seeds", type=int, default=10, help="stores of each family")
    options.add_argument("--edits", type=int, default=3, help="edits of each kind of each plan")
    options.add_argument("--done", type=float, default=0.0, help="share of each plan's time that is over")
    given = options.parse_args()
    base = load_knowledge_base()
    engine = portfolio(base)
    engine.warm_up()
    of_all: list[Row] = []
    for family in ("store", "mixed", "two_ways"):
        rows: dict[str, list[Row]] = defaultdict(list)
        for seed in range(given.seeds):
            problem = FAMILIES[family](given.goals, 900 + seed).problem(base)
            plan = engine.plan(problem, PlanningRequest(time_limit_s=60.0)).plan_net
            if plan is None:
                print(f"{family} {seed}: no plan")
                continue
            problem, progress = after(plan, problem, given.done)
            chance = random.Random(seed)
            for _ in range(given.edits):
                for kind, pin in edits_of(plan, problem, base, chance):
                    rows[kind].append(measured(engine, base, plan, problem, progress, pin))
        print(f"\n{family}, {given.goals} goals, {given.seeds} stores\n")
        print("\n".join(table(rows)), flush=True)
        of_all += [row for those in rows.values() for row in those]
    print("\nall of them\n")
    print("\n".join(table({"any": of_all})))


if __name__ == "__main__":
    main()
