"""How likely deadlines are kept, predicted and observed: `python -m benchmarks.punctuality [--stores N] [--runs N]`.

Stores are drawn at random, and for each the true durations: for every kind of action a gamma distribution with a mean
ratio and a spread of its own, which the planner does not know and which is of another family than it believes in. It
learns from a few observed actions of each kind, plans, and forecasts. Then every plan is executed many times with true
durations by robots that obey `kept_by` alone (`tests/planner/kept_by_execution.py`).

Prints predicted beside observed frequencies of goals in time, by how much was observed before; the Brier score of the
forecast, of "in time if the plan ends in time as expected", and of always saying the mean frequency; how often P10, P50
and P90 are kept; and what the objective `on_time` gains over the shortest plan.
"""

import argparse
import random
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean

from app.domain.durations import PRIOR, PRIOR_SAMPLES, Learned
from benchmarks.planner.instances import FAMILIES
from planner import (
    Fact,
    KnowledgeBase,
    Objective,
    PlanNet,
    PlanNetAction,
    PlanningProblem,
    PlanningRequest,
    Spread,
    load_knowledge_base,
    scale_term,
)
from planner.engines.registry import engine_named
from planner.plan_nets.completion import forecast
from planner.plan_nets.forecast import Kind
from tests.planner.kept_by_execution import Execution

OBSERVATIONS = (0, 3, 10, 50)
SIZES = (("store", 2), ("store", 4), ("mixed", 4), ("mixed", 8))
BINS = ((0.0, 0.05), (0.05, 0.2), (0.2, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 0.95), (0.95, 1.01))


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """The ratios of actual to expected duration: gamma, by kind its mean and its spread as a share of that."""

    of_kind: Mapping[Kind, tuple[float, float]]

    @classmethod
    def drawn(cls, knowledge_base: KnowledgeBase, chance: random.Random) -> "Truth":
        """Means as wide as the prior believes, spreads about its own."""
        kinds = sorted({(op.spec.name, len(op.agents)) for op in knowledge_base.operators})
        return cls(
            of_kind={kind: (chance.lognormvariate(0.0, 0.17), chance.uniform(0.1, 0.45)) for kind in kinds}
        )

    def ratio(self, kind: Kind, chance: random.Random) -> float:
        mean, spread = self.of_kind[kind]
        shape = spread**-2
        return chance.gammavariate(shape, mean / shape)


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A goal with a deadline: what was predicted, what came of it.

    :param expected: the plan achieves it in time as expected.
    """

    observations: int
    predicted: float
    expected: bool
    observed: Sequence[bool]
    below: Mapping[float, float]
    """Quantile → share of executions that achieve it by then."""


def learned_problem(
    problem: PlanningProblem, truth: Truth, observations: int, chance: random.Random
) -> tuple[PlanningProblem, Mapping[Kind, float]]:
    """The problem with what was learned from that number of actions of each kind, and the factors on durations."""
    known: dict[Kind, Learned] = {}
    for kind in truth.of_kind:
        learned = PRIOR
        for _ in range(observations):
            learned = learned.with_sample(truth.ratio(kind, chance))
        known[kind] = learned
    factors = {kind: round(learned.factor, 3) for kind, learned in known.items()}
    spreads = {
        kind: Spread(relative=learned.relative_spread, observations=learned.samples + PRIOR_SAMPLES)
        for kind, learned in known.items()
    }
    scales = {scale_term(*kind): factor for kind, factor in factors.items()}
    return replace(problem, functions={**problem.functions, **scales}, spreads=spreads), factors


def executed(
    plan_net: PlanNet,
    problem: PlanningProblem,
    knowledge_base: KnowledgeBase,
    truth: Truth,
    factors: Mapping[Kind, float],
    runs: int,
    seed: int,
) -> Iterator[Mapping[Fact, float]]:
    """When each goal is achieved, in every execution.

    :raises RuntimeError: if an execution goes wrong.
    """
    for run in range(runs):
        chance = random.Random(f"{seed}/{run}")

        def takes_s(action: PlanNetAction, chance: random.Random = chance) -> float:
            kind = (action.tag, len(action.agents))
            return action.duration_s / factors[kind] * truth.ratio(kind, chance)

        execution = Execution(plan_net, problem, knowledge_base, seed=run, takes_s=takes_s)
        if execution.fault is not None:
            raise RuntimeError(execution.fault)
        yield {goal: execution.achieved_s.get(goal, 0.0) for goal in plan_net.goals}


def cases(stores: int, runs: int, effort_s: float) -> Iterator[Case]:
    """Of random stores, every goal."""
    base = load_knowledge_base()
    engine = engine_named("macta", base)
    for number in range(stores):
        chance = random.Random(f"punctuality/{number}")
        family, samples = SIZES[number % len(SIZES)]
        truth = Truth.drawn(base, chance)
        observations = chance.choice(OBSERVATIONS)
        problem, factors = learned_problem(
            FAMILIES[family](samples, 10_000 + number).problem(base), truth, observations, chance
        )
        plan_net = engine.plan(problem, PlanningRequest(effort_s=effort_s)).plan_net
        if plan_net is None:
            raise RuntimeError(f"no plan for {family} {samples} {number}")
        ends_s = {
            link.fact: plan_net.action(link.producer).earliest_end_s
            for link in plan_net.causal_links
            if link.consumer == "goal"
        }
        due = {goal: ends_s[goal] * chance.uniform(0.8, 1.5) for goal in problem.goals}
        likely = forecast(plan_net, due, problem.spreads)
        times = list(executed(plan_net, problem, base, truth, factors, runs, number))
        for goal in likely.goals:
            assert goal.deadline_s is not None
            predicted = goal.on_time()
            assert predicted is not None
            yield Case(
                observations=observations,
                predicted=predicted,
                expected=ends_s[goal.goal] <= goal.deadline_s,
                observed=[one[goal.goal] <= goal.deadline_s for one in times],
                below={
                    level: fmean(one[goal.goal] <= goal.completion_s.quantile(level) for one in times)
                    for level in (0.1, 0.5, 0.9)
                },
            )


def brier(predicted: Sequence[float], observed: Sequence[Sequence[bool]]) -> float:
    """The mean squared difference of predictions and outcomes (Brier 1950)."""
    return fmean(
        fmean((one - came) ** 2 for came in outcomes)
        for one, outcomes in zip(predicted, observed, strict=True)
    )


def table(found: Sequence[Case]) -> Iterator[str]:
    yield "| predicted | goals | mean predicted | observed |"
    yield "|---|---|---|---|"
    for low, high in BINS:
        inside = [case for case in found if low <= case.predicted < high]
        if inside:
            observed = fmean(fmean(case.observed) for case in inside)
            mean = fmean(case.predicted for case in inside)
            yield f"| {low:.0%} to {min(high, 1):.0%} | {len(inside)} | {mean:.1%} | {observed:.1%} |"
    yield ""
    yield "| observed before, of each kind | goals | P10 | P50 | P90 kept | Brier score | as expected | base rate |"
    yield "|---|---|---|---|---|---|---|---|"
    for observations in (*OBSERVATIONS, None):
        some = [case for case in found if observations in (None, case.observations)]
        if not some:
            continue
        kept = [fmean(case.below[level] for case in some) for level in (0.1, 0.5, 0.9)]
        outcomes = [case.observed for case in some]
        rate = fmean(fmean(one) for one in outcomes)
        scores = [
            brier([case.predicted for case in some], outcomes),
            brier([float(case.expected) for case in some], outcomes),
            brier([rate] * len(some), outcomes),
        ]
        what = "all" if observations is None else str(observations)
        cells = [*(f"{share:.1%}" for share in kept), *(f"{score:.3f}" for score in scores)]
        yield f"| {what} | {len(some)} | {' | '.join(cells)} |"


def gains(stores: int, runs: int, effort_s: float) -> Iterator[str]:
    """Goals in time by the shortest plan and by `on_time`, executed with the same durations' distribution."""
    base = load_knowledge_base()
    engine = engine_named("macta", base)
    rows: list[tuple[float, float, float, float, float]] = []
    for number in range(stores):
        chance = random.Random(f"gains/{number}")
        family, samples = SIZES[number % len(SIZES)]
        truth = Truth.drawn(base, chance)
        problem, factors = learned_problem(
            FAMILIES[family](samples, 20_000 + number).problem(base), truth, 50, chance
        )
        shortest = engine.plan(problem, PlanningRequest(effort_s=effort_s)).plan_net
        assert shortest is not None
        due = dict.fromkeys(problem.goals, shortest.makespan_s * chance.uniform(0.6, 1.1))
        stated = replace(problem, deadlines_s=due)
        shares: list[float] = []
        makespans: list[float] = []
        for objective in (Objective.MAKESPAN, Objective.ON_TIME):
            request = PlanningRequest(effort_s=effort_s, objective=objective)
            plan_net = engine.plan(stated, request).plan_net
            assert plan_net is not None
            times = executed(plan_net, stated, base, truth, factors, runs, number)
            shares.append(fmean(fmean(one[goal] <= due[goal] for goal in due) for one in times))
            makespans.append(plan_net.makespan_s)
        rows.append((*shares, *makespans, shares[1] - shares[0]))
    better = sum(row[4] > 0.01 for row in rows)
    worse = sum(row[4] < -0.01 for row in rows)
    yield (
        f"{len(rows)} stores with one deadline: goals in time {fmean(row[0] for row in rows):.1%} by the shortest "
        f"plan, {fmean(row[1] for row in rows):.1%} by on_time; better by over 1 % in {better}, worse in {worse}, "
        f"most {max(row[4] for row in rows):+.1%}; makespan {fmean(row[3] / row[2] for row in rows):.3f} times"
    )


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.punctuality", description=__doc__)
    parser.add_argument("--stores", type=int, default=60)
    parser.add_argument("--runs", type=int, default=200, help="executions of each plan")
    parser.add_argument("--effort", type=float, default=0.2, help="seconds to improve each plan")
    given = parser.parse_args()
    print("\n".join(table(list(cases(given.stores, given.runs, given.effort)))))
    print("\n".join(gains(given.stores // 2, given.runs, given.effort)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
