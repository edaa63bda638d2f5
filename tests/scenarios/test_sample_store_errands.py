"""Robots of the sample store carry out scripts by sensing alone, in the simulated world (MACTA §5, fig. 6).

The scripts are written by hand here, as the mission organiser would; what counts is the world itself.
"""

import pytest

from benchmarks.errands import carry_out, to_retrieve, to_store, with_sample
from benchmarks.sample_store import all_tour
from robots.world import WorldFile, load_world


def store_with(*moved: tuple[str, str, str]) -> WorldFile:
    """The sample store with samples at places, and other places vacant: (sample, at, vacant)."""
    world = load_world("sample_store")
    for sample, at, vacant in moved:
        world = with_sample(world, sample, at, vacant=vacant)
    return world


@pytest.mark.parametrize("seed", range(20))
def test_the_main_job_succeeds_from_every_start(seed: int) -> None:
    errand = to_store("sample_1", "door_1", "bay_7", "yard_1")
    result = carry_out(load_world("sample_store"), errand, seed=seed)
    assert result.succeeded, result.words


@pytest.mark.parametrize("number", range(1, 7))
def test_samples_are_stored_in_a_bay_of_either_aisle_at_once(number: int) -> None:
    west, east = f"bay_{number}", f"bay_{number + 6}"
    world = store_with(("sample_1", "door_1", west), ("sample_4", "door_2", east))
    errands = [to_store("sample_1", "door_1", west, "yard_1"), to_store("sample_4", "door_2", east, "yard_2")]
    result = carry_out(world, *errands, seed=number)
    assert result.succeeded, result.words


@pytest.mark.parametrize("number", range(1, 7))
def test_samples_are_retrieved_from_a_bay_of_either_aisle_at_once(number: int) -> None:
    west, east = f"bay_{number}", f"bay_{number + 6}"
    world = store_with(("sample_1", west, "door_1"), ("sample_4", east, "door_2"))
    # each yard robot serves the far aisle: their ways cross
    errands = [
        to_retrieve("sample_1", west, "door_2", "yard_2"),
        to_retrieve("sample_4", east, "door_1", "yard_1"),
    ]
    result = carry_out(world, *errands, seed=100 + number)
    assert result.succeeded, result.words


@pytest.mark.parametrize("seed", range(3))
def test_rovers_that_meet_in_the_yard_pass_each_other(seed: int) -> None:
    result = all_tour(seed)
    assert result.succeeded, result.words
