"""Robots of the sample store carry out scripts by sensing alone, in the simulated world (MACTA §5, fig. 6).

The scripts are written by hand here, as the mission organiser would; what counts is the world itself.
`python -m benchmarks.sample_store --seeds 20` carries out the main job and tours from every seed, and serves every bay.
"""

import pytest

from benchmarks.errands import carry_out, packet, to_retrieve, to_store, tour, with_sample
from benchmarks.sample_store import all_tour
from robots.wire import BehaviourScript, ScriptState
from robots.world import WorldFile, load_world
from sim.trials.script_runner import ScriptRunner


def store_with(*moved: tuple[str, str, str]) -> WorldFile:
    """The sample store with samples at places, and other places vacant: (sample, at, vacant)."""
    world = load_world("sample_store")
    for sample, at, vacant in moved:
        world = with_sample(world, sample, at, vacant=vacant)
    return world


@pytest.mark.parametrize("seed", range(2))
def test_the_main_job_succeeds_from_any_start(seed: int) -> None:
    errand = to_store("sample_1", "door_1", "bay_7", "yard_1")
    result = carry_out(load_world("sample_store"), errand, seed=seed)
    assert result.succeeded, result.words


@pytest.mark.parametrize("number", [1, 6])
def test_samples_are_stored_in_bays_of_both_aisles_at_once(number: int) -> None:
    west, east = f"bay_{number}", f"bay_{number + 6}"
    world = store_with(("sample_1", "door_1", west), ("sample_4", "door_2", east))
    errands = [to_store("sample_1", "door_1", west, "yard_1"), to_store("sample_4", "door_2", east, "yard_2")]
    result = carry_out(world, *errands, seed=number)
    assert result.succeeded, result.words


@pytest.mark.parametrize("number", [1, 6])
def test_samples_are_retrieved_from_bays_of_both_aisles_at_once(number: int) -> None:
    west, east = f"bay_{number}", f"bay_{number + 6}"
    world = store_with(("sample_1", west, "door_1"), ("sample_4", east, "door_2"))
    # each yard robot serves the far aisle: their ways cross
    errands = [
        to_retrieve("sample_1", west, "door_2", "yard_2"),
        to_retrieve("sample_4", east, "door_1", "yard_1"),
    ]
    result = carry_out(world, *errands, seed=100 + number)
    assert result.succeeded, result.words


@pytest.mark.parametrize("seed", range(2))
def test_rovers_that_meet_in_the_yard_pass_each_other(seed: int) -> None:
    result = all_tour(seed)
    assert result.succeeded, result.words


def test_the_same_seed_gives_the_same_errand_to_the_last_bit() -> None:
    assert history_of_poses(seed=3) == history_of_poses(seed=3)


def history_of_poses(*, seed: int, seconds: float = 15.0) -> list[str]:
    """All poses at each tick of the main job's first seconds."""
    runner = ScriptRunner(load_world("sample_store"), seed=seed)
    runner.send(to_store("sample_1", "door_1", "bay_7", "yard_1").scripts())
    poses = []
    for _ in range(round(seconds * 60)):
        runner.simulation.step()
        poses.append(repr(runner.simulation.truth()))
    runner.simulation.close()
    return poses


def test_a_robot_keeps_watch_of_another_that_drives() -> None:
    runner = ScriptRunner(load_world("sample_store"), seed=1)
    watch = packet(1, "TRACK", robot1="yard_1", robot2="yard_2")
    watcher = BehaviourScript(id="watch", mission_id="watch", robot="yard_1", packets=(watch,))
    assert runner.run([watcher, tour("yard_2", ["door_2", "interchange_2"])], timeout_s=60)
    words = [f"{report.script_id}: {report.state} {report.detail}" for report in runner.ended.values()]
    runner.simulation.close()
    assert {report.state for report in runner.ended.values()} == {ScriptState.FINISHED}, words
