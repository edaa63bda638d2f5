"""Preferences: the plan with the smallest sum of makespan and costs of broken preferences (Gerevini et al. 2009).

A combination of preferences is planned as constraints: without the facts that they withhold. What the plan breaks is
then counted by its actions. Combinations are tried best first, by their costs and an estimate of the makespan: the
longest that was found, or proven, for fewer of their preferences, as who keeps more takes no less time. A combination
is cut off if its costs and the proven lower bound (`planner.bounds`) are no less than the best sum found, or if there
is proven to be no plan for some of its preferences (`planner.relaxation`); it is not tried either if the engine found
none for these. If no combination is left but such that the estimate rules out, up to `CHECKED` are tried nevertheless,
for the engine's plans are not always the shortest.

Deadlines come first: a plan that is less late is preferred whatever it costs.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

from planner.bounds import lower_bound_s
from planner.engines.wrapping import TimeProgress, WrappingEngine
from planner.explanation.diagnosis import why_unsolvable
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import PlanNet
from planner.problem.choices import keeping
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.preference import (
    MAX_PREFERENCES,
    Preference,
    PreferenceChoice,
    PreferenceOutcome,
    broken_cost_s,
)
from planner.problem.solving import ROUNDING_S, TimeLimitedEngine
from planner.relaxation import is_relaxed_reachable

MAX_TRIES = 64
"""The most combinations that are tried."""
CHECKED = 16
"""The number of combinations that are tried though none is estimated to be better than the best found."""
SEARCH_SHARE = 0.7
"""The share of the time limit after which no further combination is tried; the rest is for the reasons."""

Kept = frozenset[int]
"""A combination: the positions of the preferences that are to be kept."""


class PreferenceEngine(WrappingEngine):
    """An engine that also chooses which preferences to keep; without any it answers as the engine does.

    Implements `PlanningEngine`.
    """

    def __init__(
        self, engine: PlanningEngine, knowledge_base: KnowledgeBase, *, max_tries: int = MAX_TRIES
    ) -> None:
        super().__init__(engine, knowledge_base)
        self._max_tries = max_tries

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """The plan of the best combination, and which preferences it keeps; if there is no plan at all, why.

        :raises ValueError: if the problem has more than `MAX_PREFERENCES`.
        """
        if not problem.preferences:
            return self._engine.plan(problem, request, observer)
        if len(problem.preferences) > MAX_PREFERENCES:
            raise ValueError(f"{len(problem.preferences)} preferences are more than {MAX_PREFERENCES}")
        return _Search(self._engine, self._base, problem, request, observer, self._max_tries).result()


class _Search:
    """The choice among the preferences of one problem."""

    def __init__(
        self,
        engine: PlanningEngine,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        request: PlanningRequest,
        observer: Observer,
        max_tries: int,
    ) -> None:
        self._base = knowledge_base
        self._problem = problem
        self._preferences = problem.preferences
        self._request = request
        self._every: list[Kept] = [
            frozenset(some)
            for size in range(len(self._preferences) + 1)
            for some in combinations(range(len(self._preferences)), size)
        ]
        self._max_tries = max_tries
        effort_s = request.effort_s and request.effort_s / min(len(self._every), max_tries)
        quiet = TimeProgress(observer)
        self._trials = TimeLimitedEngine(engine, replace(request, effort_s=effort_s), quiet)
        self._engine = engine
        self._observer = quiet
        self._tried: dict[Kept, PlanningResult] = {}
        self._bounds: dict[Kept, float] = {}
        self._reached: set[Kept] = set()
        self._impossible: dict[Kept, str] = {}
        """Smallest known combinations for which there is proven to be no plan, and why if the engine has told."""

    def result(self) -> PlanningResult:
        none: Kept = frozenset()
        least = self._trials.plan(keeping(self._problem, ()))
        self._learn(none, least)
        if least.plan_net is None:
            return least
        every = frozenset(range(len(self._preferences)))
        if self._has_time() and not self._is_ruled_out(every):
            self._try(every)
        while self._has_time() and (some := self._next()) is not None:
            self._try(some)
        is_cut_short = any(self._estimate_s(some) < self._least_s() - ROUNDING_S for some in self._open())
        best = self._with_neighbours()
        result = self._improved(best)
        assert result.plan_net is not None
        choice = PreferenceChoice(
            outcomes=tuple(self._outcomes(result.plan_net)),
            bound_s=round(min(self._floor_s(some) + self._cost_s(some) for some in self._possible()), 3),
            is_cut_short=is_cut_short,
        )
        return replace(result, planning_s=round(self._trials.timer.elapsed_s, 4), preferences=choice)

    def _has_time(self) -> bool:
        used_up = self._trials.timer.elapsed_s > SEARCH_SHARE * self._request.time_limit_s
        return len(self._tried) < self._max_tries and not used_up and not self._trials.is_over

    def _next(self) -> Kept | None:
        """The combination to try next; None if none is worth it."""
        while candidates := list(self._open()):
            some = min(candidates, key=lambda one: (self._estimate_s(one), self._cost_s(one)))
            is_promising = self._estimate_s(some) < self._least_s() - ROUNDING_S
            if not is_promising and len(self._tried) >= CHECKED:
                return None
            if self._is_ruled_out(some):
                continue
            if some in self._bounds or self._request.effort_s != 0.0:
                return some  # the engine's answer brings the bound
            self._bounds[some] = lower_bound_s(self._base, self._stated(some))
        return None

    def _open(self) -> Iterator[Kept]:
        """The combinations that may be better than the best found, as far as is proven."""
        late_s, least_s = self._merit(self._best())
        failed = [some for some, result in self._tried.items() if result.plan_net is None]
        for some in self._possible():
            if some in self._tried or any(fewer <= some for fewer in failed):
                continue
            if late_s > ROUNDING_S or self._floor_s(some) + self._cost_s(some) < least_s - ROUNDING_S:
                yield some

    def _possible(self) -> list[Kept]:
        """The combinations for which it is not proven that there is no plan."""
        return [some for some in self._every if not self._is_impossible(some)]

    def _is_impossible(self, some: Kept) -> bool:
        """True if it is known to be proven that no plan keeps these."""
        return any(none <= some for none in self._impossible)

    def _is_ruled_out(self, some: Kept) -> bool:
        """True if it is proven, quickly, that no plan keeps these; the smallest such part of them is noted."""
        if self._is_impossible(some):
            return True
        if any(some <= more for more in self._reached):
            return False
        if is_relaxed_reachable(self._base, self._stated(some)):
            self._reached.add(some)
            return False
        for place in sorted(some):
            if not is_relaxed_reachable(self._base, self._stated(some - {place})):
                some -= {place}
        self._impossible[some] = ""
        return True

    def _try(self, some: Kept) -> None:
        result = self._trials.plan_if_time(self._stated(some))
        if result is None:
            result = PlanningResult(
                status=PlanningStatus.TIMED_OUT, engine="", planning_s=0.0, reason="the time was up"
            )
        self._learn(some, result)

    def _learn(self, some: Kept, result: PlanningResult) -> None:
        self._tried[some] = result
        if result.status is PlanningStatus.UNSOLVABLE:
            self._impossible[some] = result.reason
        elif result.lower_bound_s is not None:
            self._bounds[some] = result.lower_bound_s
        elif some not in self._bounds and result.plan_net is not None:
            self._bounds[some] = lower_bound_s(self._base, self._stated(some))

    def _stated(self, some: Kept) -> PlanningProblem:
        return keeping(self._problem, (self._preferences[place] for place in some))

    def _cost_s(self, some: Kept) -> float:
        """What the preferences that are not to be kept cost."""
        return sum(
            preference.cost_s for place, preference in enumerate(self._preferences) if place not in some
        )

    def _floor_s(self, some: Kept) -> float:
        """The proven lower bound of the makespan of plans that keep these preferences."""
        return max((bound_s for fewer, bound_s in self._bounds.items() if fewer <= some), default=0.0)

    def _estimate_s(self, some: Kept) -> float:
        """The sum of costs and makespan if no plan found for fewer of the preferences can be made shorter."""
        found = [
            net.makespan_s
            for fewer, result in self._tried.items()
            if fewer <= some and (net := result.plan_net) is not None
        ]
        return self._cost_s(some) + max(self._floor_s(some), *found)

    def _merit(self, result: PlanningResult) -> tuple[float, float]:
        """Seconds of lateness, and the sum that is to be small."""
        plan_net = result.plan_net
        assert plan_net is not None
        return plan_net.late_s, plan_net.makespan_s + broken_cost_s(self._preferences, plan_net)

    def _best(self) -> PlanningResult:
        found = [result for result in self._tried.values() if result.plan_net is not None]
        return min(found, key=self._merit)

    def _least_s(self) -> float:
        return self._merit(self._best())[1]

    def _kept(self, plan_net: PlanNet) -> Kept:
        return frozenset(
            place for place, preference in enumerate(self._preferences) if preference.is_kept_by(plan_net)
        )

    def _with_neighbours(self) -> PlanningResult:
        """The best plan, once each preference that it breaks has been tried beside those that it keeps."""
        while not self._trials.is_over:
            best = self._best()
            assert best.plan_net is not None
            kept = self._kept(best.plan_net)
            beside = [kept | {place} for place in range(len(self._preferences)) if place not in kept]
            untried = [some for some in beside if some not in self._tried and not self._is_ruled_out(some)]
            if not untried:
                break
            for some in untried:
                self._try(some)
        return self._best()

    def _improved(self, best: PlanningResult) -> PlanningResult:
        """The best plan, or a better one by all of the effort that the request allows."""
        if not self._request.effort_s or self._trials.is_over or best.plan_net is None:
            return best
        request = replace(self._request, time_limit_s=self._trials.timer.left_s)
        stated = self._stated(self._kept(best.plan_net))
        again = self._engine.plan(stated, request, self._observer)
        return again if again.plan_net is not None and self._merit(again) < self._merit(best) else best

    def _outcomes(self, plan_net: PlanNet) -> Iterator[PreferenceOutcome]:
        kept = self._kept(plan_net)
        for place, preference in enumerate(self._preferences):
            if place in kept:
                yield PreferenceOutcome(words=preference.words, cost_s=preference.cost_s, is_kept=True)
            else:
                yield self._broken(place, preference, kept, plan_net)

    def _broken(self, place: int, preference: Preference, kept: Kept, plan_net: PlanNet) -> PreferenceOutcome:
        """Why a preference is broken: what keeping it beside those kept would cost at least."""
        beside = kept | {place}
        result = self._tried.get(beside)
        other = None if result is None else result.plan_net
        least_s = max(round(self._floor_s(beside) - plan_net.makespan_s, 3), 0.0)
        outcome = PreferenceOutcome(
            words=preference.words, cost_s=preference.cost_s, is_kept=False, longer_at_least_s=least_s
        )
        proven = min((some for some in self._impossible if some <= beside), key=len, default=None)
        at_least = f"every plan that keeps it takes {least_s:.1f} s longer at least"
        if proven is not None:
            others = " and ".join(self._preferences[one].words for one in sorted(proven - {place}))
            together = f" beside “{others}”" if others else ""
            why = self._impossible[proven] or why_unsolvable(self._base, self._stated(proven))
            return replace(outcome, reason=f"no plan keeps it{together}: {why}")
        if other is None:
            missing = "it was not tried: the time for planning was up"
            if result is not None:
                missing = f"no plan that keeps it was found: {result.reason or result.status.value}"
            return replace(outcome, reason=f"{missing}; {at_least}" if least_s else missing)
        late_s = other.late_s - plan_net.late_s
        longer_s = round(other.makespan_s - plan_net.makespan_s, 3)
        if late_s > ROUNDING_S:
            words = f"goals would be {late_s:.1f} s later than their deadlines in the shortest plan found that keeps it"
        elif not preference.is_kept_by(other):
            words = "no plan that keeps it was found"
        else:
            words = f"the shortest plan found that keeps it takes {longer_s:.1f} s longer"
            outcome = replace(outcome, longer_s=longer_s)
        return replace(outcome, reason=f"{words}; {at_least}" if least_s else words)
