"""The objective `on_time`: among near-equal plans the one by which most goals are expected to keep their deadlines.

An engine schedules by expected durations, so it finds the plan that is shortest if all goes as expected. That plan may
hang on an action whose duration varies a lot, or on many couplings, each of which passes the latest of several delays
on. Here the engine is asked several times for plans that differ, each is judged by its forecast
(`planner.plan_nets.completion`), and the best is taken. The candidates (our choice):

- the shortest plan, which is today's;
- the plans that are shortest if every kind of action takes one, and two, standard deviations longer than expected: they
  avoid kinds that vary, and keep their distance from deadlines;
- the one with the fewest robots, which has the fewest couplings;
- the shortest without each of the busiest robots, and by other seeds.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import exp, sqrt

import numpy as np
import numpy.typing as npt

from planner.engines.hierarchical.tasks import PRIORITY_SCALE
from planner.engines.plan_net_completion import complete_plan_net, confirm, merit
from planner.engines.replenishment import Replenishment
from planner.engines.wrapping import FirstProgress, WrappingEngine
from planner.errors import InvalidPlan, KnowledgeBaseError
from planner.explanation.recruiting import recruitment_of, robots_by_work
from planner.knowledge import scale_term
from planner.plan_nets.completion import completion_samples
from planner.plan_nets.forecast import PRIOR_SPREAD
from planner.plan_nets.plan_net import PlanNet
from planner.plan_nets.validation import linearisation
from planner.problem.interface import (
    UNOBSERVED,
    Objective,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    Progress,
)
from planner.problem.solving import TimeLimitedEngine
from planner.problem.static_facts import StaticFacts
from planner.problem.zones import ground_again

DEVIATIONS = (1.0, 2.0)
"""By how many standard deviations durations are prolonged."""
SPARED = 2
"""How many of the busiest robots are done without in turn."""
SEEDS = (1, 2)
"""Added to the request's seed."""
SETTLED = 0.995
"""Once this share of what can be on time is expected to be, no further plan is sought."""
LEAST_GAIN = 0.005
"""A longer plan is preferred if this share more is expected to be on time, and two standard errors more."""


class OnTimeEngine(WrappingEngine):
    """An engine with the objective `on_time`; by other objectives, or without deadlines, it answers as the engine does.

    Implements `PlanningEngine`.
    """

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """The engine's answer with the plan that is chosen; the bound remains that of the makespan."""
        if request.objective is not Objective.ON_TIME:
            return self._engine.plan(problem, request, observer)
        relay = FirstProgress(observer)
        planner = TimeLimitedEngine(self._engine, replace(request, objective=Objective.MAKESPAN), relay)
        answer = planner.plan(problem)
        if answer.plan_net is None or not problem.deadlines_s.keys() & set(problem.goals):
            return answer
        relay.is_first = False
        choice = _Choice(problem, answer.plan_net)
        candidates = self._candidates(problem, answer.plan_net, planner, request.seed)
        while not choice.is_settled and (plan_net := next(candidates, None)) is not None:
            choice.consider(plan_net)
            observer.progress(
                Progress(
                    engine=self.name,
                    elapsed_s=round(planner.timer.elapsed_s, 3),
                    makespan_s=choice.best.makespan_s,
                    lower_bound_s=answer.lower_bound_s,
                )
            )
        return replace(answer, plan_net=choice.best, planning_s=round(planner.timer.elapsed_s, 4))

    def _candidates(
        self, problem: PlanningProblem, shortest: PlanNet, planner: TimeLimitedEngine, seed: int
    ) -> Iterator[PlanNet]:
        """Plans of the problem, as long as there is time."""
        statics = StaticFacts(self._base, problem)
        for deviations in DEVIATIONS:
            result = planner.plan_if_time(self._prolonged(problem, deviations))
            if result is None:
                return
            if result.plan_net is not None and (timed := self._timed(result.plan_net, problem)) is not None:
                yield timed
        tried = [(problem, Objective.ROBOTS, seed)]
        spared = [robot for robot in robots_by_work(shortest) if robot in statics.robots][:SPARED]
        tried += [(statics.without({robot}), Objective.MAKESPAN, seed) for robot in spared]
        tried += [(problem, Objective.MAKESPAN, seed + more) for more in SEEDS]
        for varied, objective, number in tried:
            result = planner.plan_if_time(varied, objective, seed=number)
            if result is None:
                return
            if result.plan_net is not None:
                yield replace(result.plan_net, recruitment=recruitment_of(result.plan_net.actions, statics))

    def _prolonged(self, problem: PlanningProblem, deviations: float) -> PlanningProblem:
        """The problem with each kind of action longer by this number of standard deviations."""
        kinds = {(op.spec.name, len(op.agents)) for op in self._base.operators}
        scales = {
            scale_term(*kind): problem.functions.get(scale_term(*kind), 1.0)
            * (1.0 + deviations * problem.spreads.get(kind, PRIOR_SPREAD).relative)
            for kind in kinds
        }
        return replace(problem, functions={**problem.functions, **scales})

    def _timed(self, plan_net: PlanNet, problem: PlanningProblem) -> PlanNet | None:
        """What a plan-net does, with the durations of the problem; None if that is no plan."""
        whole = replace(problem, goals=plan_net.goals)
        try:
            sequence = [ground_again(action, whole, self._base) for action in linearisation(plan_net)]
            timed = complete_plan_net(sequence, whole, self._base, StaticFacts(self._base, whole))
            supplied = (
                Replenishment(whole, self._base).supplied(timed) if isinstance(timed, PlanNet) else None
            )
            if not isinstance(supplied, PlanNet):
                return None
            confirm(supplied, whole, self._base)
        except (InvalidPlan, KnowledgeBaseError):
            return None
        return supplied


class _Choice:
    """The best plan-net so far by the weight of goals that are expected to be on time."""

    def __init__(self, problem: PlanningProblem, first: PlanNet) -> None:
        self._spreads = problem.spreads
        self._due = {
            goal: (problem.deadlines_s[goal], exp(problem.priorities.get(goal, 0) / PRIORITY_SCALE))
            for goal in problem.goals
            if goal in problem.deadlines_s
        }
        self._whole = sum(weight for _, weight in self._due.values())
        self.best = first
        self._on_time = self._kept(first)

    @property
    def is_settled(self) -> bool:
        """True if hardly anything can be gained."""
        return float(self._on_time.mean()) >= SETTLED

    def consider(self, plan_net: PlanNet) -> None:
        """Take the plan-net if clearly more is on time, or as much and it is better otherwise."""
        kept = self._kept(plan_net)
        gain = kept - self._on_time
        mean = float(gain.mean())
        error = float(gain.std()) / sqrt(len(gain))
        least = max(LEAST_GAIN, 2.0 * error)
        if mean > least or (mean >= 0.0 and merit(plan_net) < merit(self.best)):
            self.best = plan_net
            self._on_time = kept

    def _kept(self, plan_net: PlanNet) -> npt.NDArray[np.float64]:
        """The share of the weight that is on time in each sample, shape (samples,)."""
        times = completion_samples(plan_net, self._spreads)
        kept = [weight * (times[goal] <= due_s) for goal, (due_s, weight) in self._due.items()]
        share: npt.NDArray[np.float64] = np.sum(kept, axis=0) / self._whole
        return share
