"""A virtual robot is never recruited to carry a real long object: its partner would carry it alone."""

from typing import Any

import pytest

from app.domain.world_model import initial_facts, planning_problem
from planner import Fact, PlanningRequest, PlanningResult, PlanningStatus, load_knowledge_base
from planner.engines.registry import engine_named
from planner.explanation.diagnosis import why_unsolvable
from robots.world import WorldFile
from tests.app.laboratory import lab_with

BASE = load_knowledge_base()
GOAL = Fact("object_position", ("rock_sample", "in", "lander"))
FRED: dict[str, Any] = {"name": "fred", "compartment": "lab", "start": [1.4, 5.6, 0], "home": "home_fred"}
GINGER: dict[str, Any] = {
    "name": "ginger",
    "compartment": "lab",
    "start": [1.4, 1.4, 0],
    "home": "home_ginger",
}
BASIL: dict[str, Any] = {"name": "basil", "compartment": "lab", "start": [1.4, 3.5, 0]}
AVATAR = {"body": "avatar"}


def planned(world: WorldFile, *goals: Fact) -> PlanningResult:
    problem = planning_problem(world, initial_facts(world, BASE), goals, knowledge_base=BASE)
    return engine_named("macta", BASE).plan(problem, PlanningRequest(time_limit_s=30, effort_s=0.0))


@pytest.mark.parametrize(
    "robots", [(FRED | AVATAR, GINGER), (FRED, GINGER | AVATAR), (FRED | AVATAR, GINGER | AVATAR)]
)
def test_an_avatar_carries_no_real_long_object_whichever_part_it_would_take(
    robots: tuple[dict[str, Any], ...],
) -> None:
    world = lab_with(robots=robots)
    assert planned(world, GOAL).status is PlanningStatus.UNSOLVABLE
    problem = planning_problem(world, initial_facts(world, BASE), [GOAL], knowledge_base=BASE)
    why = why_unsolvable(BASE, problem)
    assert "is no avatar: it bears real objects" in why or "robot is no avatar" in why, why


def test_solid_robots_are_recruited_beside_an_avatar() -> None:
    plan_net = planned(lab_with(robots=[FRED | AVATAR, GINGER, BASIL]), GOAL).plan_net
    assert plan_net is not None
    carriers = {name for name in ("fred", "ginger", "basil") if len(plan_net.of_robot(name)) > 1}
    assert carriers == {"ginger", "basil"}


def test_an_avatar_still_drives_and_carries_what_takes_one_robot() -> None:
    world = lab_with(robots=[FRED | AVATAR, GINGER], samples=[{"name": "pebble", "at": "quarry"}])
    plan_net = planned(world, Fact("object_position", ("pebble", "in", "lander"))).plan_net
    assert plan_net is not None


def test_all_bodies_are_solid_but_avatars() -> None:
    facts = initial_facts(lab_with(robots=[FRED | AVATAR, GINGER | {"body": "wheeled"}, BASIL]), BASE)
    assert {fact.args[0] for fact in facts if fact.predicate == "solid"} == {"ginger", "basil"}
