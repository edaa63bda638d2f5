"""Locations with room for several samples, from an operator's sentence to the simulated world's truth."""

from functools import cache
from typing import Any

import pytest

from app.cli.goal_input import parse_goals
from app.cli.simulated_mission import simulate_mission
from app.cli.trials.offline_mission import Mission, goal_problem, plan_mission
from app.domain.world_model import initial_facts
from planner import PlanningRequest, load_knowledge_base
from planner.engines.registry import engine_named
from robots.wire import ScriptState
from robots.world import WorldFile, load_world

FULL = [{"name": f"sample_{n}", "at": "bay_7"} for n in (1, 2, 3)]
AT_DOORS = [{"name": f"sample_{n}", "at": at} for n, at in ((1, "door_1"), (2, "door_1"), (3, "door_2"))]


def racks(samples: list[dict[str, Any]]) -> WorldFile:
    """The sample store with three berths in each bay, two at each door, and two at each of its wider interchanges."""
    file = load_world("sample_store").model_dump()
    room = {"bay": 3, "door": 2, "interchange": 2, "home": 0}
    for place in file["locations"]:
        place["capacity"] = room[place["kind"]]
    for wall in file["walls"]:
        wall["openings"] = [o | {"width_m": 1.2} if o["kind"] == "hatch" else o for o in wall["openings"]]
    return WorldFile.model_validate(file | {"samples": samples})


@cache
def mission(sentence: str, start: str) -> Mission:
    world = racks(FULL if start == "full" else AT_DOORS)
    base = load_knowledge_base()
    facts = initial_facts(world, base)
    problem = goal_problem(world, facts, parse_goals(world, facts, [sentence], base), base)
    return plan_mission(
        world, problem, engine_named("macta", base), base, PlanningRequest(time_limit_s=30, effort_s=0)
    )


@pytest.mark.parametrize(
    ("start", "sentence"),
    [
        ("doors", "move sample_1 to bay_7, sample_2 to bay_7 and sample_3 to bay_7"),
        ("doors", "move sample_1 to interchange_1 and sample_3 to interchange_1"),
        ("full", "move sample_1 to door_2, sample_2 to bay_8 and sample_3 to door_2"),
    ],
    ids=["filled", "two at one interchange", "emptied"],
)
def test_robots_dock_at_every_berth(start: str, sentence: str) -> None:
    one = mission(sentence, start)
    assert len({goal.args[1] for goal in one.goals}) == len(one.goals)
    ended = simulate_mission(one, seed=0)
    assert {report.state for report in ended.reports} == {ScriptState.FINISHED}, ended.words
    assert ended.came_true, ended.words
