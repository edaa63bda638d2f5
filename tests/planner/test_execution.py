"""What the scripts allow: hand-made plan-nets that a planner might think fine."""

from collections.abc import Sequence
from dataclasses import replace

from planner import INITIAL, Fact, KnowledgeBase, PlanNet, PlanningProblem, first_violation
from planner.assembly import assemble
from planner.extraction import extract
from planner.validation import faults_of
from tests.planner.store import inside, store_problem

AREAS = {"yard_1": "yard", "yard_2": "yard", "store_1": "aisle_1", "store_2": "aisle_2"}


def plan_net_of(base: KnowledgeBase, problem: PlanningProblem, steps: Sequence[str]) -> PlanNet:
    """From steps such as `yard_1 carry sample_1 door_1 interchange_1` (grip, transport, release) or `yard_1
    go a b`."""
    sequence = []
    for step in steps:
        robot, verb, *rest = step.split()
        own = {"robots": robot, "rel1": "near", "rel2": "near", "area": AREAS[robot]}
        if verb == "go":
            todo = [("NAVIGATE", own | {"ref1": rest[0], "ref2": rest[1]})]
        else:
            places = own | {"object": rest[0], "ref1": rest[1], "ref2": rest[2]}
            todo = [("DOCK", places), *((tag, places | {"rel1": "at"}) for tag in ("TRANSPORT", "RELEASE2"))]
        sequence += [
            base.ground(tag, given, problem.functions, objects=problem.objects) for tag, given in todo
        ]
    order = extract(sequence, problem.facts, problem.goals)
    plan_net = assemble(order, problem.goals, base, {})
    assert faults_of(plan_net, problem.facts, base) == []
    return plan_net


def test_handing_over_at_an_interchange_is_safe_by_sensing_alone(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_1")], samples={"sample_1": "door_1"})
    steps = [
        "yard_1 go home_yard_1 door_1",
        "yard_1 carry sample_1 door_1 interchange_1",
        "store_1 go home_store_1 interchange_1",
        "store_1 carry sample_1 interchange_1 bay_1",
    ]
    plan_net = plan_net_of(knowledge_base, problem, steps)
    assert first_violation(plan_net, problem.facts, problem.objects, knowledge_base) is None


def test_two_robots_that_use_one_interchange_from_one_side_may_clash(knowledge_base: KnowledgeBase) -> None:
    """The second waits for a place that is clear from the start: it may be there first. The plan-net itself
    is valid."""
    samples = {"sample_1": "door_1", "sample_2": "door_2"}
    problem = store_problem([inside("sample_1", "bay_1"), inside("sample_2", "bay_2")], samples=samples)
    steps = [
        "yard_1 go home_yard_1 door_1",
        "yard_1 carry sample_1 door_1 interchange_1",
        "store_1 go home_store_1 interchange_1",
        "store_1 carry sample_1 interchange_1 bay_1",
        "yard_1 go interchange_1 door_1",
        "yard_2 go home_yard_2 door_2",
        "yard_2 carry sample_2 door_2 interchange_1",
        "store_1 go bay_1 interchange_1",
        "store_1 carry sample_2 interchange_1 bay_2",
    ]
    plan_net = plan_net_of(knowledge_base, problem, steps)
    violation = first_violation(plan_net, problem.facts, problem.objects, knowledge_base)
    assert violation is not None
    assert violation.fact == Fact("clear", ("interchange_1", "yard"))
    assert violation.agents >= {"yard_1", "yard_2"}


def test_one_robot_may_hand_over_twice_at_one_interchange(knowledge_base: KnowledgeBase) -> None:
    samples = {"sample_1": "door_1", "sample_2": "door_2"}
    problem = store_problem([inside("sample_1", "bay_1"), inside("sample_2", "bay_2")], samples=samples)
    steps = [
        "yard_1 go home_yard_1 door_1",
        "yard_1 carry sample_1 door_1 interchange_1",
        "store_1 go home_store_1 interchange_1",
        "store_1 carry sample_1 interchange_1 bay_1",
        "yard_1 go interchange_1 door_2",
        "yard_1 carry sample_2 door_2 interchange_1",
        "store_1 go bay_1 interchange_1",
        "store_1 carry sample_2 interchange_1 bay_2",
    ]
    plan_net = plan_net_of(knowledge_base, problem, steps)
    assert first_violation(plan_net, problem.facts, problem.objects, knowledge_base) is None


def test_swapping_directions_at_one_interchange_may_clash_or_not(knowledge_base: KnowledgeBase) -> None:
    """Taking before bringing is safe; bringing one while the other side may bring too is not."""
    samples = {"sample_1": "door_1", "sample_2": "bay_2"}
    problem = store_problem([inside("sample_1", "bay_1"), inside("sample_2", "door_1")], samples=samples)
    bring_in = [
        "yard_1 go home_yard_1 door_1",
        "yard_1 carry sample_1 door_1 interchange_1",
        "store_1 go home_store_1 interchange_1",
        "store_1 carry sample_1 interchange_1 bay_1",
    ]
    bring_out = [
        "store_1 go bay_1 bay_2",
        "store_1 carry sample_2 bay_2 interchange_1",
        "yard_1 carry sample_2 interchange_1 door_1",
    ]
    plan_net = plan_net_of(knowledge_base, problem, bring_in + bring_out)
    assert first_violation(plan_net, problem.facts, problem.objects, knowledge_base) is None


def test_what_another_robot_brings_about_unseen_is_a_violation(knowledge_base: KnowledgeBase) -> None:
    """No planner does this here: the link is bent by hand to another robot's action."""
    problem = store_problem([inside("sample_1", "bay_1")], samples={"sample_1": "interchange_1"})
    steps = ["store_1 go home_store_1 interchange_1", "store_1 carry sample_1 interchange_1 bay_1"]
    plan_net = plan_net_of(knowledge_base, problem, steps)
    link = next(
        x for x in plan_net.causal_links if x.fact.predicate == "robot_position" and x.producer != INITIAL
    )
    stranger = replace(plan_net.action(link.producer), id="a9", agents=("store_2",))
    tampered = replace(
        plan_net,
        actions=(*plan_net.actions, stranger),
        causal_links=tuple(replace(x, producer="a9") if x == link else x for x in plan_net.causal_links),
    )
    violation = first_violation(tampered, problem.facts, problem.objects, knowledge_base)
    assert violation is not None
    assert "cannot sense" in violation.reason
