"""Plans edited by what people pin: who works for a goal, where, from when on, and after which other goals."""

import random
import re
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.planner.scheduled_progress import as_scheduled
from planner import (
    UNOBSERVED,
    Fact,
    KnowledgeBase,
    Observer,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    faults_of,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.explanation.legs import barred_actions
from planner.plan_nets.plan_net import GOAL
from planner.plan_nets.validation import broken_orders
from planner.repair import CannotPin, Pin, PlanHandles, Repair, compare, edit, pinned, repair
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.repair.test_repair_laws import (
    BASE,
    engine,
    nothing,
    place_taken,
    sample_moved,
    store_plan,
)
from tests.planner.store import inside, store_problem

STORED = inside("sample_1", "bay_7")
OTHER = inside("sample_2", "bay_2")
"""It holds already."""
MOVED = inside("sample_2", "bay_3")
REQUEST = PlanningRequest(effort_s=0.0)
Planned = tuple[PlanningProblem, PlanNet]


@pytest.fixture(scope="module")
def problem() -> PlanningProblem:
    return store_problem([STORED, OTHER])


@pytest.fixture(scope="module")
def plan(problem: PlanningProblem) -> PlanNet:
    found = engine().plan(problem, PlanningRequest()).plan_net
    assert found is not None
    return found


@pytest.fixture(scope="module")
def both() -> Planned:
    """A problem with two samples to move, and its plan."""
    problem = store_problem([STORED, MOVED])
    plan = engine().plan(problem, PlanningRequest()).plan_net
    assert plan is not None
    return problem, plan


def edited(plan: PlanNet, problem: PlanningProblem, pin: Pin) -> Repair:
    wanted = pinned(problem, [pin], BASE)
    found = edit(engine(), BASE, plan, wanted, REQUEST)
    if found.plan_net is not None:
        assert not faults_of(found.plan_net, wanted.facts, BASE)
        assert not barred_actions(found.plan_net, wanted, BASE)
        assert not broken_orders(found.plan_net, wanted.after)
    return found


def handling(plan: PlanNet, sample: str, robot: str = "yard") -> str:
    """The first action of a robot of that kind with the sample."""
    return next(
        action.id
        for action in plan.actions
        if sample in action.arguments.values() and any(name.startswith(robot) for name in action.agents)
    )


def hauler(plan: PlanNet, sample: str) -> str:
    (robot,) = {
        agent
        for action in plan.actions
        if sample in action.arguments.values()
        for agent in action.agents
        if agent.startswith("yard")
    }
    return robot


def test_another_robot_can_be_told_to_do_it(plan: PlanNet, problem: PlanningProblem) -> None:
    handles = PlanHandles(plan, problem, BASE)
    action = handling(plan, "sample_1")
    other = {"yard_1": "yard_2", "yard_2": "yard_1"}[hauler(plan, "sample_1")]
    pin = Pin(goal=handles.goal_of(action), barred=handles.barred_for(action, other))
    found = edited(plan, problem, pin)
    assert pin.goal == STORED
    assert found.plan_net is not None
    assert hauler(found.plan_net, "sample_1") == other


def test_nobody_else_goes_on_with_what_a_robot_carries(plan: PlanNet, problem: PlanningProblem) -> None:
    robot = hauler(plan, "sample_1")
    other = {"yard_1": "yard_2", "yard_2": "yard_1"}[robot]
    (lying,) = [
        fact for fact in problem.facts if fact.predicate == "object_position" and "sample_1" in fact.args
    ]
    carried = replace(problem, facts=problem.facts - {lying} | {inside("sample_1", robot)})
    handles = PlanHandles(plan, carried, BASE)
    action = handling(plan, "sample_1")
    words = f"{robot} has sample_1 already (in(sample_1, {robot})); nobody else can go on with it"
    with pytest.raises(CannotPin, match=re.escape(words)):
        handles.barred_for(action, other)
    with pytest.raises(CannotPin, match=re.escape(words)):
        handles.without(action, robot)
    assert robot not in handles.barred_for(action, robot)


def test_a_robot_that_is_left_out_makes_way_for_the_one_that_does_it_instead(
    problem: PlanningProblem,
) -> None:
    stored = store_problem([STORED], robots_at={"yard_1": "interchange_2"})
    plan = engine().plan(stored, REQUEST).plan_net
    assert plan is not None
    robot = hauler(plan, "sample_1")
    pin = Pin(goal=STORED, barred=PlanHandles(plan, stored, BASE).without(handling(plan, "sample_1"), robot))
    found = edited(plan, stored, pin)
    assert found.plan_net is not None, found.result.reason
    assert hauler(found.plan_net, "sample_1") != robot


def test_the_robot_that_does_it_can_be_kept(plan: PlanNet, problem: PlanningProblem) -> None:
    handles = PlanHandles(plan, problem, BASE)
    action = handling(plan, "sample_1")
    mine = hauler(plan, "sample_1")
    barred = handles.barred_for(action, mine)
    found = edited(plan, problem, Pin(goal=STORED, barred=barred))
    assert mine not in barred
    assert found.difference is not None
    assert found.difference.changes == 0


def test_a_robot_can_be_kept_from_it(plan: PlanNet, problem: PlanningProblem) -> None:
    mine = hauler(plan, "sample_1")
    barred = PlanHandles(plan, problem, BASE).without(handling(plan, "sample_1"), mine)
    found = edited(plan, problem, Pin(goal=STORED, barred=barred))
    assert barred == {mine}
    assert found.plan_net is not None
    assert hauler(found.plan_net, "sample_1") != mine


@pytest.mark.parametrize("sample", ["s0", "s1"])
def test_another_way_can_be_asked_for(sample: str) -> None:
    goals = [inside("s0", "bay_0_0"), inside("s1", "bay_0_3")]
    problem = Store(aisles=1, interchanges=2, yard_robots=1).problem(goals, {"s0": "door_0", "s1": "door_1"})
    plan = engine().plan(problem, PlanningRequest()).plan_net
    assert plan is not None
    (way,) = ways(plan, sample)
    (goal,) = (goal for goal in goals if sample in goal.args)
    found = edited(plan, problem, Pin(goal=goal, avoided=frozenset({way})))
    assert found.plan_net is not None, found.result.reason
    assert ways(found.plan_net, sample) == {"interchange_0_0", "interchange_0_1"} - {way}


def test_a_robot_may_come_from_where_it_was_for_another_goal() -> None:
    goals = [inside("s0", "bay_0_0"), inside("s1", "bay_0_3")]
    problem = Store(aisles=1, interchanges=2, yard_robots=1).problem(goals, {"s0": "door_0", "s1": "door_1"})
    first, second = "interchange_0_0", "interchange_0_1"
    pins = [Pin(goal=goals[0], avoided=frozenset({second})), Pin(goal=goals[1], avoided=frozenset({first}))]
    problem = pinned(problem, pins, BASE)
    plan = engine().plan(problem, PlanningRequest()).plan_net
    assert plan is not None
    assert (ways(plan, "s0"), ways(plan, "s1")) == ({first}, {second})
    assert not barred_actions(plan, problem, BASE)
    (leaving,) = {
        action.arguments["ref1"]
        for action in plan.actions
        if action.tag == "NAVIGATE" and "yard_0" in action.agents
    } & {first, second}
    wrong = replace(problem, avoids={goal: frozenset({leaving}) for goal in goals})
    assert barred_actions(plan, wrong, BASE), "it is used for a goal all the same"


def ways(plan: PlanNet, sample: str) -> set[str]:
    return {
        value
        for action in plan.actions
        if sample in action.arguments.values()
        for value in action.arguments.values()
        if value.startswith("interchange")
    }


def test_a_place_that_there_is_no_way_round_is_said_to_be_one(
    plan: PlanNet, problem: PlanningProblem
) -> None:
    found = edited(plan, problem, Pin(goal=STORED, avoided=frozenset({"interchange_2"})))
    assert found.plan_net is None
    assert found.result.reason == "there is no way to in(sample_1, bay_7) without interchange_2"


def test_a_goal_can_be_put_off_while_the_rest_stays(plan: PlanNet, problem: PlanningProblem) -> None:
    found = edited(plan, problem, Pin(goal=STORED, not_before_s=200.0))
    assert found.plan_net is not None
    assert found.difference is not None
    assert found.difference.changes == 0
    assert found.plan_net.makespan_s > 200.0


@pytest.mark.parametrize("order", [(STORED, MOVED), (MOVED, STORED)])
def test_a_goal_comes_true_after_another_while_all_stays_that_can(
    both: Planned, order: tuple[Fact, Fact]
) -> None:
    problem, plan = both
    before, later = order
    found = edited(plan, problem, Pin(goal=later, after=frozenset({before})))
    assert found.plan_net is not None
    ends_s = {
        link.fact: found.plan_net.action(link.producer).earliest_end_s
        for link in found.plan_net.causal_links
        if link.consumer == GOAL
    }
    assert ends_s[before] < ends_s[later]
    assert found.difference is not None
    assert found.difference.changes == 0


class Unaware:
    """Plans without regard to the order."""

    name = "unaware"

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        return engine().plan(replace(problem, after={}), request, observer)


def test_a_plan_that_does_not_keep_the_order_is_not_taken(both: Planned) -> None:
    problem, plan = both
    against = {STORED: frozenset({MOVED}), MOVED: frozenset({STORED})}
    found = edit(Unaware(), BASE, plan, replace(problem, after=against), REQUEST)
    assert found.plan_net is None
    assert "does not wait for in(" in found.result.reason


def test_of_two_orders_the_second_keeps_the_first() -> None:
    third = inside("sample_3", "bay_1")
    more = store_problem([STORED, MOVED, third])
    plan = engine().plan(more, PlanningRequest()).plan_net
    assert plan is not None
    first = pinned(more, [Pin(goal=STORED, after=frozenset({MOVED}))], BASE)
    found = edited(plan, first, Pin(goal=MOVED, after=frozenset({third})))
    assert found.plan_net is not None
    assert found.problem.after == {STORED: {MOVED}, MOVED: {third}}


def test_the_goal_that_another_action_serves_is_what_it_comes_after(both: Planned) -> None:
    problem, plan = both
    handles = PlanHandles(plan, problem, BASE)
    assert handles.after(handling(plan, "sample_1"), handling(plan, "sample_2", "store")) == MOVED


def test_a_goal_does_not_come_after_itself(both: Planned) -> None:
    problem, plan = both
    handles = PlanHandles(plan, problem, BASE)
    one, other = handling(plan, "sample_1"), handling(plan, "sample_1", "store")
    with pytest.raises(CannotPin) as refused:
        handles.after(one, other)
    assert str(refused.value) == (
        f"{one} and {other} are both done for in(sample_1, bay_7), which cannot come after itself"
    )
    with pytest.raises(CannotPin, match=f"{one} is done for in"):
        handles.after(one, one)


def test_orders_that_contradict_each_other_are_refused_with_their_actions(both: Planned) -> None:
    problem, plan = both
    first = pinned(problem, [Pin(goal=STORED, after=frozenset({MOVED}))], BASE)
    achieved = {link.fact: link.producer for link in plan.causal_links if link.consumer == GOAL}
    one, other = f"in(sample_1, bay_7) ({achieved[STORED]})", f"in(sample_2, bay_3) ({achieved[MOVED]})"
    PlanHandles(plan, first, BASE).refuse_contradictions({})
    with pytest.raises(CannotPin) as refused:
        PlanHandles(plan, first, BASE).refuse_contradictions({MOVED: frozenset({STORED})})
    assert str(refused.value).startswith("these orders contradict each other: ")
    assert f"{one} after {other}" in str(refused.value)
    assert f"{other} after {one}" in str(refused.value)


def test_an_order_against_the_stages_of_the_goal_is_refused(both: Planned) -> None:
    problem, plan = both
    staged = replace(problem, stages={MOVED: 1})
    PlanHandles(plan, staged, BASE).refuse_contradictions({MOVED: frozenset({STORED})})
    with pytest.raises(CannotPin, match="by the stages of the goal"):
        PlanHandles(plan, staged, BASE).refuse_contradictions({STORED: frozenset({MOVED})})


def test_pins_for_goals_that_there_are_not_change_nothing(problem: PlanningProblem) -> None:
    pin = Pin(goal=inside("sample_3", "bay_1"), barred=frozenset({"yard_1"}), not_before_s=9.0)
    assert pinned(problem, [pin, Pin(goal=STORED, after=frozenset({pin.goal}))], BASE) == problem


def test_without_a_way_it_says_so(plan: PlanNet, problem: PlanningProblem) -> None:
    everybody = frozenset({"yard_1", "yard_2"})
    found = edited(plan, problem, Pin(goal=STORED, barred=everybody))
    assert found.plan_net is None
    assert found.result.status is not PlanningStatus.SOLVED
    assert found.result.reason


@pytest.mark.parametrize(
    ("robot", "reason"),
    [("store_2", "store_2 cannot do what yard_"), ("yard_9", "yard_9 cannot do what yard_")],
)
def test_who_cannot_do_it_is_refused_with_who_can(
    plan: PlanNet, problem: PlanningProblem, robot: str, reason: str
) -> None:
    with pytest.raises(CannotPin) as refused:
        PlanHandles(plan, problem, BASE).barred_for(handling(plan, "sample_1"), robot)
    assert str(refused.value).startswith(reason)
    assert str(refused.value).endswith("yard_1 and yard_2 can")


def test_who_has_no_part_in_it_need_not_be_kept_from_it(plan: PlanNet, problem: PlanningProblem) -> None:
    with pytest.raises(CannotPin, match="does nothing for"):
        PlanHandles(plan, problem, BASE).without(handling(plan, "sample_1"), "yard_9")


def test_who_is_the_only_one_cannot_be_kept_from_it(plan: PlanNet, problem: PlanningProblem) -> None:
    action = handling(plan, "sample_1", "store")
    (robot,) = plan.action(action).agents
    with pytest.raises(CannotPin, match=f"nobody can take the part of {robot}"):
        PlanHandles(plan, problem, BASE).without(action, robot)


def test_an_action_that_there_is_not_is_refused(plan: PlanNet, problem: PlanningProblem) -> None:
    with pytest.raises(CannotPin, match="the plan has no action a99; it has a1, "):
        PlanHandles(plan, problem, BASE).goal_of("a99")


def random_edit(seed: int) -> tuple[PlanNet, PlanningProblem, Pin] | None:
    """A random store's plan, its problem, and a robot that is kept from a goal; None if nobody else can do it."""
    choose = random.Random(seed)
    problem, plan = store_plan(choose)
    handles = PlanHandles(plan, problem, BASE)
    action = choose.choice(plan.actions)
    try:
        goal = handles.goal_of(action.id)
        return plan, problem, Pin(goal=goal, barred=handles.without(action.id, action.agents[0]))
    except CannotPin:
        return None


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_an_edited_plan_is_valid_and_keeps_to_the_pin(seed: int) -> None:
    if (case := random_edit(seed)) is not None:
        edited(*case)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_a_plan_in_another_order_is_valid_and_keeps_the_order_through_repairs(seed: int) -> None:
    choose = random.Random(seed)
    problem, plan = store_plan(choose)
    if len(problem.goals) < 2:
        return
    later, *before = choose.sample(problem.goals, choose.randint(2, len(problem.goals)))
    wanted = pinned(problem, [Pin(goal=later, after=frozenset(before))], BASE)
    found = edit(engine(), BASE, plan, wanted, REQUEST).plan_net
    assert found is not None
    assert not faults_of(found, wanted.facts, BASE)
    assert not broken_orders(found, wanted.after)
    facts, progress = as_scheduled(found, wanted.facts, round(choose.uniform(0.0, 0.9) * found.makespan_s, 1))
    mishap = choose.choice([nothing, sample_moved, place_taken])
    present, progress = mishap((replace(wanted, facts=facts), progress), choose)
    mended = repair(engine(), BASE, found, present, progress, REQUEST)
    if mended.plan_net is None:
        assert mishap is not nothing
        return
    assert not faults_of(mended.plan_net, mended.problem.facts, BASE)
    assert not broken_orders(mended.plan_net, wanted.after)


def test_edited_plans_keep_more_of_the_old_ones_than_plans_made_from_scratch() -> None:
    kept: list[float] = []
    new: list[float] = []
    for seed in range(24):
        if (case := random_edit(seed)) is None:
            continue
        plan, problem, pin = case
        found = edited(plan, problem, pin).plan_net
        anew = engine().plan(pinned(problem, [pin], BASE), REQUEST).plan_net
        if found is not None and anew is not None:
            kept.append(worth(plan, found))
            new.append(worth(plan, anew))
    assert len(kept) >= 4
    assert sum(kept) < sum(new)


def worth(old: PlanNet, new: PlanNet) -> float:
    return new.makespan_s + 5.0 * compare(old.actions, new).changes


def test_beginning_with_the_old_plan_finds_it_again(knowledge_base: KnowledgeBase) -> None:
    problem, plan = store_plan(random.Random(1))
    again = HierarchicalEngine(knowledge_base).plan(problem, PlanningRequest(effort_s=0.0, like=plan))
    assert again.plan_net is not None
    assert compare(plan.actions, again.plan_net).changes == 0


def test_an_old_plan_that_is_much_longer_than_its_changes_are_worth_is_not_kept(
    knowledge_base: KnowledgeBase,
) -> None:
    goals = [inside("s0", "door_2"), inside("s1", "door_3")]
    problem = Store(yard_robots=2, doors=4).problem(goals, {"s0": "door_0", "s1": "door_1"})
    by_one_robot = frozenset(fact for fact in problem.facts if fact.args[0] != "yard_1")
    old = engine().plan(replace(problem, facts=by_one_robot), REQUEST).plan_net
    assert old is not None
    again = HierarchicalEngine(knowledge_base).plan(problem, PlanningRequest(effort_s=1.0, like=old))
    assert again.plan_net is not None
    assert compare(old.actions, again.plan_net).changes > 0
    assert worth(old, again.plan_net) < old.makespan_s
