"""Robots that are interchangeable for planning."""

from dataclasses import replace

from app.domain.world_model import planning_problem
from planner.problem.robot_classes import AgentClasses
from robots.world import generate_world, store_shape
from tests.app.sample_store import Store

SHAPE = store_shape(samples=2, aisles=1, store_robots=2, yard_robots=2, doors=2, bays=4)


def test_robots_with_chargers_of_their_own_are_alike() -> None:
    store = Store(generate_world(SHAPE))
    problem = planning_problem(store.world, store.facts, (), knowledge_base=store.base)
    chargers = [args for name, args in problem.functions if name == "charger_w"]
    assert len(chargers) == 4
    assert len(AgentClasses(store.base, problem).members) == 2
    stronger = {call: 99.0 for call in problem.functions if call == ("charger_w", chargers[0])}
    problem = replace(problem, functions={**problem.functions, **stronger})
    assert len(AgentClasses(store.base, problem).members) == 3
