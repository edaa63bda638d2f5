"""Only intended effects achieve goals (MACTA §5, table 3), on small knowledge bases of our own."""

from dataclasses import replace
from typing import Protocol

import pytest

from planner import (
    Fact,
    KnowledgeBase,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    read_knowledge_base,
)
from planner.engines.detours import without_detours
from planner.engines.fast_downward import FastDownwardEngine
from planner.engines.registry import engine_named
from planner.interchange.up_validation import up_fault

SMALL = """
types: {robot: {}, lamp: {}}
functions: {}
predicates:
  lit: {arguments: {lamp: lamp}, sensed: true}
  warm: {arguments: {lamp: lamp}, make_way: MAKE_WAY}
  ready: {arguments: {robot: robot}}
  dusted: {arguments: {lamp: lamp}}
actions:
  - identifier: 1
    name: LIGHT
    parameters: [{name: robot, type: robot}, {name: lamp, type: lamp}]
    agents: [robot]
    preconditions: [ready(robot)]
    delete: []
    intended_effects: [lit(lamp)]
    other_effects: [warm(lamp)]
    duration: "3"
    description: "{robot} light {lamp}"
  - identifier: 2
    name: DUST
    parameters: [{name: robot, type: robot}, {name: lamp, type: lamp}]
    agents: [robot]
    preconditions: [ready(robot), warm(lamp)]
    delete: []
    intended_effects: [dusted(lamp)]
    other_effects: []
    duration: "2"
    description: "{robot} dust {lamp}"
"""
PATROL = """
types: {robot: {}, place: {}}
predicates:
  at: {arguments: {robot: robot, place: place}}
  seen: {arguments: {place: place}}
actions:
  - identifier: 1
    name: GO
    parameters: [{name: robot, type: robot}, {name: start, type: place}, {name: end, type: place}]
    agents: [robot]
    preconditions: ["at(robot, start)"]
    delete: ["at(robot, start)"]
    intended_effects: ["at(robot, end)", seen(end)]
    other_effects: [seen(start)]
    duration: "1"
    description: "{robot} go to {end}"
"""
BASE = read_knowledge_base(SMALL.replace("MAKE_WAY", "false"), "small.yaml")
MAKING_WAY = read_knowledge_base(SMALL.replace("MAKE_WAY", "true"), "small.yaml")
OBJECTS = {"fred": "robot", "lamp_1": "lamp"}
READY = Fact("ready", ("fred",))
LIT = Fact("lit", ("lamp_1",))
WARM = Fact("warm", ("lamp_1",))


def problem(*goals: Fact, facts: frozenset[Fact] = frozenset({READY})) -> PlanningProblem:
    return PlanningProblem(objects=OBJECTS, facts=facts, goals=goals)


class Plan(Protocol):
    def __call__(
        self, *goals: Fact, facts: frozenset[Fact] = frozenset({READY}), base: KnowledgeBase = BASE
    ) -> PlanningResult: ...


@pytest.fixture(params=["fast-downward", "macta"])
def plan(request: pytest.FixtureRequest) -> Plan:
    def planned(
        *goals: Fact, facts: frozenset[Fact] = frozenset({READY}), base: KnowledgeBase = BASE
    ) -> PlanningResult:
        engine = engine_named(request.param, base)
        return engine.plan(problem(*goals, facts=facts), PlanningRequest(time_limit_s=60))

    return planned


def test_an_intended_effect_achieves_a_goal(plan: Plan) -> None:
    result = plan(LIT)
    assert [action.tag for action in result.plan_net.actions] == ["LIGHT"]


def test_a_goal_that_only_comes_about_by_the_way_is_unsolvable(plan: Plan) -> None:
    result = plan(WARM)
    assert result.status is PlanningStatus.UNSOLVABLE
    assert "only comes about as a side effect" in result.reason


def test_a_goal_that_already_holds_needs_no_action(plan: Plan) -> None:
    result = plan(WARM, facts=frozenset({READY, WARM}))
    assert result.status is PlanningStatus.SOLVED
    assert result.plan_net.actions == ()


def test_a_goal_beside_another_is_not_achieved_by_the_way_either(plan: Plan) -> None:
    result = plan(LIT, WARM)
    assert result.status is PlanningStatus.UNSOLVABLE


def test_an_action_chosen_for_its_own_goal_may_serve_another_by_the_way(plan: Plan) -> None:
    result = plan(LIT, Fact("dusted", ("lamp_1",)))
    assert [action.tag for action in result.plan_net.actions] == ["LIGHT", "DUST"]


def test_no_action_is_there_only_for_what_it_does_not_intend(plan: Plan) -> None:
    assert plan(Fact("dusted", ("lamp_1",))).status is PlanningStatus.NOT_FOUND


def test_the_reason_names_the_effect_that_is_not_intended() -> None:
    goal = Fact("dusted", ("lamp_1",))
    result = FastDownwardEngine(BASE).plan(problem(goal), PlanningRequest(time_limit_s=60))
    assert "warm(lamp_1), which it does not intend" in result.reason


def test_making_way_is_the_exception_a_knowledge_base_may_declare(plan: Plan) -> None:
    result = plan(Fact("dusted", ("lamp_1",)), base=MAKING_WAY)
    assert [action.tag for action in result.plan_net.actions] == ["LIGHT", "DUST"]


def test_the_second_opinion_counts_intended_effects_only(plan: Plan) -> None:
    plan_net = plan(LIT).plan_net
    assert plan_net is not None
    assert up_fault(BASE, problem(LIT), plan_net) is None
    assert up_fault(BASE, problem(WARM), replace(plan_net, goals=(WARM,))) is not None


def test_a_shorter_sequence_that_reaches_a_goal_by_the_way_only_is_not_taken() -> None:
    base = read_knowledge_base(PATROL, "patrol.yaml")
    objects = {"fred": "robot", "a": "place", "b": "place"}
    there_and_back = [
        base.ground("GO", {"robot": "fred", "start": start, "end": end}, {}, objects=objects)
        for start, end in [("a", "b"), ("b", "a")]
    ]
    patrol = PlanningProblem(
        objects=objects, facts=frozenset({Fact("at", ("fred", "a"))}), goals=(Fact("seen", ("a",)),)
    )
    assert without_detours(there_and_back, patrol, base) == tuple(there_and_back)
    one_way = replace(patrol, goals=(Fact("seen", ("b",)),))
    assert without_detours(there_and_back, one_way, base) == tuple(there_and_back[:1])
