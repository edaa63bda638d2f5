"""Variables found in knowledge bases: of each, at most one fact at a time."""

from planner import Fact, KnowledgeBase, read_knowledge_base
from planner.knowledge.invariants import Variable, variables_of
from tests.planner.engines.hierarchical.survey import SURVEY

STORE = frozenset({"area", "location", "robot", "object"})
SURVEYED = frozenset({"site", "rover", "gate", "tool", "rock", "box"})


def the_one_with(variables: tuple[Variable, ...], fact: Fact, name: str) -> Variable:
    (found,) = (one for one in variables if one.has(fact.predicate, fact.args, name))
    return found


def test_a_sample_is_in_one_place_and_a_robot_stands_in_one(knowledge_base: KnowledgeBase) -> None:
    (place,) = variables_of(knowledge_base, frozenset({"object"}), STORE)
    assert place.has("object_position", ("s", "in", "bay_1"), "s")
    assert place.has("object_position", ("s", "in", "fred"), "s")
    stands = Fact("robot_position", ("fred", "near", "bay_1"))
    variable = the_one_with(variables_of(knowledge_base, frozenset({"robot"}), STORE), stands, "fred")
    assert variable.has("robot_position", ("fred", "at", "bay_2"), "fred")


def test_jaws_are_empty_or_hold_one_thing(knowledge_base: KnowledgeBase) -> None:
    holding = Fact("object_position", ("s", "in", "fred"))
    jaws = the_one_with(variables_of(knowledge_base, frozenset({"robot"}), STORE), holding, "fred")
    assert jaws.has("robot_attribute", ("fred", "gripper", "empty"), "fred")
    assert not jaws.has("robot_attribute", ("fred", "gripper", "full"), "fred")
    assert not jaws.is_single([holding, Fact("object_position", ("t", "in", "fred"))], "fred")


def test_what_an_action_adds_without_taking_away_is_no_variable() -> None:
    base = read_knowledge_base(SURVEY, "survey.yaml")
    rover = variables_of(base, frozenset({"rover"}), SURVEYED)
    assert not any(one.has("charged", ("ann",), "ann") for one in rover)
    hands = the_one_with(rover, Fact("free", ("ann",)), "ann")
    assert hands.has("holds", ("ann", "camera"), "ann")
    assert variables_of(base, frozenset({"rock"}), SURVEYED) == ()
