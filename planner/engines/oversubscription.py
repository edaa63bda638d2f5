"""Optional goals: the subset that is worth most of those that can be achieved in time (oversubscription, Smith 2004).

Goals in the problem's `values` may be left out, each at the loss of what it is worth; the others must be achieved. A
subset can be achieved if the engine has a plan for it in which no goal is late: deadlines, soft otherwise, are hard for
what is optional.

Up to `EXACT_UP_TO` optional goals: branch and bound, best first. Subsets are taken in the order of their value, so the
first that has a plan is the best, and all of lower value need no look. A subset is cut off, with all that contain it,
if the proven lower bound of the makespan (`planner.bounds`) of its goals with deadlines exceeds the last of these: what
achieves more goals takes no less time. It is exact but for the engine, which may miss a plan that exists. Beyond, or
when the time is up: goals are added by value per additional second, and goals left out are exchanged for some taken
as long as that gains (our choice).
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations

from planner.bounds import lower_bound_s
from planner.engines.wrapping import TimeProgress, WrappingEngine
from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.problem.interface import (
    UNOBSERVED,
    LeftOut,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.preference import PreferenceChoice, judged
from planner.problem.solving import ROUNDING_S, TimeLimitedEngine

EXACT_UP_TO = 10
"""Optional goals of which every subset is considered."""
EXACT_SHARE = 0.6
"""The share of the time limit after which subsets are no longer considered in the order of their values."""
SEARCH_SHARE = 0.8
"""The share of the time limit after which no further subset is tried; the rest is for the chosen one's plan."""
OUT_OF_TIME = "the time for planning was up"
VALUE_ROUNDING = 1e-9

Subset = frozenset[Fact]


class OversubscriptionEngine(WrappingEngine):
    """An engine that also chooses among optional goals; without any it answers as the engine does.

    Implements `PlanningEngine`.
    """

    def __init__(
        self, engine: PlanningEngine, knowledge_base: KnowledgeBase, *, exact_up_to: int = EXACT_UP_TO
    ) -> None:
        super().__init__(engine, knowledge_base)
        self._exact_up_to = exact_up_to

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """The plan of the best subset, and what it leaves out; why not even the other goals have a plan, if so."""
        if not problem.values:
            return self._engine.plan(problem, request, observer)
        search = _Search(self._engine, self._base, problem, request, observer)
        return search.result(self._exact_up_to)


class _Search:
    """The choice among the optional goals of one problem."""

    def __init__(
        self,
        engine: PlanningEngine,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        request: PlanningRequest,
        observer: Observer,
    ) -> None:
        self._engine = engine
        self._base = knowledge_base
        self._problem = problem
        self._request = request
        self._observer = observer
        self._values = {goal: problem.values[goal] for goal in problem.goals if goal in problem.values}
        self._optional = sorted(self._values, key=lambda goal: (-self._values[goal], goal))
        self._trials = TimeLimitedEngine(engine, request, TimeProgress(observer))
        self._known: dict[Subset, PlanningResult] = {}
        self._bounds: dict[Subset, bool] = {}
        self._impossible: list[Subset] = []

    def result(self, exact_up_to: int) -> PlanningResult:
        none = frozenset[Fact]()
        least = self._tried(none)
        if least.plan_net is None:
            return least
        if least.plan_net.late:
            late_s = max(least.plan_net.late.values())
            return self._concluded(
                none, 0.0, lambda _: f"what is not optional is {late_s:.0f} s late already"
            )
        chosen = self._greedy()
        bound = sum(self._values.values())
        if len(self._optional) <= exact_up_to:
            chosen, bound = self._exact(chosen)
        else:
            chosen = self._improved(chosen)
        return self._concluded(chosen, bound, lambda goal: self._why(goal, chosen))

    def _exact(self, known: Subset) -> tuple[Subset, float]:
        """The best subset, and what none is worth more than; `known` one that can be achieved."""
        least = self._value(known)
        subsets = [
            frozenset(some)
            for size in range(1, len(self._optional) + 1)
            for some in combinations(self._optional, size)
        ]
        better = [some for some in subsets if self._value(some) > least + VALUE_ROUNDING]
        for some in sorted(better, key=lambda some: (-self._value(some), len(some))):
            if self._is_over(EXACT_SHARE):
                return self._improved(known), self._value(some)
            if not self._is_ruled_out(some) and self._is_achieved(some):
                return some, self._value(some)
        return known, least

    def _greedy(self) -> Subset:
        """Goals added by value per second that they add alone."""
        none = frozenset[Fact]()
        if self._is_achieved(everything := frozenset(self._optional)):
            return everything
        base_s = self._makespan_s(none)
        possible = [goal for goal in self._optional if self._is_achieved(frozenset({goal}))]
        added_s = {goal: max(self._makespan_s(frozenset({goal})) - base_s, 1.0) for goal in possible}
        chosen = none
        for goal in sorted(possible, key=lambda goal: (-self._values[goal] / added_s[goal], goal)):
            if self._is_over(SEARCH_SHARE):
                break
            if self._is_achieved(chosen | {goal}):
                chosen |= {goal}
        return chosen

    def _improved(self, chosen: Subset) -> Subset:
        """Goals left out are taken, in exchange for at most two, while that gains."""
        while (better := next(self._exchanges(chosen), None)) is not None:
            chosen = better
        return chosen

    def _exchanges(self, chosen: Subset) -> Iterator[Subset]:
        """The subsets that can be achieved and gain by one goal more and at most two less."""
        for goal in self._optional:
            if goal in chosen:
                continue
            for count in range(3):
                for gone in combinations(sorted(chosen), count):
                    if self._is_over(SEARCH_SHARE):
                        return
                    gain = self._values[goal] - sum(self._values[one] for one in gone)
                    exchanged = (chosen | {goal}).difference(gone)
                    if gain > VALUE_ROUNDING and self._is_achieved(exchanged):
                        yield exchanged

    def _is_over(self, share: float) -> bool:
        timer = self._trials.timer
        return self._trials.is_over or timer.elapsed_s > share * self._request.time_limit_s

    def _value(self, some: Subset) -> float:
        return sum(self._values[goal] for goal in self._optional if goal in some)

    def _is_achieved(self, some: Subset) -> bool:
        """True if the engine has a plan for the subset and all that is not optional, with nothing late."""
        if self._is_ruled_out(some):
            return False
        plan_net = self._tried(some).plan_net
        return plan_net is not None and not plan_net.late

    def _is_ruled_out(self, some: Subset) -> bool:
        """True if it is proven that there is no such plan."""
        if any(known <= some for known in self._impossible):
            return True
        if some not in self._bounds:
            stated = self._stated(some)
            due = tuple(goal for goal in stated.goals if goal in stated.deadlines_s)
            last_s = max((stated.deadlines_s[goal] for goal in due), default=0.0)
            timely = replace(stated, goals=due, stages={})
            self._bounds[some] = bool(due) and lower_bound_s(self._base, timely) > last_s + ROUNDING_S
            if self._bounds[some]:
                self._impossible.append(some)
        return self._bounds[some]

    def _tried(self, some: Subset) -> PlanningResult:
        """The engine's first plan for the subset; improved if that is late."""
        if some not in self._known:
            stated = self._stated(some)
            result = self._planned(stated, effort_s=0.0)
            is_late = result.plan_net is not None and bool(result.plan_net.late)
            if is_late and self._request.effort_s != 0.0 and not self._trials.is_over:
                result = self._planned(stated, effort_s=self._request.effort_s)
            if result.status is PlanningStatus.UNSOLVABLE:
                self._impossible.append(some)
            self._known[some] = result
        return self._known[some]

    def _planned(self, stated: PlanningProblem, effort_s: float | None) -> PlanningResult:
        request = replace(self._request, effort_s=effort_s, time_limit_s=max(self._trials.timer.left_s, 0.05))
        return self._engine.plan(stated, request, TimeProgress(self._observer))

    def _stated(self, some: Subset) -> PlanningProblem:
        """The problem of the subset and all that is not optional."""
        goals = tuple(goal for goal in self._problem.goals if goal not in self._values or goal in some)
        return replace(self._problem, goals=goals, values={}, preferences=())

    def _makespan_s(self, some: Subset) -> float:
        plan_net = self._tried(some).plan_net
        return 0.0 if plan_net is None else plan_net.makespan_s

    def _concluded(self, chosen: Subset, bound: float, why: Callable[[Fact], str]) -> PlanningResult:
        """The chosen subset's plan, as good as the time allows."""
        left_out = self._left_out(chosen, why)
        first = self._known[chosen]
        preferences = self._problem.preferences  # what goals are worth comes before them
        result = self._trials.plan_if_time(replace(self._stated(chosen), preferences=preferences))
        if result is None or result.plan_net is None or (result.plan_net.late and not _is_late(first)):
            result = first
            if preferences and first.plan_net is not None:
                outcomes = judged(preferences, first.plan_net, otherwise=OUT_OF_TIME)
                result = replace(first, preferences=PreferenceChoice(outcomes=outcomes, is_cut_short=True))
        seconds = round(self._trials.timer.elapsed_s, 4)
        if result.plan_net is not None and not result.plan_net.goals:
            reasons = "; ".join(f"{one.goal}: {one.reason}" for one in left_out)
            return PlanningResult(
                status=PlanningStatus.NOT_FOUND,
                engine=result.engine,
                planning_s=seconds,
                reason=f"none of the optional goals can be achieved: {reasons}",
                left_out=left_out,
            )
        return replace(
            result,
            planning_s=seconds,
            value=self._value(chosen),
            value_bound=bound,
            left_out=left_out,
        )

    def _left_out(self, chosen: Subset, why: Callable[[Fact], str]) -> tuple[LeftOut, ...]:
        return tuple(
            LeftOut(goal=goal, value=self._values[goal], reason=why(goal))
            for goal in self._optional
            if goal not in chosen
        )

    def _why(self, goal: Fact, chosen: Subset) -> str:
        """Why a goal is left out, in words."""
        alone = self._known.get(frozenset({goal}))
        if alone is not None and alone.plan_net is None:
            return alone.reason or alone.status.value
        if self._is_ruled_out(frozenset({goal})):
            return "no plan is quick enough for it"
        beside = frozenset({*chosen, goal})
        if self._is_ruled_out(beside):
            return "no plan is quick enough for it and what is worth more"
        tried = self._known.get(beside)
        if tried is None:
            return OUT_OF_TIME
        if tried.plan_net is None:
            return f"beside what is worth more: {tried.reason or tried.status.value}"
        late = tried.plan_net.late
        return f"with it a goal would be {max(late.values()):.0f} s late" if late else "it gains nothing"


def _is_late(result: PlanningResult) -> bool:
    return result.plan_net is not None and bool(result.plan_net.late)
