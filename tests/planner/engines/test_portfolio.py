"""Several engines as one."""

from collections.abc import Callable

import pytest

from planner.engines.portfolio import Portfolio
from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import (
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
)

PROBLEM = PlanningProblem(objects={}, facts=frozenset(), goals=())
PLAN = PlanNet(goals=(), actions=(), causal_links=(), orderings=(), recruitment={})


class Fake:
    """An engine that answers what it is told to, and keeps what it was asked."""

    def __init__(
        self,
        name: str,
        status: PlanningStatus,
        *,
        reason: str = "",
        bound_s: float | None = None,
        during: Callable[[Observer], None] = lambda _: None,
    ) -> None:
        self.name = name
        self._during = during
        self._answer = PlanningResult(
            status=status,
            engine=name,
            planning_s=0.0,
            plan_net=PLAN if status is PlanningStatus.SOLVED else None,
            reason=reason,
            lower_bound_s=bound_s,
        )
        self.requests: list[PlanningRequest] = []
        self.is_warm = False

    def warm_up(self) -> None:
        self.is_warm = True

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer | None = None
    ) -> PlanningResult:
        self.requests.append(request)
        self._during(observer or Observer())
        return self._answer


class Watching(Observer):
    def __init__(self) -> None:
        self.seen: list[Progress] = []
        self.enough = False

    def progress(self, progress: Progress) -> None:
        self.seen.append(progress)

    def should_stop(self) -> bool:
        return self.enough


class Broken:
    name = "broken"

    def warm_up(self) -> None:
        raise ZeroDivisionError("a slip")

    def plan(self, *_: object) -> PlanningResult:
        raise ZeroDivisionError("a slip")


NOTHING = [
    PlanningStatus.NOT_FOUND,
    PlanningStatus.TIMED_OUT,
    PlanningStatus.OUT_OF_MEMORY,
    PlanningStatus.FAILED,
]


def test_the_first_plan_found_is_the_answer_and_no_further_engine_is_asked() -> None:
    first = Fake("ours", PlanningStatus.SOLVED)
    second = Fake("other", PlanningStatus.SOLVED)
    result = Portfolio([first, second]).plan(PROBLEM, PlanningRequest())
    assert (result.status, result.engine, result.plan_net) == (PlanningStatus.SOLVED, "ours", PLAN)
    assert second.requests == []


@pytest.mark.parametrize("nothing", NOTHING)
def test_the_next_engine_is_asked_where_one_found_nothing(nothing: PlanningStatus) -> None:
    first = Fake("ours", nothing, reason="no luck")
    second = Fake("other", PlanningStatus.SOLVED)
    result = Portfolio([first, second]).plan(PROBLEM, PlanningRequest())
    assert (result.status, result.engine) == (PlanningStatus.SOLVED, "other")
    assert "ours" in result.reason
    assert "no luck" in result.reason


def test_a_proof_that_there_is_no_plan_ends_it() -> None:
    second = Fake("other", PlanningStatus.SOLVED)
    proof = Fake("ours", PlanningStatus.UNSOLVABLE, reason="no robot reaches bay_13")
    result = Portfolio([proof, second]).plan(PROBLEM, PlanningRequest())
    assert (result.status, result.reason) == (PlanningStatus.UNSOLVABLE, "no robot reaches bay_13")
    assert second.requests == []


@pytest.mark.parametrize("nothing", NOTHING)
def test_without_a_proof_it_is_never_called_unsolvable(nothing: PlanningStatus) -> None:
    engines = [Fake("ours", PlanningStatus.NOT_FOUND), Fake("other", nothing, reason="why")]
    result = Portfolio(engines).plan(PROBLEM, PlanningRequest())
    assert result.status not in (PlanningStatus.UNSOLVABLE, PlanningStatus.SOLVED)
    assert "does not prove" in result.reason
    assert "why" in result.reason


def test_an_answer_without_plan_or_proof_names_the_missing_engines_and_how_to_get_them() -> None:
    result = Portfolio([Fake("ours", PlanningStatus.NOT_FOUND)], missing=["other"]).plan(
        PROBLEM, PlanningRequest()
    )
    assert "not installed: other" in result.reason
    assert "macta[engines]" in result.reason


@pytest.mark.parametrize("status", [PlanningStatus.SOLVED, PlanningStatus.UNSOLVABLE, PlanningStatus.FAILED])
def test_missing_engines_are_not_named_where_none_would_help(status: PlanningStatus) -> None:
    engines = [Fake("ours", status, reason="bay_99 is unknown")]
    result = Portfolio(engines, missing=["other"]).plan(PROBLEM, PlanningRequest())
    assert "not installed" not in result.reason


def test_a_reason_that_all_engines_give_is_given_once() -> None:
    engines = [Fake(name, PlanningStatus.FAILED, reason="bay_99 is unknown") for name in ("one", "two")]
    result = Portfolio(engines).plan(PROBLEM, PlanningRequest())
    assert result.status is PlanningStatus.FAILED
    assert result.reason.count("bay_99") == 1


def test_the_time_is_shared_and_the_last_engine_has_all_that_is_left() -> None:
    engines = [Fake(name, PlanningStatus.NOT_FOUND) for name in ("one", "two", "three")]
    Portfolio(engines).plan(PROBLEM, PlanningRequest(time_limit_s=80, seed=7))
    shares = [engine.requests[0].time_limit_s for engine in engines]
    assert shares == pytest.approx([40, 40, 80], abs=1)
    assert {engine.requests[0].seed for engine in engines} == {7}


def test_no_further_engine_is_asked_once_it_is_to_stop() -> None:
    watching = Watching()
    first = Fake("ours", PlanningStatus.NOT_FOUND, during=lambda _: setattr(watching, "enough", True))
    second = Fake("other", PlanningStatus.SOLVED)
    result = Portfolio([first, second]).plan(PROBLEM, PlanningRequest(), watching)
    assert second.requests == []
    assert result.status is PlanningStatus.NOT_FOUND
    assert "stopped" in result.reason


def test_the_best_bound_of_all_engines_is_kept_and_reported() -> None:
    watching = Watching()
    engines = [
        Fake("one", PlanningStatus.TIMED_OUT, bound_s=30.0),
        Fake(
            "two",
            PlanningStatus.SOLVED,
            bound_s=20.0,
            during=lambda o: o.progress(
                Progress(engine="two", elapsed_s=0.1, makespan_s=44.0, lower_bound_s=10.0)
            ),
        ),
    ]
    result = Portfolio(engines).plan(PROBLEM, PlanningRequest(), watching)
    assert result.lower_bound_s == 30.0
    assert (watching.seen[-1].makespan_s, watching.seen[-1].lower_bound_s) == (44.0, 30.0)
    assert [progress.engine for progress in watching.seen] == ["one", "two", "two"]


def test_an_engine_with_a_defect_does_not_keep_the_others_from_planning() -> None:
    result = Portfolio([Broken(), Fake("other", PlanningStatus.SOLVED)]).plan(PROBLEM, PlanningRequest())
    assert result.plan_net == PLAN
    assert "a slip" in result.reason


def test_all_engines_are_warmed_that_can_be() -> None:
    fake = Fake("ours", PlanningStatus.SOLVED)
    Portfolio([Broken(), fake]).warm_up()
    assert fake.is_warm


def test_a_portfolio_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one"):
        Portfolio([])
