"""The constraints that leave no plan, found by leaving them out one by one."""

from collections.abc import Collection, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner import (
    UNOBSERVED,
    Fact,
    Observer,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.explanation.conflict import Restriction, RestrictionConflict, conflict_among
from tests.planner.stepped_clock import SteppedClock

NAMES = "abcdef"
EMPTY = PlanNet(goals=(), actions=(), causal_links=(), orderings=(), recruitment={})


def restriction(name: str) -> Restriction:
    return Restriction(words=f"without {name}", withheld=frozenset({Fact(name)}))


FREE = PlanningProblem(objects={}, facts=frozenset(map(Fact, NAMES)), goals=())
ALL = [restriction(name) for name in NAMES]


class Contradicting:
    """Has no plan if all facts of one of some sets are withheld; counts its trials."""

    name = "contradicting"

    def __init__(
        self,
        conflicts: Collection[str],
        status: PlanningStatus = PlanningStatus.UNSOLVABLE,
        clock: SteppedClock | None = None,
    ) -> None:
        """:param clock: a second goes by in each trial."""
        self._conflicts = [frozenset(map(Fact, names)) for names in conflicts]
        self._status = status
        self._clock = clock or SteppedClock()
        self.limits_s: list[float] = []

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.limits_s.append(request.time_limit_s)
        self._clock.now_s += 1.0
        withheld = FREE.facts - problem.facts
        is_solved = not any(conflict <= withheld for conflict in self._conflicts)
        return PlanningResult(
            status=PlanningStatus.SOLVED if is_solved else self._status,
            engine=self.name,
            planning_s=0.0,
            plan_net=EMPTY if is_solved else None,
        )


def found(
    engine: Contradicting,
    restrictions: Sequence[Restriction] = ALL,
    status: PlanningStatus = PlanningStatus.UNSOLVABLE,
    request: PlanningRequest | None = None,
) -> RestrictionConflict | None:
    return conflict_among(FREE, restrictions, status, engine, request or PlanningRequest(), UNOBSERVED)


@given(
    conflicts=st.sets(
        st.sets(st.sampled_from(NAMES), min_size=1).map(lambda some: "".join(sorted(some))), min_size=1
    )
)
def test_what_is_found_is_a_conflict_and_nothing_of_it_can_be_left_out(conflicts: set[str]) -> None:
    conflict = found(Contradicting(conflicts))
    assert conflict is not None
    assert (conflict.is_proven, conflict.is_complete) == (True, True)
    names = {words.removeprefix("without ") for words in conflict.constraints}
    assert any(set(one) <= names for one in conflicts)
    assert not any(set(one) <= names - {name} for one in conflicts for name in names)


def test_each_constraint_is_tried_once_and_the_time_is_shared() -> None:
    engine = Contradicting(["be"])
    conflict = found(engine, request=PlanningRequest(time_limit_s=14.0, clock=lambda: 0.0))
    assert conflict is not None
    assert conflict.constraints == ("without b", "without e")
    assert len(engine.limits_s) == 1 + len(NAMES)
    assert engine.limits_s[0] == pytest.approx(2.0)


def test_without_a_plan_under_none_of_them_they_are_not_to_blame() -> None:
    engine = Contradicting([""])
    assert found(engine) is None
    assert len(engine.limits_s) == 1
    assert found(Contradicting(["a"]), []) is None


def test_one_constraint_is_to_blame_alone_if_there_is_a_plan_without_it() -> None:
    engine = Contradicting(["c"])
    conflict = found(engine, [restriction("c")])
    assert conflict is not None
    assert conflict.constraints == ("without c",)
    assert len(engine.limits_s) == 1


@pytest.mark.parametrize("status", [PlanningStatus.NOT_FOUND, PlanningStatus.TIMED_OUT])
def test_without_a_proof_for_the_set_that_is_left_it_is_only_likely(status: PlanningStatus) -> None:
    conflict = found(Contradicting(["be"], status))
    assert conflict is not None
    assert (conflict.constraints, conflict.is_proven) == (("without b", "without e"), False)
    whole = found(Contradicting(["be"]), [restriction("b"), restriction("e")], status)
    assert whole is not None
    assert not whole.is_proven


def test_an_engine_that_fails_has_not_shown_that_there_is_no_plan() -> None:
    conflict = found(Contradicting(["be"], PlanningStatus.FAILED), status=PlanningStatus.NOT_FOUND)
    assert conflict is not None
    assert (len(conflict.constraints), conflict.is_complete) == (len(NAMES), False)


def test_without_time_for_all_trials_it_is_said_that_fewer_may_do() -> None:
    clock = SteppedClock()
    engine = Contradicting(["f"], clock=clock)
    conflict = found(engine, request=PlanningRequest(time_limit_s=3.5, clock=clock))
    assert conflict is not None
    assert not conflict.is_complete
    assert conflict.constraints == ("without d", "without e", "without f")
