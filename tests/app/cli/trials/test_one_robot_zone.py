"""Missions through a passage for one robot at a time: planned, organised and driven."""

from collections.abc import Iterator

import pytest

from app.cli.trials.offline_mission import Mission, goal_problem, plan_mission
from app.domain.world_model import initial_facts
from planner import PlanningRequest, load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from robots.wire import ScriptState, SymbolicFact
from robots.world import WorldFile, ZoneRule
from sim.trials.script_runner import ScriptRunner

BASE = load_knowledge_base()
EAST, WEST = 180, 0
ROBOTS = {
    "rover_1": ((0.8, 2.0), WEST, "east_1"),
    "rover_2": ((13.2, 2.0), EAST, "west_1"),
    "rover_3": ((0.8, 5.0), WEST, "east_2"),
    "rover_4": ((13.2, 5.0), EAST, "west_2"),
}
"""Home, its side, and where each robot is to go: through the passage."""
PLACES = {
    "west_1": ((3.0, 3.0), WEST),
    "west_2": ((3.0, 4.0), WEST),
    "east_1": ((11.0, 3.0), EAST),
    "east_2": ((11.0, 4.0), EAST),
}


def hall(count: int, rule: ZoneRule) -> WorldFile:
    """A hall in two halves with a passage between them, and the first robots."""
    homes = {f"home_{name}": (home, side) for name, (home, side, _) in ROBOTS.items()}
    starts = {
        name: (home[0] + (0.8 if side == WEST else -0.8), home[1], side)
        for name, (home, side, _) in ROBOTS.items()
    }
    return WorldFile.model_validate(
        {
            "name": "hall",
            "compartments": [{"name": "floor", "x": [0, 14], "y": [0, 7]}],
            "walls": [{"start": [7, 0], "end": [7, 2.5]}, {"start": [7, 4.5], "end": [7, 7]}],
            "zones": [{"name": "passage", "x": [6, 8], "y": [0, 7], "rule": rule}],
            "locations": [
                {
                    "name": name,
                    "kind": "home" if name in homes else "place",
                    "at": at,
                    "approach_deg": [side],
                    "capacity": 0,
                }
                for name, (at, side) in {**homes, **PLACES}.items()
            ],
            "robots": [
                {"name": name, "compartment": "floor", "start": starts[name], "home": f"home_{name}"}
                for name in list(ROBOTS)[:count]
            ],
        }
    )


def mission(world: WorldFile) -> Mission:
    """Every robot goes to the other side."""
    goals = [SymbolicFact(predicate="near", args=(one.name, ROBOTS[one.name][2])) for one in world.robots]
    problem = goal_problem(world, initial_facts(world, BASE), goals, BASE)
    return plan_mission(world, problem, HierarchicalEngine(BASE), BASE, PlanningRequest(effort_s=0.0))


class Watch:
    """Counts the robots in the passage, twenty times a second."""

    def __init__(self, runner: ScriptRunner) -> None:
        self._runner = runner
        self.counts: list[int] = []

    def __call__(self) -> None:
        (zone,) = self._runner.world.zones
        poses = self._runner.simulation.truth().robots.values()
        self.counts.append(sum(zone.contains((pose.x_m, pose.y_m)) for pose in poses))


def driven(count: int, rule: ZoneRule, seed: int) -> tuple[Watch, Iterator[ScriptState]]:
    world = hall(count, rule)
    planned = mission(world)
    with ScriptRunner(world, seed=seed) as runner:
        watch = Watch(runner)
        assert runner.run(planned.scripts, meanwhile=watch, timeout_s=300.0)
        assert not runner.refused
        return watch, (report.state for report in runner.ended.values())


@pytest.mark.parametrize("count", [2, 3, 4])
def test_robots_pass_one_at_a_time_and_all_arrive(count: int) -> None:
    watch, states = driven(count, ZoneRule.ONE_ROBOT, seed=count)
    assert set(states) == {ScriptState.FINISHED}
    assert max(watch.counts) == 1
    free, _ = driven(count, ZoneRule.NAMED, seed=count)
    assert max(free.counts) > 1
