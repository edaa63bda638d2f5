"""Plan-nets of actions with times within them: valid, safe however long actions take, explained, repaired, exported."""

import random
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.planner.check import fault_of as fault_in_executions
from benchmarks.planner.scheduled_progress import as_scheduled
from benchmarks.planner.timed_store import timed_store
from benchmarks.planner.val_validation import is_installed, val_fault
from planner import (
    Fact,
    Keeping,
    KnowledgeBase,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    load_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.explanation import explain
from planner.interchange.pddl import Form, pddl_of
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK
from planner.interchange.up_validation import up_fault
from planner.plan_nets.extraction import extract
from planner.plan_nets.plan_net import GOAL
from planner.plan_nets.progression import progressed
from planner.plan_nets.redundancy import without_redundant
from planner.plan_nets.validation import faults_of, linearisation
from planner.relaxation import unreachable_goals
from planner.repair import MissionProgress, repair
from robots.world.parts import PHASE_TAGS
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.kept_by_execution import Execution
from tests.planner.store import inside

QUICK = PlanningRequest(effort_s=0.0)


timed = timed_store


def random_store(seed: int) -> PlanningProblem:
    """Up to six robots that meet at one or two interchanges, and samples that cross each other there."""
    choose = random.Random(seed)
    store = Store(aisles=choose.randint(1, 2), yard_robots=choose.randint(1, 4), doors=4)
    bays = [f"bay_{aisle}_{n}" for aisle in range(store.aisles) for n in range(store.bays)]
    doors = [f"door_{n}" for n in range(store.doors)]
    chance = choose.random() < 0.5
    starts = choose.sample([*bays, *doors] if chance else bays, 3)
    ends = choose.sample([place for place in [*bays, *doors] if place not in starts], 3)
    samples = {f"s{n}": place for n, place in enumerate(starts)}
    return store.problem([inside(f"s{n}", place) for n, place in enumerate(ends)], samples)


def planned(problem: PlanningProblem, knowledge_base: KnowledgeBase) -> PlanNet:
    result = HierarchicalEngine(knowledge_base).plan(problem, QUICK)
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    assert result.lower_bound_s is None or result.lower_bound_s <= result.plan_net.makespan_s + 0.01
    return result.plan_net


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_no_execution_that_keeps_to_kept_by_goes_wrong(seed: int) -> None:
    problem = random_store(seed)
    plan_net = planned(problem, timed())
    assert any(action.phase for action in plan_net.actions)
    assert fault_in_executions(plan_net, problem, timed()) is None
    for chance in range(10):
        assert Execution(plan_net, problem, timed(), seed=chance).fault is None


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10**6))
def test_robots_with_and_without_the_packets_of_phases_are_in_one_plan(seed: int) -> None:
    """Whatever each can, the plan-net is valid, safe in any execution, and has phases of those only that can."""
    problem = random_store(seed)
    base = load_knowledge_base()
    robots = sorted(name for name, kind in problem.objects.items() if kind == "robot")
    able = random.Random(seed).sample(robots, len(robots) // 2)
    more = {Fact("can", (robot, tag)) for robot in able for tag in PHASE_TAGS}
    problem = replace(problem, facts=problem.facts | more)
    plan_net = planned(problem, base)
    assert {robot for action in plan_net.actions if action.phase for robot in action.agents} <= {*able}
    assert fault_in_executions(plan_net, problem, base) is None
    assert up_fault(base, problem, plan_net) is None
    for chance in range(5):
        assert Execution(plan_net, problem, base, seed=chance).fault is None


@pytest.mark.skipif(not is_installed(), reason="VAL is not installed")
def test_val_validates_a_plan_of_both_kinds_of_robots() -> None:
    problem = random_store(3)
    base = load_knowledge_base()
    able = sorted(name for name, kind in problem.objects.items() if kind == "robot")[::2]
    more = {Fact("can", (robot, tag)) for robot in able for tag in PHASE_TAGS}
    problem = replace(problem, facts=problem.facts | more)
    plan_net = planned(problem, base)
    assert {bool(action.phase) for action in plan_net.actions if action.tag == "NAVIGATE"} == {True, False}
    assert val_fault(base, problem, plan_net) is None


def test_the_execution_finds_what_a_lost_coupling_does() -> None:
    """The test above can fail: without its clearances and what robots sense, this plan-net goes wrong."""
    problem = random_store(3)
    plan_net = planned(problem, timed())
    blind = replace(plan_net, senses=dict.fromkeys(plan_net.robots, frozenset[str]()))
    blind = replace(blind, orderings=tuple(replace(o, kept_by=Keeping.ROBOT) for o in blind.orderings))
    assert any(Execution(blind, problem, timed(), seed=chance).fault for chance in range(20))


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.05, 0.95))
def test_a_plan_is_repaired_in_the_middle_of_its_actions(seed: int, share: float) -> None:
    problem = random_store(seed)
    plan_net = planned(problem, timed())
    facts, progress = as_scheduled(plan_net, problem.facts, share * plan_net.makespan_s)
    present = replace(problem, facts=facts)
    repaired = repair(HierarchicalEngine(timed()), timed(), plan_net, present, progress, QUICK)
    assert repaired.result.plan_net is not None, repaired.result.reason
    assert repaired.difference is not None
    assert not repaired.difference.dropped
    assert fault_in_executions_of_rest(repaired.result.plan_net, repaired.problem) is None


def fault_in_executions_of_rest(plan_net: PlanNet, problem: PlanningProblem) -> str | None:
    faults = (Execution(plan_net, problem, timed(), seed=chance).fault for chance in range(5))
    return next((fault for fault in faults if fault), None)


def going(to: str, start: str, robot: str = "yard_0") -> dict[str, str]:
    return {"robots": robot, "rel1": "near", "ref1": start, "rel2": "near", "ref2": to, "area": "yard"}


def test_a_place_is_held_only_while_it_is_used() -> None:
    """One robot drives up to the interchange while another still leaves it."""
    store = Store(aisles=1, yard_robots=2, doors=2)
    problem = store.problem([], {}, robots_at={"yard_0": "interchange_0_0", "yard_1": "door_0"})
    aims = {"yard_0": "door_1", "yard_1": "interchange_0_0"}
    goals = tuple(Fact("robot_position", (robot, "near", place)) for robot, place in aims.items())
    problem = replace(problem, goals=goals)
    late = planned(problem, load_knowledge_base())
    early = planned(problem, timed())
    assert early.makespan_s < 0.75 * late.makespan_s
    leaving = next(a for a in early.actions if a.agents == ("yard_0",) and a.phase == 1)
    entering = next(a for a in early.actions if a.agents == ("yard_1",) and a.phase == 3)
    assert [o.before for o in early.orderings if o.after == entering.id and o.before == leaving.id]


def test_a_robot_that_makes_way_ends_what_it_begins() -> None:
    knowledge_base = timed()
    problem = Store(aisles=1, yard_robots=1, doors=2).problem([], {"s0": "door_0"})
    start = "home_yard_0"
    whole = knowledge_base.ground(
        "NAVIGATE", going("door_1", start), problem.functions, objects=problem.objects
    )
    phases = knowledge_base.phases_of(whole, problem.facts)
    freed = Fact("clear", (start, "yard"))
    needing = replace(
        whole, tag="DOCK", phase=0, agents=("store_0",), arguments={}, preconditions=(freed,), deletes=(),
        intended_effects=(Fact("vacant", ("elsewhere",)),), other_effects=(),
    )  # fmt: skip
    goals = (Fact("vacant", ("elsewhere",)),)
    assert without_redundant([*phases, needing], problem.facts, goals) == (*phases, needing)
    order = extract([*phases, needing], problem.facts, goals)
    assert [link.consumer for link in order.links if link.producer == 0] == [1, 3]


def test_a_plan_net_that_begins_an_action_and_does_not_end_it_is_faulty() -> None:
    problem = random_store(1)
    plan_net = planned(problem, timed())
    last = next(a for a in reversed(plan_net.actions) if a.phase == a.phases > 0)
    cut = replace(
        plan_net,
        actions=tuple(a for a in plan_net.actions if a.id != last.id),
        orderings=tuple(o for o in plan_net.orderings if last.id not in (o.before, o.after)),
        causal_links=tuple(k for k in plan_net.causal_links if last.id not in (k.producer, k.consumer)),
    )
    faults = faults_of(cut, problem.facts, timed())
    assert any("does not end it" in fault for fault in faults)


def test_unified_planning_rejects_a_phase_that_does_not_wait_for_its_place() -> None:
    problem = random_store(1)
    plan_net = planned(problem, timed())
    assert up_fault(timed(), problem, plan_net) is None
    entering = next(a for a in plan_net.actions if a.phase == a.phases > 0)
    careless = replace(
        entering, preconditions=tuple(f for f in entering.preconditions if f.predicate != "clear")
    )
    swapped = tuple(careless if a.id == entering.id else a for a in plan_net.actions)
    fault = up_fault(timed(), problem, replace(plan_net, actions=swapped))
    assert fault is not None
    assert "preconditions are not those" in fault


@pytest.mark.skipif(not is_installed(), reason="VAL is not installed: uv sync --extra validation")
def test_val_finds_plans_with_phases_valid_and_sees_a_lost_ordering() -> None:
    problem = random_store(5)
    plan_net = planned(problem, timed())
    assert val_fault(timed(), problem, plan_net) is None
    assert val_fault(timed(), problem, replace(plan_net, orderings=())) is not None


def test_an_external_reader_takes_a_domain_with_phases() -> None:
    from unified_planning.io import PDDLReader

    with UNIFIED_PLANNING_LOCK:
        read = PDDLReader().parse_problem_string(*pddl_of(timed(), random_store(1), Form.TEMPORAL))
    assert {action.name for action in read.actions} == {op.name for op in timed().steps}


def test_every_phase_is_explained() -> None:
    problem = random_store(2)
    plan_net = planned(problem, timed())
    told = explain(plan_net, problem, timed(), HierarchicalEngine(timed()), QUICK)
    for action, said in zip(plan_net.actions, told.actions, strict=True):
        assert said.goals, action
        if action.phase and action.phase < action.phases:
            assert any(f"phase {action.phase} of {action.tag}" in sentence for sentence in said.because)
    assert {link.consumer for link in plan_net.causal_links} >= {GOAL}


def test_a_robot_that_has_stopped_between_two_phases_is_planned_for_from_where_it_stands() -> None:
    """It goes on with none of the later phases: that it was on its way is no longer true."""
    base = timed()
    problem = Store(aisles=1, yard_robots=1).problem([inside("s", "bay_0_0")], {"s": "door_0"})
    plan_net = planned(problem, base)
    left = next(a for a in plan_net.actions if a.tag == "TRANSPORT" and a.phase == 1 and "yard_0" in a.agents)
    done = [one for one in linearisation(plan_net) if one.earliest_end_s <= left.earliest_end_s]
    facts = progressed(problem.facts, done)
    under_way = {one for one in facts if one.predicate in base.under_way and one.args[0] == "yard_0"}
    assert len(under_way) == 1
    stopped = replace(
        problem,
        objects={**problem.objects, "open": "location"},
        facts=facts - under_way | {Fact("robot_position", ("yard_0", "near", "open"))},
        functions={
            **problem.functions,
            **{
                ("distance_m", way): 1.5
                for place in ("door_0", "door_1", "interchange_0_0", "home_yard_0")
                for way in ((place, "open"), ("open", place))
            },
        },
    )
    progress = MissionProgress(
        done=frozenset(one.id for one in done), elapsed_s=max(one.earliest_end_s for one in done)
    )
    repaired = repair(HierarchicalEngine(base), base, plan_net, stopped, progress=progress, request=QUICK)
    assert repaired.plan_net is not None, repaired.result.reason
    assert faults_of(repaired.plan_net, stopped.facts, base) == []


def test_two_robots_that_change_places_are_not_proven_to_have_no_plan() -> None:
    """Each leaves before the other goes in; with whole actions neither could begin."""
    stand = {"yard_0": "door_0", "yard_1": "interchange_0_0"}
    problem = Store(aisles=1, yard_robots=2, doors=1).problem([], {}, robots_at=stand)
    facts = frozenset(
        f for f in problem.facts if f.predicate not in ("reaches", "clear") or "home" not in "".join(f.args)
    )
    goals = tuple(
        Fact("robot_position", (one, "near", stand[other]))
        for one, other in (("yard_0", "yard_1"), ("yard_1", "yard_0"))
    )
    swap = replace(problem, facts=facts, goals=goals)
    assert unreachable_goals(load_knowledge_base(), swap)
    assert not unreachable_goals(timed(), swap)
