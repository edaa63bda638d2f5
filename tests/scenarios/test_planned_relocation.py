"""Fred and Ginger relocate a rock sample (MACTA §1, §5): from the operator's sentence to the simulated truth."""

import pytest

from app.cli.goal_input import parse_goals
from app.cli.simulated_mission import simulate_mission
from app.cli.trials.offline_mission import Mission, goal_problem, plan_mission
from planner import PlanningRequest
from planner.engines.registry import portfolio
from robots.wire import ScriptState
from robots.world.parts import PHASE_TAGS, STORE_TAGS
from tests.app.laboratory import Laboratory


def planned(lab: Laboratory) -> Mission:
    goals = parse_goals(lab.world, lab.facts, ["move rock_sample to lander"], lab.base)
    problem = goal_problem(lab.world, lab.facts, goals, lab.base)
    return plan_mission(lab.world, problem, portfolio(lab.base), lab.base, PlanningRequest(time_limit_s=60))


@pytest.fixture(scope="module")
def mission() -> Mission:
    return planned(Laboratory())


def test_two_robots_relocate_the_rock_sample_and_nobody_tells_them_what_the_other_does(
    mission: Mission,
) -> None:
    tags = {script.robot: [packet.tag for packet in script.packets] for script in mission.scripts}
    assert tags == {
        "fred": ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE1"],
        "ginger": ["TRACK", "DOCK2", "TRANSPORT", "RELEASE2"],
    }
    assert not any(packet.after for script in mission.scripts for packet in script.packets)
    ended = simulate_mission(mission, seed=0)
    assert {report.state for report in ended.reports} == {ScriptState.FINISHED}, ended.words
    assert ended.came_true, ended.words
    assert ended.truth.time_s <= 1.5 * mission.plan_net.makespan_s + 20  # the monitor's margin


def test_robots_that_drive_in_phases_relocate_it_too() -> None:
    plain = Laboratory().world
    robots = tuple(r.model_copy(update={"repertoire": (*STORE_TAGS, *PHASE_TAGS)}) for r in plain.robots)
    mission = planned(Laboratory(plain.model_copy(update={"robots": robots})))
    tags = {script.robot: [packet.tag for packet in script.packets] for script in mission.scripts}
    assert tags == {
        "fred": ["NAVIGATE_OFF", "NAVIGATE_UP", "NAVIGATE_IN", "DOCK", "TRANSPORT", "RELEASE1"],
        "ginger": ["TRACK", "DOCK2_OFF", "DOCK2", "TRANSPORT", "RELEASE2"],
    }, "what two do together has no phases"
    ended = simulate_mission(mission, seed=0)
    assert ended.came_true, ended.words
