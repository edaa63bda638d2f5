"""Two robots carry a long object: the knowledge base's variants, and plans with a team."""

import pytest

from planner import (
    Fact,
    Keeping,
    KnowledgeBase,
    KnowledgeBaseError,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    faults_of,
    load_knowledge_base,
    read_knowledge_base,
)
from planner.engines.registry import engine_named
from tests.planner.laboratory import GOAL, HOME, laboratory

BASE = load_knowledge_base()
ANYTIME = ("NAVIGATE", "RELEASE1", "RELEASE2")  # who does these may differ
REQUEST = PlanningRequest(time_limit_s=30, effort_s=0.0)


@pytest.fixture(scope="module", params=["macta", "fast-downward"])
def engine(request: pytest.FixtureRequest) -> PlanningEngine:
    return engine_named(request.param, BASE)


def test_two_robots_relocate_a_long_object_coupled_by_sensing_alone(engine: PlanningEngine) -> None:
    problem = laboratory()
    plan_net = engine.plan(problem, REQUEST).plan_net
    assert plan_net is not None
    assert faults_of(plan_net, problem.facts, BASE) == []
    tags = {tuple(a.tag for a in plan_net.of_robot(r) if a.tag not in ANYTIME) for r in plan_net.robots}
    assert tags == {("DOCK", "TRANSPORT"), ("TRACK", "DOCK2", "TRANSPORT")}
    assert {action.tag for action in plan_net.actions[-2:]} == {"RELEASE1", "RELEASE2"}
    assert {ordering.kept_by for ordering in plan_net.orderings} <= {Keeping.ROBOT, Keeping.SENSING}


def test_one_robot_cannot_relocate_a_long_object_and_that_is_said(engine: PlanningEngine) -> None:
    result = engine.plan(laboratory(robots=("fred",)), REQUEST)
    assert result.plan_net is None
    assert result.status is PlanningStatus.UNSOLVABLE


def test_a_compact_object_still_takes_one_robot(engine: PlanningEngine) -> None:
    goal = Fact("object_position", ("pebble", "in", "lander"))
    plan_net = engine.plan(laboratory(goal), REQUEST).plan_net
    assert plan_net is not None
    assert [action.tag for action in plan_net.actions] == ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]


def test_the_place_that_two_robots_share_is_not_clear_before_both_have_left(engine: PlanningEngine) -> None:
    """Who lets go stands on the open floor, so only who puts the object down gives the place free."""
    plan_net = engine.plan(laboratory(GOAL, *HOME), REQUEST).plan_net
    assert plan_net is not None
    makers = [action for action in plan_net.actions if Fact("clear", ("lander", "lab")) in action.effects]
    released = [action for action in plan_net.actions if action.tag == "RELEASE2"]
    assert [maker.agents for maker in makers] == [action.agents for action in released]


def ground(tag: str, problem: PlanningProblem, **arguments: str) -> object:
    return BASE.ground(tag, arguments, problem.functions, objects=problem.objects)


CARRIED = {"rel1": "at", "ref1": "quarry", "rel2": "near", "ref2": "lander"}


@pytest.mark.parametrize(
    ("thing", "robots", "wrong"),
    [
        ("rock_sample", "fred", "'rock_sample' is no object"),
        ("pebble", "fred+ginger", "'pebble' is no long_"),
    ],
)
def test_the_size_of_the_team_goes_by_the_object(thing: str, robots: str, wrong: str) -> None:
    with pytest.raises(KnowledgeBaseError, match=wrong):
        ground("TRANSPORT", laboratory(), object=thing, robots=robots, area="lab", **CARRIED)


def test_only_who_holds_a_long_object_alone_puts_it_down() -> None:
    problem = laboratory()
    alone = Fact("holds_alone", ("ginger", "rock_sample"))
    long = ground("RELEASE2", problem, object="rock_sample", robots="ginger", **CARRIED)
    compact = ground("RELEASE2", problem, object="pebble", robots="ginger", **CARRIED)
    assert alone in long.preconditions  # type: ignore[attr-defined]
    assert all(fact.predicate != "holds_alone" for fact in compact.preconditions)  # type: ignore[attr-defined]


def test_operators_of_compact_objects_are_called_as_ever(knowledge_base: KnowledgeBase) -> None:
    names = [op.name for op in knowledge_base.operators if op.parameters.get("object") == "object"]
    errands = ["transport_at", "transport_near", "dock", "release2_at", "release2_near"]
    assert names == [*errands, "carry_at", "carry_near"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "types: {object: long_object}",
            "types: {robots: long_object}",
            "variants.1.types.robots: unknown robot",
        ),
        (
            "types: {object: long_object}",
            "types: {thing: object}",
            "variants.1.types: unknown parameter 'thing'",
        ),
        (
            "teams: {robots: 2}",
            "teams: {robots: 3}",
            "variants.1.teams.robots: unknown size '3'; choices: 1, 2",
        ),
        ("teams: {robots: 2}", "teams: {ref1: 2}", "unknown list of robots 'ref1'; choices: robots"),
        (
            '"brought(object, ref2)"',
            '"brought(ref1, ref2)"',
            "variants.1.intended_effects.0: ref1 is a location",
        ),
        ('"brought(object, ref2)"', '"bought(object)"', "unknown predicate 'bought'"),
    ],
)
def test_a_variant_is_checked(old: str, new: str, message: str) -> None:
    from importlib import resources

    text = (resources.files("planner.knowledge") / "files" / "rovers.yaml").read_text()
    assert old in text
    with pytest.raises(KnowledgeBaseError) as error:
        read_knowledge_base(text.replace(old, new, 1), "kb.yaml")
    assert message in str(error.value)
