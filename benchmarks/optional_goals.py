"""Optional goals, compared with trying every subset: `python -m benchmarks.optional_goals [--stores N] [--goals N …]`.

Random stores whose samples are all optional, each worth 1 to 20, with a deadline of a third to nine tenths of the time
that all of them take. The same engine with the same effort plans every subset; the best of those that are in time is
the reference. By count of goals: how often the choice is worth as much, what share of it on average and at worst, and
the subsets planned and seconds taken, exactly and by exchanges alone, as with more than ten goals.
"""

import argparse
import random
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from statistics import fmean

from benchmarks.planner.instances import FAMILIES
from planner import (
    UNOBSERVED,
    Fact,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    load_knowledge_base,
)
from planner.engines.oversubscription import OversubscriptionEngine
from planner.engines.registry import engine_named

EFFORT_S = 0.05


@dataclass
class Counting:
    """An engine that notes which goals it was asked for."""

    engine: PlanningEngine
    asked: set[frozenset[Fact]] = field(default_factory=set)
    name: str = "counting"

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.asked.add(frozenset(problem.goals))
        return self.engine.plan(problem, request, observer)


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """A choice: its value as a share of the best, subsets planned, seconds."""

    share: float
    asked: int
    seconds: float


def best_of_all(engine: PlanningEngine, stated: PlanningProblem) -> float:
    """The most that a subset in time is worth."""
    best = 0.0
    for size in range(1, len(stated.goals) + 1):
        for some in combinations(stated.goals, size):
            subset = replace(stated, goals=some, values={})
            for effort_s in (0.0, EFFORT_S):
                plan_net = engine.plan(subset, PlanningRequest(effort_s=effort_s)).plan_net
                if plan_net is not None and not plan_net.late:
                    best = max(best, sum(stated.values[goal] for goal in some))
                    break
    return best


def rows(stores: int, goals: int) -> Iterator[tuple[float, Measured, Measured]]:
    """The best value, the exact choice and the one by exchanges, of random stores."""
    base = load_knowledge_base()
    engine = engine_named("macta", base)
    for number in range(stores):
        chance = random.Random(f"optional/{goals}/{number}")
        family = ("store", "mixed")[number % 2]
        problem = FAMILIES[family](goals, 30_000 + number).problem(base)
        whole = engine.plan(problem, PlanningRequest(effort_s=EFFORT_S)).plan_net
        assert whole is not None
        deadline_s = whole.makespan_s * chance.uniform(0.33, 0.9)
        stated = replace(
            problem,
            deadlines_s=dict.fromkeys(problem.goals, deadline_s),
            values={goal: float(chance.randint(1, 20)) for goal in problem.goals},
        )
        best = best_of_all(engine, stated)
        if best == 0.0:
            continue
        chosen: list[Measured] = []
        for exact_up_to in (goals, 0):
            counting = Counting(engine)
            begun_s = time.perf_counter()
            result = OversubscriptionEngine(counting, base, exact_up_to=exact_up_to).plan(
                stated, PlanningRequest(effort_s=EFFORT_S, time_limit_s=60.0)
            )
            seconds = time.perf_counter() - begun_s
            value = (result.value or 0.0) if result.plan_net is not None else 0.0
            chosen.append(Measured(share=value / best, asked=len(counting.asked), seconds=seconds))
        yield best, chosen[0], chosen[1]


def line(name: str, measured: Sequence[Measured]) -> str:
    as_good = sum(one.share > 1 - 1e-9 for one in measured)
    return (
        f"{name} | {as_good} of {len(measured)} | {fmean(one.share for one in measured):.1%} | "
        f"{min(one.share for one in measured):.1%} | {fmean(one.asked for one in measured):.0f} | "
        f"{fmean(one.seconds for one in measured):.2f} |"
    )


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.optional_goals", description=__doc__)
    parser.add_argument("--stores", type=int, default=10)
    parser.add_argument("--goals", type=int, nargs="+", default=[4, 6, 8])
    given = parser.parse_args()
    print(
        "| optional goals | subsets | by | as good as the best | worth, mean | worst | subsets planned | s |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for goals in given.goals:
        found = list(rows(given.stores, goals))
        what = f"| {goals} | {2**goals - 1} |"
        print(line(f"{what} every better subset", [exact for _, exact, _ in found]))
        print(line(f"{what} exchanges", [exchanged for _, _, exchanged in found]), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
