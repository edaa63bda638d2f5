"""Engines that are asked one after the other for a better plan."""

from collections.abc import Mapping

import pytest

from planner.engines.improving_portfolio import ImprovingPortfolio
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.problem.interface import (
    UNOBSERVED,
    Objective,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
)
from tests.planner.stepped_clock import SteppedClock

PROBLEM = PlanningProblem(objects={}, facts=frozenset(), goals=())


def plan(makespan_s: float, energy_j: float = 0.0) -> PlanNet:
    action = PlanNetAction(
        id="a1",
        tag="WAIT",
        arguments={},
        agents=("r1",),
        preconditions=(),
        deletes=(),
        intended_effects=(),
        other_effects=(),
        duration_s=makespan_s,
        energy_j=energy_j,
        description="",
        earliest_start_s=0.0,
        latest_start_s=0.0,
    )
    return PlanNet(goals=(), actions=(action,), causal_links=(), orderings=(), recruitment={})


class Improving:
    """An engine that finds a plan after some seconds, and better ones the longer it may improve.

    :param found: by seconds since its start, plans, each better than the one before.
    """

    def __init__(
        self, name: str, clock: SteppedClock, found: Mapping[float, PlanNet], bound_s: float | None = None
    ) -> None:
        self.name = name
        self._clock = clock
        self._found = found
        self._bound_s = bound_s
        self.asked: list[PlanningRequest] = []

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.asked.append(request)
        begun_s = self._clock()
        best: PlanNet | None = None
        end_s = request.time_limit_s
        for at_s, better in self._found.items():
            if at_s > end_s:
                break
            self._clock.now_s = begun_s + at_s
            if best is None and request.effort_s is not None:
                end_s = min(end_s, at_s + request.effort_s)
            best = better
            observer.progress(Progress(engine=self.name, elapsed_s=at_s, makespan_s=best.makespan_s))
        is_all = best is not None and best == list(self._found.values())[-1]
        if not is_all:
            self._clock.now_s = begun_s + end_s
        return PlanningResult(
            status=PlanningStatus.TIMED_OUT if best is None else PlanningStatus.SOLVED,
            engine=self.name,
            planning_s=0.0,
            plan_net=best,
            lower_bound_s=self._bound_s,
        )


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock()


def makespan_of(result: PlanningResult) -> float:
    assert result.plan_net is not None
    return result.plan_net.makespan_s


def test_the_best_plan_of_all_engines_is_the_answer(clock: SteppedClock) -> None:
    engines = [Improving(name, clock, {1.0: plan(span)}) for name, span in (("a", 15), ("b", 7), ("c", 9))]
    result = ImprovingPortfolio(engines).plan(PROBLEM, PlanningRequest(clock=clock))
    assert (result.engine, makespan_of(result)) == ("b", 7)
    assert result.planning_s == 3.0


def test_no_further_engine_is_asked_once_the_bound_is_reached(clock: SteppedClock) -> None:
    first = Improving("a", clock, {1.0: plan(15)}, bound_s=7.0)
    second = Improving("b", clock, {1.0: plan(7)})
    third = Improving("c", clock, {1.0: plan(7)})
    result = ImprovingPortfolio([first, second, third]).plan(PROBLEM, PlanningRequest(clock=clock))
    assert result.engine == "b"
    assert second.asked
    assert not third.asked


def test_without_effort_the_first_plan_is_the_answer(clock: SteppedClock) -> None:
    first, second = Improving("a", clock, {1.0: plan(15)}), Improving("b", clock, {1.0: plan(7)})
    result = ImprovingPortfolio([first, second]).plan(PROBLEM, PlanningRequest(clock=clock, effort_s=0.0))
    assert makespan_of(result) == 15
    assert not second.asked


def test_engines_share_the_effort_and_what_one_leaves(clock: SteppedClock) -> None:
    first = Improving("a", clock, {1.0: plan(15)})
    second = Improving("b", clock, {1.0: plan(14)})
    third = Improving("c", clock, {1.0: plan(13), 50.0: plan(12)})
    request = PlanningRequest(clock=clock, effort_s=9.0, time_limit_s=100.0)
    result = ImprovingPortfolio([first, second, third]).plan(PROBLEM, request)
    assert [asked.effort_s for asked in first.asked] == [0.0, 3.0]
    assert second.asked[0].effort_s == 4.0
    assert third.asked[0].effort_s == 7.0
    assert result.planning_s == 10.0


@pytest.mark.parametrize("limit_s", [3.0, 12.0])
def test_the_time_limit_is_kept(limit_s: float, clock: SteppedClock) -> None:
    engines = [Improving(name, clock, {1.0: plan(9), 99.0: plan(8)}) for name in ("a", "b", "c")]
    ImprovingPortfolio(engines).plan(PROBLEM, PlanningRequest(clock=clock, effort_s=60, time_limit_s=limit_s))
    assert clock() - 100.0 <= limit_s


def test_an_engine_that_finds_nothing_does_not_take_all_of_a_long_limit(clock: SteppedClock) -> None:
    engines = [Improving("a", clock, {1.0: plan(9)}), Improving("b", clock, {9999.0: plan(8)})]
    result = ImprovingPortfolio(engines).plan(PROBLEM, PlanningRequest(clock=clock, time_limit_s=3600.0))
    assert makespan_of(result) == 9
    assert clock() - 100.0 == 6.0


def test_more_effort_is_never_worse() -> None:
    def found(effort_s: float) -> float:
        clock = SteppedClock()
        engines = [
            Improving("a", clock, {0.5: plan(20), 1.0: plan(18), 4.0: plan(11)}),
            Improving("b", clock, {2.0: plan(15), 9.0: plan(8)}),
            Improving("c", clock, {1.0: plan(17), 3.0: plan(12), 16.0: plan(7)}),
        ]
        request = PlanningRequest(clock=clock, effort_s=effort_s, time_limit_s=200.0)
        return makespan_of(ImprovingPortfolio(engines).plan(PROBLEM, request))

    spans = [found(float(effort_s)) for effort_s in range(60)]
    assert spans == sorted(spans, reverse=True)
    assert (spans[0], spans[-1]) == (20, 7)


def test_of_least_energy_the_makespan_only_decides_among_equals(clock: SteppedClock) -> None:
    engines = [
        Improving("a", clock, {1.0: plan(9, 5)}, bound_s=9.0),
        Improving("b", clock, {1.0: plan(12, 4)}),
        Improving("c", clock, {1.0: plan(11, 4)}),
    ]
    request = PlanningRequest(clock=clock, objective=Objective.ENERGY)
    assert ImprovingPortfolio(engines).plan(PROBLEM, request).engine == "c"


def test_observers_hear_only_of_better_plans(clock: SteppedClock) -> None:
    heard: list[float] = []

    class Listening(Observer):
        def progress(self, progress: Progress) -> None:
            heard.extend([] if progress.makespan_s is None else [progress.makespan_s])

    engines = [Improving(name, clock, {1.0: plan(span)}) for name, span in (("a", 9), ("b", 12), ("c", 7))]
    ImprovingPortfolio(engines).plan(PROBLEM, PlanningRequest(clock=clock), Listening())
    assert heard == [9, 7]


def test_a_stop_is_answered_with_the_best_plan(clock: SteppedClock) -> None:
    class Stopping(Observer):
        def should_stop(self) -> bool:
            return clock() >= 102.0

    engines = [Improving(name, clock, {1.0: plan(span)}) for name, span in (("a", 9), ("b", 8), ("c", 7))]
    result = ImprovingPortfolio(engines).plan(PROBLEM, PlanningRequest(clock=clock), Stopping())
    assert makespan_of(result) == 8


def test_each_better_answer_is_given_as_it_is_found(clock: SteppedClock) -> None:
    engines = [Improving(name, clock, {1.0: plan(span)}) for name, span in (("a", 9), ("b", 12), ("c", 7))]
    request = PlanningRequest(clock=clock, effort_s=20.0)
    answers = ImprovingPortfolio(engines).answers(PROBLEM, request)
    assert makespan_of(next(answers)) == 9
    assert clock() - 100.0 == 1.0
    assert [makespan_of(answer) for answer in answers] == [7]


def test_an_engine_that_was_slow_to_find_a_plan_is_not_asked_again(clock: SteppedClock) -> None:
    first, second = Improving("a", clock, {5.0: plan(9)}), Improving("b", clock, {1.0: plan(7)})
    request = PlanningRequest(clock=clock, effort_s=9.0)
    assert makespan_of(ImprovingPortfolio([first, second]).plan(PROBLEM, request)) == 7
    assert len(first.asked) == 1
