"""What the static facts of a problem say of its objects."""

from dataclasses import replace

from app.domain.world_model import planning_problem
from planner import Fact
from planner.problem.static_facts import StaticFacts
from tests.app.sample_store import Store

STORE = Store()
PROBLEM = planning_problem(STORE.world, STORE.facts, [STORE.fact("in(sample_1, bay_7)")])


def things(*facts: Fact) -> frozenset[str]:
    problem = replace(PROBLEM, facts=PROBLEM.facts | set(facts))
    return StaticFacts(STORE.base, problem).things


def test_samples_are_the_things_that_are_moved() -> None:
    assert things() == {sample.name for sample in STORE.world.samples}


def test_what_an_object_is_does_not_tie_it_down() -> None:
    assert "sample_1" in things(Fact("drill", ("sample_1",)))
    assert "sample_1" not in things(Fact("kept_in", ("sample_1", "bay_1")))


def test_an_object_that_is_something_is_no_bystander() -> None:
    problem = replace(PROBLEM, facts=PROBLEM.facts | {Fact("drill", ("sample_2",))})
    kept = StaticFacts(STORE.base, problem).without_bystanders(problem)
    assert {"sample_1", "sample_2"} == kept.objects.keys() & {sample.name for sample in STORE.world.samples}


def test_a_robot_gets_to_a_place_only_by_actions_there_are_objects_for() -> None:
    names = {op.name for op in StaticFacts(STORE.base, PROBLEM).setups}
    assert "navigate" in names
    assert not names & {"dock_long_object", "dock2", "open", "move_to_level"}
    told = Fact("kept_in", ("gate_1", "bay_1"))
    doors = replace(PROBLEM, objects={**PROBLEM.objects, "gate_1": "door"}, facts=PROBLEM.facts | {told})
    assert "open" in {op.name for op in StaticFacts(STORE.base, doors).setups}
