"""Doors, hatches and lifts in the planning problem, and the plans that lead through them."""

from collections.abc import Sequence
from itertools import pairwise

import pytest

from app.domain.world_model import initial_facts, initial_spots, planning_problem
from app.domain.world_model.beliefs import OPERABLE, revise_beliefs
from app.domain.world_model.reconcile import reconcile_report
from planner import (
    Fact,
    Keeping,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    faults_of,
    load_knowledge_base,
)
from planner.engines.registry import engine_named
from planner.plan_nets.plan_net import PlanNetAction
from planner.repair import MissionProgress, repair
from robots.wire import SymbolicFact
from robots.world import load_world

WORLD = load_world("guarded_store")
BASE = load_knowledge_base()
ENGINE = engine_named("macta", BASE)
FACTS = initial_facts(WORLD, BASE)


def problem(*goals: tuple[str, str], broken: Sequence[str] = ()) -> PlanningProblem:
    """Samples to bring to places, in the world without these peripherals in service."""
    facts = frozenset(f for f in FACTS if not (f.predicate == OPERABLE and f.args[0] in broken))
    wanted = [Fact("object_position", (sample, "in", place)) for sample, place in goals]
    return planning_problem(WORLD, facts, wanted, knowledge_base=BASE, spots=initial_spots(WORLD))


def plan(*goals: tuple[str, str], broken: Sequence[str] = ()) -> PlanNet:
    result = ENGINE.plan(problem(*goals, broken=broken), PlanningRequest(effort_s=0.0))
    assert result.plan_net is not None, result.reason
    assert faults_of(result.plan_net, problem(*goals, broken=broken).facts, BASE) == []
    return result.plan_net


def of(net: PlanNet, peripheral: str) -> list[PlanNetAction]:
    return list(net.of_robot(peripheral))


def passing(net: PlanNet, fact: Fact) -> list[PlanNetAction]:
    return [action for action in net.actions if fact in action.preconditions and action.tag != "CLOSE"]


def test_a_door_opens_while_the_robot_approaches_and_closes_once_it_is_through() -> None:
    net = plan(("sample_2", "bay_1"))
    opening, closing = of(net, "gate_1")
    (way,) = passing(net, Fact("opened", ("gate_1",)))
    assert (opening.tag, opening.duration_s, opening.earliest_start_s) == ("OPEN", 4.0, 0.0)
    assert way.earliest_start_s >= opening.earliest_end_s
    assert closing.tag == "CLOSE"
    assert closing.earliest_start_s >= way.earliest_end_s
    assert Fact("closed", ("gate_1",)) in net.goals


def test_robots_wait_for_a_door_by_clearance_and_doors_sense_nothing() -> None:
    net = plan(("sample_1", "bay_1"))
    doors = {"hatch_1", "gate_1", "gate_2"}
    kept = {
        ordering.kept_by
        for ordering in net.orderings
        if {*net.action(ordering.before).agents, *net.action(ordering.after).agents} & doors
        and net.action(ordering.before).agents != net.action(ordering.after).agents
    }
    assert kept == {Keeping.CLEARANCE}


def test_a_hatch_is_open_while_a_sample_is_put_taken_or_held_in_it_and_closes_empty() -> None:
    net = plan(("sample_1", "bay_1"))
    tags = [action.tag for action in passing(net, Fact("opened", ("hatch_1",)))]
    assert tags == ["RELEASE2", "DOCK", "TRANSPORT"]
    closing = of(net, "hatch_1")[-1]
    assert Fact("vacant", ("interchange_1",)) in closing.preconditions


def test_a_hatch_stays_open_under_a_sample_that_is_to_lie_in_it() -> None:
    net = plan(("sample_1", "interchange_1"))
    assert [action.tag for action in of(net, "hatch_1")] == ["OPEN"]


def test_two_robots_share_an_opening_one_in_the_doorway_at_a_time() -> None:
    net = plan(("sample_2", "bay_1"), ("sample_1", "bay_4"))
    for gate in ("gate_1", "gate_2"):
        ways = sorted(passing(net, Fact("opened", (gate,))), key=lambda action: action.earliest_start_s)
        assert len(of(net, gate)) == (2 if ways else 0)
        for one, other in pairwise(ways):
            assert other.earliest_start_s >= one.earliest_end_s


def test_a_lift_rides_with_a_robot_in_its_cabin() -> None:
    net = plan(("sample_3", "bay_1"))
    up, down = of(net, "lift_1")
    assert (up.arguments["level2"], down.arguments["level2"]) == ("upper", "ground")
    assert up.duration_s == 3.0 + 8.0 + 3.0
    into, *_ = passing(net, Fact("lift_at", ("lift_1", "ground")))
    assert into.earliest_end_s <= up.earliest_start_s


def test_a_plan_leads_by_another_way_round_a_gate_out_of_service() -> None:
    net = plan(("sample_2", "bay_1"), broken=["gate_1"])
    assert of(net, "gate_1") == []
    assert [action.tag for action in of(net, "gate_2")] == ["OPEN", "CLOSE"]


@pytest.mark.parametrize(
    ("goal", "broken", "words"),
    [
        (("sample_1", "bay_1"), ["hatch_1"], "hatch_1 is not open"),
        (("sample_3", "bay_1"), ["lift_1"], "lift_1 is not at upper"),
        (("sample_2", "bay_1"), ["gate_1", "gate_2"], "gate_1 is not open and gate_2 is not open"),
    ],
)
def test_a_goal_without_a_way_is_refused_naming_what_does_not_open(
    goal: tuple[str, str], broken: list[str], words: str
) -> None:
    result = ENGINE.plan(problem(goal, broken=broken), PlanningRequest(effort_s=0.0))
    assert result.status is PlanningStatus.UNSOLVABLE
    assert words in result.reason


def test_a_wall_is_in_the_way_and_an_open_door_is_not() -> None:
    functions = problem(("sample_2", "bay_1")).functions
    assert ("distance_m", ("bay_1", "bay_3")) not in functions
    assert ("distance_m", ("gate_west", "gate_east")) in functions
    assert ("distance_m", ("lift_below", "lift_above")) not in functions


def test_a_world_without_doors_has_every_way_as_before() -> None:
    store = load_world("sample_store")
    plain = planning_problem(store, initial_facts(store, BASE), [], knowledge_base=BASE)
    assert not plain.access.ways
    assert ("distance_m", ("bay_1", "bay_6")) in plain.functions


def test_a_plan_does_not_rest_on_a_door_that_closes_by_itself() -> None:
    opened = Fact("opened", ("gate_1",))
    facts = revise_beliefs(FACTS, [opened])
    assert Fact("closed", ("gate_1",)) not in facts
    assert opened not in planning_problem(WORLD, facts, [], knowledge_base=BASE).facts
    assert opened in planning_problem(WORLD, facts, [], knowledge_base=BASE, is_held=True).facts


def test_goals_may_ask_that_a_door_be_open() -> None:
    wanted = Fact("opened", ("gate_2",))
    asked = planning_problem(WORLD, FACTS, [wanted], knowledge_base=BASE)
    net = ENGINE.plan(asked, PlanningRequest()).plan_net
    assert net is not None
    assert [(action.agents, action.tag) for action in net.actions] == [(("gate_2",), "OPEN")]


def test_a_repair_opens_another_gate_for_a_robot_that_holds_its_sample() -> None:
    net = plan(("sample_2", "bay_1"))
    holding = [action for action in net.actions if action.tag in ("NAVIGATE", "DOCK")]
    facts = FACTS
    for action in holding:
        facts = revise_beliefs(facts, action.effects, action.deletes)
    facts = frozenset(f for f in facts if f != Fact(OPERABLE, ("gate_1",)))
    goal = Fact("object_position", ("sample_2", "in", "bay_1"))
    left = planning_problem(WORLD, facts, [goal], knowledge_base=BASE, is_held=True)
    progress = MissionProgress(done=frozenset(action.id for action in holding), elapsed_s=20.0)
    mended = repair(ENGINE, BASE, net, left, progress, PlanningRequest(effort_s=0.0)).result.plan_net
    assert mended is not None
    assert {"gate_2", "store_2"} == set(mended.robots)


@pytest.mark.parametrize(
    ("perceived", "holds"),
    [
        ((), {"closed"}),
        ((SymbolicFact(predicate="half_way", args=("gate_1",)),), set()),
        ((SymbolicFact(predicate="opened", args=("gate_1",)),), {"opened"}),
        ((SymbolicFact(predicate="opened", args=("gate_2",)),), {"closed"}),
    ],
)
def test_a_door_is_believed_to_stand_as_it_says_of_itself(
    perceived: tuple[SymbolicFact, ...], holds: set[str]
) -> None:
    after = reconcile_report(FACTS, "gate_1", perceived, BASE).apply(FACTS)
    of_gate = {fact.predicate for fact in after if fact.args == ("gate_1",)}
    assert of_gate == holds | {OPERABLE}
