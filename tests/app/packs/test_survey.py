"""The pack `survey`: what its sentences mean, and how its missions are planned and end in the simulated world."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from app.cli.goal_input import read_goals
from app.cli.simulated_mission import simulate_mission
from app.cli.trials.offline_mission import Mission, goal_problem, plan_mission
from app.cli.trials.sweep_results import Outcome
from app.domain.world_model import initial_facts
from app.packs import SHIPPED
from app.packs.errors import PackError
from app.packs.find import load_packs
from app.packs.pack_set import Packs
from planner import PlanningRequest
from planner.engines.registry import engine_named
from robots.wire import ReadingResult
from robots.world import WorldFile, load_world
from sim.trials.script_runner import ScriptRunner
from sim.world.agents import agents_with
from tests.app.packs.pack_folders import bare


@cache
def survey() -> tuple[Packs, WorldFile]:
    packs = load_packs(["survey"])
    return packs, load_world(packs.default_world, worlds=packs.worlds(), tags=packs.tags())


@cache
def mission(sentence: str) -> Mission:
    """Planned by the hierarchical engine alone, without improvement."""
    packs, world = survey()
    base = packs.knowledge_base()
    facts = initial_facts(world, base)
    stated = read_goals(world, facts, [sentence], base, packs.verbs())
    problem = goal_problem(world, facts, stated.goals, base, stated.constraints)
    request = PlanningRequest(time_limit_s=30, effort_s=0)
    return plan_mission(world, problem, engine_named("macta", base), base, request, library=packs.library())


@pytest.mark.parametrize(
    ("sentence", "goals"),
    [
        ("inspect crater_1", ["inspected(crater_1)"]),
        ("photograph crater_2 with rover_2", ["photographed(crater_2)"]),
        ("patrol ridge_1, ridge_2 and base", ["patrolled(ridge_1)", "patrolled(ridge_2)", "patrolled(base)"]),
        ("patrol ridge_1, then ridge_2", ["patrolled(ridge_1)", "patrolled(ridge_2)"]),
        ("have rover_1 go to ridge_3", ["near(rover_1, ridge_3)"]),
        ("have rover_2 wait at site_2", ["waited_at(site_2)"]),
        ("let rover_4 inspect crater_2", ["inspected(crater_2)"]),
        ("have rover_2 follow rover_1 to ridge_1", ["followed(rover_2, rover_1, ridge_1)"]),
        ("drill at site_3", ["drilled(site_3)", "in(drill_1, rack_1)"]),
        ("follow rover_1 to ridge_1 with rover_2", ["followed(rover_2, rover_1, ridge_1)"]),
    ],
)
def test_every_verb_is_planned_by_the_hierarchical_engine(sentence: str, goals: list[str]) -> None:
    assert [str(goal) for goal in mission(sentence).goals] == goals


@pytest.mark.parametrize(
    "sentence",
    [
        "inspect crater_1 and photograph crater_2",
        "patrol ridge_2 and ridge_3",
        "have rover_2 follow rover_1 to site_1",
        "drill at site_1",
    ],
)
def test_a_mission_ends_where_its_goals_say_though_rocks_are_on_no_map(sentence: str) -> None:
    packs, _ = survey()
    ended = simulate_mission(mission(sentence), seed=1, packet_files=packs.packets)
    assert ended.came_true, (ended.reason, *ended.words)


def test_what_a_packet_claims_of_a_place_counts_only_if_its_robot_stands_there() -> None:
    packs, _ = survey()
    one = mission("have rover_2 wait at base")
    elsewhere = one.goals[0].model_copy(update={"args": ("ridge_1",)})
    claiming = [
        script.model_copy(
            update={"packets": tuple(p.model_copy(update={"achieves": (elsewhere,)}) for p in script.packets)}
        )
        for script in one.scripts
    ]
    ended = simulate_mission(
        replace(one, goals=[elsewhere], scripts=claiming), seed=0, packet_files=packs.packets
    )
    assert ended.outcome is Outcome.UNTRUE


@pytest.mark.parametrize(
    ("sentence", "tag", "because"),
    [
        ("send rover_1 to ridge_3", "CREEP_TO", ["has_body(rover_1, wheeled)", "rough(ridge_3)"]),
        ("send rover_1 to ridge_1", "GO_TO", []),
        ("send rover_2 to ridge_3", "GO_TO", []),
    ],
)
def test_the_body_and_the_place_decide_which_packet_drives_there(
    sentence: str, tag: str, because: list[str]
) -> None:
    packet = mission(sentence).scripts[0].packets[-1]
    assert (packet.tag, [str(fact) for fact in packet.because]) == (tag, because)
    assert packet.instead_of == {"GO_TO": ("CREEP_TO",), "CREEP_TO": ("GO_TO",)}[tag][: "rover_1" in sentence]


def test_who_is_to_do_it_is_the_only_robot_that_acts() -> None:
    assert mission("let rover_4 inspect crater_2").plan_net.robots == ("rover_4",)


def test_an_event_of_a_packet_stands_for_facts_about_the_packets_arguments() -> None:
    scripts = {
        script.robot: script.packets[0]
        for script in mission("have rover_2 follow rover_1 to ridge_1").scripts
    }
    assert {robot: packet.tag for robot, packet in scripts.items()} == {
        "rover_1": "LEAD",
        "rover_2": "FOLLOW",
    }
    (told,) = scripts["rover_2"].events["away"]
    assert str(told) == "lost_touch(rover_2, rover_1)"


@pytest.mark.parametrize(
    ("sentence", "tag", "because"),
    [
        ("let rover_1 inspect crater_1", "INSPECT", ["has_sensor(rover_1, camera)"]),
        ("let rover_3 inspect ridge_1", "SCAN", ["has_sensor(rover_3, scanner)"]),
        ("let rover_4 inspect ridge_1", "INSPECT", ["has_sensor(rover_4, camera)"]),
        ("let rover_4 inspect crater_1", "SCAN", ["has_sensor(rover_4, scanner)", "rough(crater_1)"]),
    ],
)
def test_the_sensors_and_the_place_decide_how_it_is_inspected(
    sentence: str, tag: str, because: list[str]
) -> None:
    packet = mission(sentence).scripts[0].packets[-1]
    assert (packet.tag, [str(fact) for fact in packet.because]) == (tag, because)


def test_only_a_robot_with_a_camera_is_recruited_to_photograph() -> None:
    _, world = survey()
    with_camera = {robot.name for robot in world.robots if "camera" in {one.kind for one in robot.sensors}}
    assert set(mission("photograph crater_2").plan_net.robots) <= with_camera


def test_a_scan_brings_what_stands_about_as_a_reading() -> None:
    packs, world = survey()
    with ScriptRunner(world, seed=0, make_agent=agents_with(packs.packets)) as runner:
        assert runner.run(mission("let rover_3 inspect crater_1").scripts, timeout_s=120)
        (reading,) = [result for report in runner.reports for result in report.results]
    assert isinstance(reading, ReadingResult)
    assert (reading.name, reading.of) == ("clutter", "crater_1")
    assert 0 <= reading.value <= 1


def test_a_way_round_a_slope_is_planned_where_it_is_quicker() -> None:
    """The straight way to crater_2 leads over slope_1, that to site_2 does not."""
    actions = {
        goal: [action.arguments["ref2"] for action in mission(f"have rover_4 go to {goal}").plan_net.actions]
        for goal in ("crater_2", "site_2")
    }
    assert actions == {"crater_2": ["site_2", "crater_2"], "site_2": ["site_2"]}


@pytest.mark.parametrize("name", SHIPPED)
def test_the_example_of_a_pack_that_ships_is_a_goal_of_its_first_world(name: str) -> None:
    packs = load_packs([name])
    world = load_world(packs.default_world, worlds=packs.worlds())
    base = packs.knowledge_base()
    assert read_goals(world, initial_facts(world, base), [packs.example], base, packs.verbs()).goals


def test_without_a_world_there_is_no_default_one(tmp_path: Path) -> None:
    packs = load_packs([str(bare(tmp_path, "words"))])
    assert packs.example == ""
    with pytest.raises(PackError, match="no world is in the packs words; give --world"):
        _ = packs.default_world
