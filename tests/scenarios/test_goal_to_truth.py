"""From an operator's sentence to the simulated world's truth: understood, planned, organised, carried out.

Several goals stated together share robots, interchanges and places; their robots keep in step by sensing, and
by clearance where that does not suffice.
"""

import pytest

from app.cli.goal_input import parse_goals
from app.cli.simulated_mission import simulate_mission
from app.cli.trials.offline_mission import Mission, goal_problem, organised_mission, plan_mission
from benchmarks.errands import with_sample
from planner import PlanningRequest
from planner.engines.registry import portfolio
from robots.wire import ScriptState
from robots.world import load_world
from tests.app.sample_store import Store


def mission(sentence: str) -> Mission:
    store = Store()
    goals = parse_goals(store.world, store.facts, [sentence], store.base)
    problem = goal_problem(store.world, store.facts, goals, store.base)
    return plan_mission(
        store.world, problem, portfolio(store.base), store.base, PlanningRequest(time_limit_s=60)
    )


@pytest.mark.parametrize(
    ("seed", "sentence"),
    [
        (0, "store sample_1 in bay_12"),
        (1, "bring sample_4 to door_2"),
        (2, "move sample_3 to bay_7"),
        (3, "move sample_1 to bay_7 and take sample_4 to door_2"),
        (4, "move sample_1 to bay_9 and move sample_2 to bay_10"),
        (5, "move sample_1 to bay_3, sample_4 to bay_1 and sample_2 to door_2"),
    ],
)
def test_what_the_operator_asked_for_becomes_true_in_time(seed: int, sentence: str) -> None:
    """In time: in the estimate with the monitor's margin."""
    one = mission(sentence)
    ended = simulate_mission(one, seed=seed)
    assert {report.state for report in ended.reports} == {ScriptState.FINISHED}, ended.words
    assert ended.came_true, ended.words
    assert ended.truth.time_s <= 1.5 * one.plan_net.makespan_s + 20


def test_two_robots_use_one_interchange_one_after_the_other_by_clearance() -> None:
    """yard_2 sees the interchange clear from the start, but is to come after yard_1."""
    store = Store(with_sample(load_world("sample_store"), "sample_2", "door_2", vacant="bay_3"))
    one = organised_mission(store.world, store.one_interchange_twice(), store.base)
    assert any(packet.after for script in one.scripts for packet in script.packets)
    ended = simulate_mission(one, seed=0)
    assert {report.state for report in ended.reports} == {ScriptState.FINISHED}, ended.words
    assert ended.came_true, ended.words
