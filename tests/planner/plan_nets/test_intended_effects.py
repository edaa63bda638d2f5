"""Only intended effects achieve goals (MACTA §5, table 3), on small knowledge bases of our own."""

from planner import (
    Fact,
    FastDownwardEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    read_knowledge_base,
)

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
READY = Fact("ready", ("fred",))


def plan(*goals: Fact, facts: frozenset[Fact] = frozenset({READY}), make_way: bool = False):  # type: ignore[no-untyped-def]
    base = read_knowledge_base(SMALL.replace("MAKE_WAY", str(make_way).lower()), "small.yaml")
    problem = PlanningProblem(objects={"fred": "robot", "lamp_1": "lamp"}, facts=facts, goals=goals)
    return FastDownwardEngine(base).plan(problem, PlanningRequest(time_limit_s=60))


def test_an_intended_effect_achieves_a_goal() -> None:
    result = plan(Fact("lit", ("lamp_1",)))
    assert [action.tag for action in result.plan_net.actions] == ["LIGHT"]


def test_a_goal_that_only_comes_about_by_the_way_is_unsolvable() -> None:
    result = plan(Fact("warm", ("lamp_1",)))
    assert result.status is PlanningStatus.UNSOLVABLE
    assert "only comes about by the way" in result.reason


def test_a_goal_that_already_holds_needs_no_action() -> None:
    warm = Fact("warm", ("lamp_1",))
    result = plan(warm, facts=frozenset({READY, warm}))
    assert result.status is PlanningStatus.SOLVED
    assert result.plan_net.actions == ()


def test_a_goal_beside_another_is_not_achieved_by_the_way_either() -> None:
    result = plan(Fact("lit", ("lamp_1",)), Fact("warm", ("lamp_1",)))
    assert result.status is PlanningStatus.UNSOLVABLE


def test_an_action_chosen_for_its_own_goal_may_serve_another_by_the_way() -> None:
    result = plan(Fact("lit", ("lamp_1",)), Fact("dusted", ("lamp_1",)))
    assert [action.tag for action in result.plan_net.actions] == ["LIGHT", "DUST"]


def test_no_action_is_there_only_for_what_it_does_not_intend() -> None:
    result = plan(Fact("dusted", ("lamp_1",)))
    assert result.status is PlanningStatus.NOT_FOUND
    assert "warm(lamp_1), which it does not intend" in result.reason


def test_making_way_is_the_exception_a_knowledge_base_may_declare() -> None:
    result = plan(Fact("dusted", ("lamp_1",)), make_way=True)
    assert [action.tag for action in result.plan_net.actions] == ["LIGHT", "DUST"]
