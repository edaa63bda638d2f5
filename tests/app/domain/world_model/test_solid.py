"""A virtual robot is never recruited to carry a real long object: its partner would carry it alone."""

from typing import Any

import pytest

from app.domain.world_model import initial_facts, planning_problem
from app.domain.world_model.edits import ChangeRobot, apply_edits
from app.domain.world_model.factsheets import difference
from planner import Fact, PlanningRequest, PlanningResult, PlanningStatus, load_knowledge_base
from planner.engines.registry import engine_named
from planner.explanation.diagnosis import why_unsolvable
from robots.wire import Factsheet
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


REAL = {"external": True}
PEBBLE = [{"name": "pebble", "at": "quarry"}]
PEBBLE_GOAL = Fact("object_position", ("pebble", "in", "lander"))


@pytest.mark.parametrize("avatar", [FRED | AVATAR, FRED | AVATAR | REAL])
def test_beside_real_robots_an_avatar_carries_nothing(avatar: dict[str, Any]) -> None:
    """Neither one that is simulated nor one with software of its own."""
    world = lab_with(robots=[avatar, GINGER | REAL], samples=PEBBLE)
    plan_net = planned(world, PEBBLE_GOAL).plan_net
    assert plan_net is not None
    assert plan_net.robots == ("ginger",)
    held = Fact("object_position", ("pebble", "in", "fred"))
    assert planned(world, held).status is PlanningStatus.UNSOLVABLE
    assert planned(world, Fact("robot_position", ("fred", "near", "quarry"))).plan_net is not None
    assert planned(lab_with(robots=[avatar, GINGER], samples=PEBBLE), held).plan_net is not None


def test_what_an_avatar_carries_follows_the_changes_of_its_world() -> None:
    world = lab_with(robots=[FRED | AVATAR, GINGER], samples=PEBBLE)
    facts = initial_facts(world, BASE)
    dock = Fact("can", ("fred", "DOCK"))
    assert dock in facts
    real = apply_edits(world, [ChangeRobot(name="ginger", external=True)], facts, BASE)
    assert dock not in real.facts
    assert Fact("can", ("ginger", "DOCK")) in real.facts
    twin = apply_edits(real.world, [ChangeRobot(name="ginger", external=False)], real.facts, BASE)
    assert twin.facts == facts


def test_a_robot_that_announces_itself_as_virtual_bears_nothing_from_then_on() -> None:
    """And bears objects again with its body."""
    world = lab_with(robots=[FRED | REAL, GINGER | REAL])
    facts = initial_facts(world, BASE)
    can = tuple(world.robot("fred").repertoire)
    speeds = {"repertoire": can, "speed_m_s": 0.5, "turn_rad_s": 1.0}
    solid = Fact("solid", ("fred",))
    bearing = {solid, Fact("can", ("fred", "DOCK")), Fact("can", ("fred", "DOCK2"))}
    assert bearing <= facts
    for body, expected in (("avatar", set()), ("velocity", bearing)):
        edit = difference(Factsheet(number=1, body=body, **speeds), world.robot("fred"))
        assert edit is not None
        edited = apply_edits(world, [edit], facts, BASE)
        world, facts = edited.world, edited.facts
        assert facts & bearing == expected


def test_all_bodies_are_solid_but_avatars() -> None:
    facts = initial_facts(lab_with(robots=[FRED | AVATAR, GINGER | {"body": "wheeled"}, BASIL]), BASE)
    assert {fact.args[0] for fact in facts if fact.predicate == "solid"} == {"ginger", "basil"}
