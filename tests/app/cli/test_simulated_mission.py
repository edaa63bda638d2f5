"""How a mission ends that is carried out in a simulation of its own."""

import pytest

from app.cli import simulated_mission
from app.cli.simulated_mission import Outcome, simulate_mission
from app.cli.trials.offline_mission import goal_problem, plan_mission
from app.domain.world_model import initial_facts
from planner import PlanningRequest, load_knowledge_base
from planner.engines.registry import portfolio
from robots.world import load_world
from tests.app.sample_store import said


def test_a_mission_that_does_not_end_in_time_says_what_its_robots_do(monkeypatch: pytest.MonkeyPatch) -> None:
    world, base = load_world("sample_store"), load_knowledge_base()
    goals = [said("near(yard_1, door_2)")]
    problem = goal_problem(world, initial_facts(world, base), goals, base)
    request = PlanningRequest(time_limit_s=60, effort_s=0.0)
    mission = plan_mission(world, problem, portfolio(base), base, request)
    monkeypatch.setattr(simulated_mission, "BASE_LIMIT_S", 2.0)
    monkeypatch.setattr(simulated_mission, "LIMIT_FACTOR", 0.0)
    ended = simulate_mission(mission, seed=0)
    assert ended.outcome is Outcome.UNENDED
    assert ended.reason == "not ended after 2 s: yard_1 NAVIGATE running"
