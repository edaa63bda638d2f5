"""Optional goals: what is worth most in the time there is; where one robot is a knapsack, by dynamic programming."""

import textwrap
from dataclasses import replace
from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner import (
    UNOBSERVED,
    Fact,
    KnowledgeBase,
    Objective,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    faults_of,
    read_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.oversubscription import EXACT_UP_TO, OversubscriptionEngine
from planner.engines.registry import engine_named

QUICK = PlanningRequest(effort_s=0.0)


def base() -> KnowledgeBase:
    """Jobs that take as long as they take, one after the other by one robot."""
    return read_knowledge_base(
        textwrap.dedent("""
        types: {robot: {}, job: {}, tag: {action_names: true}}
        functions: {takes_s: [job]}
        predicates:
          open: {arguments: {job: job}}
          done: {arguments: {job: job}}
          can: {arguments: {robot: robot, tag: tag}}
        actions:
          - identifier: 1
            name: WORK
            parameters: [{name: robot, type: robot}, {name: job, type: job}]
            agents: [robot]
            preconditions: ["can(robot, WORK)", "open(job)"]
            delete: ["open(job)"]
            intended_effects: ["done(job)"]
            other_effects: []
            duration: takes_s(job)
            description: "{robot} does {job}"
        """),
        "test",
    )


BASE = base()


def done(number: int) -> Fact:
    return Fact("done", (f"job_{number}",))


def problem(
    spans: list[int],
    worth: list[float | None],
    *,
    deadline_s: float | None,
    robots: int = 1,
    impossible: tuple[int, ...] = (),
) -> PlanningProblem:
    goals = tuple(done(number) for number in range(len(spans)))
    names = [f"robot_{number}" for number in range(robots)]
    return PlanningProblem(
        objects=dict.fromkeys(names, "robot") | {goal.args[0]: "job" for goal in goals},
        facts=frozenset(
            {Fact("open", goal.args) for n, goal in enumerate(goals) if n not in impossible}
            | {Fact("can", (robot, "WORK")) for robot in names}
        ),
        goals=goals,
        functions={("takes_s", goal.args): float(span) for goal, span in zip(goals, spans, strict=True)},
        deadlines_s={} if deadline_s is None else dict.fromkeys(goals, deadline_s),
        values={goal: value for goal, value in zip(goals, worth, strict=True) if value is not None},
    )


def planned(stated: PlanningProblem, request: PlanningRequest = QUICK) -> PlanningResult:
    result = engine_named("macta", BASE).plan(stated, request)
    if result.plan_net is not None:
        assert faults_of(result.plan_net, stated.facts, BASE) == []
        left_out = {one.goal for one in result.left_out}
        assert set(result.plan_net.goals) | left_out == set(stated.goals)
        assert left_out <= stated.values.keys()
        assert result.value == pytest.approx(
            sum(value for goal, value in stated.values.items() if goal not in left_out)
        )
    return result


def most(spans: list[int], worth: list[float], within: int) -> float:
    """The most that a knapsack of this size holds, by dynamic programming."""
    best = [0.0] * (within + 1)
    for span, value in zip(spans, worth, strict=True):
        for room in range(within, span - 1, -1):
            best[room] = max(best[room], best[room - span] + value)
    return best[within]


@settings(max_examples=25, deadline=None)
@given(
    jobs=st.lists(st.tuples(st.integers(1, 20), st.integers(1, 30)), min_size=1, max_size=7),
    share=st.floats(0.1, 1.1),
)
def test_of_a_few_goals_the_best_subset_is_chosen(jobs: list[tuple[int, int]], share: float) -> None:
    spans = [span for span, _ in jobs]
    worth = [float(value) for _, value in jobs]
    within = int(share * sum(spans))
    result = planned(problem(spans, list(worth), deadline_s=float(within)))
    best = most(spans, worth, within)
    if best == 0.0:
        assert result.status is PlanningStatus.NOT_FOUND
        assert "none of the optional goals" in result.reason
        return
    assert result.plan_net is not None
    assert (result.value, result.value_bound) == (best, best)
    assert result.plan_net.makespan_s <= within


def test_of_many_goals_a_good_subset_is_chosen() -> None:
    spans = [3 + (7 * n) % 17 for n in range(EXACT_UP_TO + 4)]
    worth = [float(2 + (11 * n) % 23) for n in range(len(spans))]
    within = sum(spans) // 2
    result = planned(problem(spans, list(worth), deadline_s=float(within)))
    assert result.value is not None
    assert result.value >= 0.95 * most(spans, worth, within)
    assert result.value_bound == sum(worth), "nothing better is proven"


def test_a_goal_that_was_taken_is_given_up_for_one_that_is_worth_more() -> None:
    """Of many goals, job_0 is taken first: by the second, it is worth more."""
    engine = OversubscriptionEngine(HierarchicalEngine(BASE), BASE, exact_up_to=0)
    result = engine.plan(problem([2, 9], [3.0, 8.0], deadline_s=10.0), QUICK)
    assert (result.value, [one.goal for one in result.left_out]) == (8.0, [done(0)])


def test_what_must_be_achieved_is_worth_more_than_anything() -> None:
    result = planned(problem([10, 10], [None, 1000.0], deadline_s=15.0))
    assert result.plan_net is not None
    assert result.plan_net.goals == (done(0),)
    (left_out,) = result.left_out
    assert (left_out.goal, left_out.value) == (done(1), 1000.0)
    assert left_out.reason == "with it a goal would be 5 s late"


def test_it_is_told_why_each_goal_is_left_out() -> None:
    stated = problem([10, 5, 30, 5], [4.0, 3.0, 9.0, 1.0], deadline_s=16.0, impossible=(3,))
    reasons = {one.goal: one.reason for one in planned(stated).left_out}
    assert reasons.keys() == {done(2), done(3)}
    assert reasons[done(2)] == "with it a goal would be 29 s late"
    assert "open(job_3)" in reasons[done(3)]


def test_what_a_bound_rules_out_is_not_planned(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bound that the work of one robot would have, which ours does not see in a domain without ways."""

    def work_s(_: KnowledgeBase, stated: PlanningProblem) -> float:
        return sum(stated.functions["takes_s", goal.args] for goal in stated.goals)

    class Counting:
        name = "counting"

        def __init__(self) -> None:
            self.asked: list[tuple[Fact, ...]] = []

        def plan(
            self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
        ) -> PlanningResult:
            self.asked.append(problem.goals)
            return HierarchicalEngine(BASE).plan(problem, request)

    monkeypatch.setattr("planner.engines.oversubscription.lower_bound_s", work_s)
    spans, worth = [10, 8, 5, 40], [4.0, 3.0, 1.5, 9.0]
    counting = Counting()
    result = OversubscriptionEngine(counting, BASE).plan(problem(spans, list(worth), deadline_s=14.0), QUICK)
    assert result.value == most(spans, worth, 14) == 4.5
    assert all(sum(spans[int(goal.args[0][4:])] for goal in goals) <= 14 for goals in counting.asked)
    assert {one.goal: one.reason for one in result.left_out} == {
        done(3): "no plan is quick enough for it",
        done(0): "no plan is quick enough for it and what is worth more",
    }


def test_without_a_deadline_only_the_impossible_is_left_out() -> None:
    result = planned(problem([10, 10, 10], [None, 1.0, 1.0], deadline_s=None, impossible=(2,)))
    assert [one.goal for one in result.left_out] == [done(2)]


def test_if_what_must_be_is_late_nothing_else_is_begun() -> None:
    result = planned(problem([20, 1], [None, 5.0], deadline_s=10.0))
    assert result.plan_net is not None
    assert result.plan_net.late == {done(0): 10.0}
    assert [one.reason for one in result.left_out] == ["what is not optional is 10 s late already"]


def test_if_what_must_be_has_no_plan_there_is_none() -> None:
    result = planned(problem([10, 10], [None, 5.0], deadline_s=None, impossible=(0,)))
    assert result.status is PlanningStatus.UNSOLVABLE


def test_two_robots_do_more_than_one() -> None:
    worth: list[float | None] = [5.0, 4.0, 3.0]
    alone = planned(problem([10, 10, 10], worth, deadline_s=10.0))
    together = planned(problem([10, 10, 10], worth, deadline_s=10.0, robots=2))
    assert (alone.value, together.value) == (5.0, 9.0)


def test_without_values_it_answers_as_the_engine_does() -> None:
    stated = replace(problem([10, 5], [1.0, 1.0], deadline_s=5.0), values={})
    result = OversubscriptionEngine(HierarchicalEngine(BASE), BASE).plan(stated, QUICK)
    assert (result.value, result.left_out) == (None, ())
    assert result.plan_net == HierarchicalEngine(BASE).plan(stated, QUICK).plan_net


def test_when_the_time_is_up_the_best_so_far_is_taken_and_the_doubt_is_told() -> None:
    class Slow:
        """Takes a second of the stepped clock for each plan, and proves nothing."""

        name = "slow"

        def __init__(self) -> None:
            self.now_s = 0.0

        def clock(self) -> float:
            return self.now_s

        def plan(
            self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
        ) -> PlanningResult:
            self.now_s += 1.0
            return HierarchicalEngine(BASE).plan(problem, QUICK)

    slow = Slow()
    spans = [7, 8, 9, 10, 11, 12]
    worth: list[float | None] = [7.0, 8.1, 9.3, 10.6, 12.0, 13.5]
    stated = problem(spans, worth, deadline_s=25.0, robots=3)
    stated = replace(stated, facts=stated.facts - {Fact("can", (f"robot_{n}", "WORK")) for n in (1, 2)})
    request = PlanningRequest(effort_s=0.0, time_limit_s=12.0, clock=slow.clock)
    result = OversubscriptionEngine(slow, BASE).plan(stated, request)
    assert result.plan_net is not None
    assert not result.plan_net.late
    assert slow.now_s <= 13.0
    assert result.value is not None
    assert result.value_bound is not None
    assert result.value_bound >= result.value


def test_it_goes_with_the_objective_on_time() -> None:
    stated = problem([10, 10], [2.0, 1.0], deadline_s=13.0)
    result = planned(stated, replace(QUICK, objective=Objective.ON_TIME))
    assert [one.goal for one in result.left_out] == [done(1)]


def test_the_chosen_subset_is_the_best_of_all_by_the_same_engine() -> None:
    """Two robots: no knapsack, so every subset is asked for."""
    stated = problem([9, 7, 6, 5, 4], [8.0, 7.0, 5.0, 4.5, 3.0], deadline_s=12.0, robots=2)
    engine = HierarchicalEngine(BASE)
    best = 0.0
    for size in range(1, 6):
        for some in combinations(stated.goals, size):
            plan_net = engine.plan(replace(stated, goals=some, values={}), QUICK).plan_net
            if plan_net is not None and not plan_net.late:
                best = max(best, sum(stated.values[goal] for goal in some))
    assert planned(stated).value == best
