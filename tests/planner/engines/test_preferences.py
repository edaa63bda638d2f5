"""Preferences: the plan with the smallest sum of makespan and costs of what it breaks."""

import random
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner import (
    UNOBSERVED,
    Fact,
    KnowledgeBase,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Preference,
    PreferenceOutcome,
    Progress,
    faults_of,
    load_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.preferences import PreferenceEngine
from planner.engines.registry import engine_named
from planner.problem.choices import as_chosen_by, keeping, without_each_preference
from planner.problem.preference import MAX_PREFERENCES, broken_cost_s
from tests.planner.engines.test_oversubscription import BASE, done, problem
from tests.planner.stepped_clock import SteppedClock
from tests.planner.store import inside, store_problem

QUICK = PlanningRequest(effort_s=0.0)
STORE = load_knowledge_base()


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    """What is compiled first takes none of the time limits."""
    HierarchicalEngine(STORE).warm_up()


def without(robot: str, cost_s: float, stated: PlanningProblem) -> Preference:
    withheld = frozenset(f for f in stated.facts if f.predicate == "can" and f.args[0] == robot)
    return Preference(words=f"without {robot}", cost_s=cost_s, withheld=withheld)


def avoiding(place: str, cost_s: float, stated: PlanningProblem) -> Preference:
    gone = {"clear": 0, "vacant": 0, "reaches": 1}
    withheld = frozenset(
        f for f in stated.facts if f.predicate in gone and f.args[gone[f.predicate]] == place
    )
    return Preference(words=f"avoiding {place}", cost_s=cost_s, withheld=withheld)


def jobs(spans: Sequence[int], costs: Sequence[float]) -> PlanningProblem:
    """Jobs for as many robots as there are costs, each robot rather not used."""
    stated = problem(list(spans), [None] * len(spans), deadline_s=None, robots=len(costs))
    preferences = tuple(without(f"robot_{number}", cost_s, stated) for number, cost_s in enumerate(costs))
    return replace(stated, preferences=preferences)


def sum_s(result: PlanningResult, preferences: Sequence[Preference]) -> float:
    assert result.plan_net is not None
    return result.plan_net.makespan_s + broken_cost_s(preferences, result.plan_net)


def best_by_trying_all(base: KnowledgeBase, stated: PlanningProblem, request: PlanningRequest) -> float:
    """The smallest sum of makespan and costs over all combinations, each planned as constraints."""
    engine = HierarchicalEngine(base)
    sums = []
    for size in range(len(stated.preferences) + 1):
        for some in combinations(stated.preferences, size):
            result = engine.plan(keeping(stated, some), request)
            if result.plan_net is not None:
                given_up = [preference for preference in stated.preferences if preference not in some]
                sums.append(result.plan_net.makespan_s + sum(preference.cost_s for preference in given_up))
    return min(sums)


def checked(stated: PlanningProblem, base: KnowledgeBase, request: PlanningRequest = QUICK) -> PlanningResult:
    """The answer, whose outcomes are those of its actions."""
    result = engine_named("macta", base).plan(stated, request)
    assert result.plan_net is not None, result.reason
    assert result.preferences is not None
    assert faults_of(result.plan_net, stated.facts, base) == []
    kept = [preference.words for preference in stated.preferences if preference.is_kept_by(result.plan_net)]
    assert [one.words for one in result.preferences.outcomes] == [
        preference.words for preference in stated.preferences
    ]
    assert [one.words for one in result.preferences.outcomes if one.is_kept] == kept
    assert all(one.is_kept != bool(one.reason) for one in result.preferences.outcomes)
    assert result.preferences.cost_s == pytest.approx(broken_cost_s(stated.preferences, result.plan_net))
    assert result.preferences.bound_s <= sum_s(result, stated.preferences) + 0.01
    return result


def outcome_of(result: PlanningResult, words: str) -> PreferenceOutcome:
    assert result.preferences is not None
    return next(one for one in result.preferences.outcomes if one.words == words)


@settings(max_examples=25, deadline=None)
@given(
    spans=st.lists(st.integers(1, 20), min_size=1, max_size=5),
    costs=st.lists(st.integers(1, 30), min_size=1, max_size=4),
)
def test_no_combination_planned_as_constraints_has_a_smaller_sum(spans: list[int], costs: list[int]) -> None:
    stated = jobs(spans, [float(cost) for cost in costs])
    result = checked(stated, BASE)
    assert sum_s(result, stated.preferences) <= best_by_trying_all(BASE, stated, QUICK) + 0.01
    assert result.preferences is not None
    assert not result.preferences.is_cut_short


@pytest.mark.parametrize("seed", range(4))
def test_in_random_stores_no_combination_has_a_smaller_sum(seed: int) -> None:
    rng = random.Random(seed)
    samples = rng.sample(["sample_1", "sample_2", "sample_4"], 2)
    bays = rng.sample(["bay_1", "bay_3", "bay_7", "bay_8"], 2)
    stated = store_problem([inside(*pair) for pair in zip(samples, bays, strict=True)])
    robots = rng.sample(["yard_1", "yard_2", "store_1", "store_2"], 2)
    preferences = (
        without(robots[0], rng.uniform(1, 60), stated),
        without(robots[1], rng.uniform(1, 60), stated),
        avoiding(rng.choice(["interchange_1", "interchange_2", "bay_2"]), rng.uniform(1, 60), stated),
    )
    stated = replace(stated, preferences=preferences)
    result = checked(stated, STORE, PlanningRequest())
    assert sum_s(result, preferences) <= best_by_trying_all(STORE, stated, PlanningRequest()) + 0.01


def test_a_preference_that_costs_less_than_it_saves_is_broken_and_one_that_costs_more_is_kept() -> None:
    cheap = checked(jobs([10, 10], [3.0, 3.0]), BASE)
    assert cheap.plan_net is not None
    assert (len(cheap.plan_net.robots), cheap.plan_net.makespan_s) == (2, 10.0), "10 s are worth 3 s twice"
    dear = checked(jobs([10, 10], [30.0, 30.0]), BASE)
    assert dear.plan_net is not None
    assert (len(dear.plan_net.robots), dear.plan_net.makespan_s) == (1, 20.0)


def test_a_broken_preference_tells_what_keeping_it_takes_longer() -> None:
    stated = store_problem([inside("sample_1", "bay_7")])
    shortest = engine_named("macta", STORE).plan(stated, QUICK).plan_net
    assert shortest is not None
    (busy,) = [robot for robot in shortest.robots if robot.startswith("yard")]
    preference = without(busy, 1.0, stated)
    other = engine_named("macta", STORE).plan(keeping(stated, [preference]), QUICK).plan_net
    assert other is not None
    longer_s = pytest.approx(other.makespan_s - shortest.makespan_s)
    broken = outcome_of(checked(replace(stated, preferences=(preference,)), STORE), preference.words)
    assert (broken.is_kept, broken.longer_s, broken.longer_at_least_s) == (False, longer_s, longer_s)
    assert "s longer; every plan that keeps it takes" in broken.reason


def test_preferences_that_cannot_be_kept_are_named_with_the_proof_not_refused() -> None:
    stated = jobs([10], [5.0, 9.0])
    result = checked(stated, BASE)
    broken = outcome_of(result, "without robot_0")
    assert not broken.is_kept
    assert broken.reason.startswith("no plan keeps it beside “without robot_1”: ")
    assert outcome_of(result, "without robot_1").is_kept, "the dearer one is kept"
    alone = checked(
        replace(stated, preferences=(*jobs([10], [5.0]).preferences, *stated.preferences[1:])), BASE
    )
    assert outcome_of(alone, "without robot_1").is_kept
    only = checked(jobs([10], [500.0]), BASE)
    assert outcome_of(only, "without robot_0").reason.startswith("no plan keeps it: ")


def test_what_no_preference_changes_has_no_plan_for_its_own_reason() -> None:
    stated = jobs([10], [5.0])
    stated = replace(stated, facts=frozenset(f for f in stated.facts if f.predicate != "open"))
    result = engine_named("macta", BASE).plan(stated, QUICK)
    assert result.status is PlanningStatus.UNSOLVABLE
    assert result.reason == engine_named("macta", BASE).plan(replace(stated, preferences=()), QUICK).reason


def test_deadlines_come_before_preferences() -> None:
    stated = jobs([10, 10], [1000.0, 1000.0])
    stated = replace(stated, deadlines_s=dict.fromkeys(stated.goals, 12.0))
    result = checked(stated, BASE)
    assert result.plan_net is not None
    assert not result.plan_net.late
    assert not outcome_of(result, "without robot_0").is_kept
    assert "later than their deadlines" in outcome_of(result, "without robot_0").reason


def test_what_optional_goals_are_worth_comes_before_preferences() -> None:
    stated = jobs([10, 10], [1000.0, 1000.0])
    stated = replace(
        stated,
        deadlines_s=dict.fromkeys(stated.goals, 12.0),
        values={done(0): 1.0, done(1): 1.0},
    )
    result = checked(stated, BASE)
    assert (result.value, result.left_out) == (2.0, ())
    assert not outcome_of(result, "without robot_0").is_kept
    loose = replace(stated, deadlines_s=dict.fromkeys(stated.goals, 25.0))
    both = checked(loose, BASE)
    assert both.value == 2.0
    assert [one.is_kept for one in both.preferences.outcomes if both.preferences].count(True) == 1


class Counting:
    """An engine that counts the problems it is asked, each of which takes so long."""

    name = "counting"

    def __init__(self, clock: SteppedClock | None = None, step_s: float = 0.0) -> None:
        self._engine = HierarchicalEngine(BASE)
        self._clock = clock
        self._step_s = step_s
        self.asked = 0

    def plan(
        self, stated: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.asked += 1
        observer.progress(Progress(engine=self.name, elapsed_s=0.0, makespan_s=1.0, lower_bound_s=1.0))
        result = self._engine.plan(stated, replace(request, time_limit_s=60.0, clock=lambda: 0.0))
        if self._clock is not None:
            self._clock.now_s += self._step_s
        return result


def test_the_search_ends_after_so_many_combinations_and_says_so() -> None:
    stated = jobs([10] * 8, [1.0] * MAX_PREFERENCES)
    engine = Counting()
    few = PreferenceEngine(engine, BASE, max_tries=4).plan(stated, QUICK)
    assert few.preferences is not None
    assert few.preferences.is_cut_short
    assert engine.asked <= 4 + MAX_PREFERENCES, "the rest of them for the reasons"
    many = PreferenceEngine(Counting(), BASE).plan(jobs([10, 10], [1.0, 1.0]), QUICK)
    assert many.preferences is not None
    assert not many.preferences.is_cut_short


def test_the_search_keeps_to_the_time_limit_and_says_that_it_was_cut_short() -> None:
    clock = SteppedClock()
    begun_s = clock()
    engine = Counting(clock, step_s=2.0)
    request = PlanningRequest(time_limit_s=10.0, effort_s=0.0, clock=clock)
    result = PreferenceEngine(engine, BASE).plan(jobs([10] * 8, [1.0] * MAX_PREFERENCES), request)
    assert result.plan_net is not None
    assert result.preferences is not None
    assert result.preferences.is_cut_short
    assert clock() - begun_s <= 10.0


def test_makespans_of_combinations_are_not_shown_as_progress_of_the_whole() -> None:
    seen: list[Progress] = []

    class Watching(Observer):
        def progress(self, progress: Progress) -> None:
            seen.append(progress)

    PreferenceEngine(Counting(), BASE).plan(jobs([10, 10], [1.0, 1.0]), QUICK, Watching())
    assert seen
    assert all(one.makespan_s is None and one.lower_bound_s is None for one in seen)


def test_more_preferences_than_can_be_chosen_among_are_refused() -> None:
    with pytest.raises(ValueError, match="9 preferences"):
        PreferenceEngine(Counting(), BASE).plan(jobs([10], [1.0] * (MAX_PREFERENCES + 1)), QUICK)


def test_a_place_to_be_kept_empty_counts_as_filled_though_the_plan_has_emptied_it() -> None:
    """That a place is vacant may be a plan's own doing."""
    preference = Preference(
        words="keeping empty: bay_2", cost_s=1.0, withheld=frozenset({Fact("vacant", ("bay_2",))})
    )
    stated = store_problem([inside("sample_2", "bay_1"), inside("sample_1", "bay_2")])
    assert Fact("vacant", ("bay_2",)) not in stated.facts
    result = checked(replace(stated, preferences=(preference,)), STORE)
    assert not outcome_of(result, "keeping empty: bay_2").is_kept


def test_the_problem_as_a_plan_has_chosen_has_only_plans_that_keep_the_same() -> None:
    stated = jobs([10, 10], [3.0, 30.0])
    result = checked(stated, BASE)
    assert result.plan_net is not None
    chosen = as_chosen_by(result.plan_net, stated)
    kept = [preference for preference in stated.preferences if preference.is_kept_by(result.plan_net)]
    assert chosen.preferences == ()
    assert chosen.facts == stated.facts - frozenset().union(*(preference.withheld for preference in kept))
    others = dict(without_each_preference(result.plan_net, stated))
    assert others.keys() == {preference.words for preference in kept}
    assert all(one.facts > chosen.facts for one in others.values())
