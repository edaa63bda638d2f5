"""The interference experiment (P-SMPA §6) on the real behavioural agent."""

import xml.etree.ElementTree as ET

import pytest

from robots.physical.profile import Architecture
from sim.trials.interference.corridor import ROBOT, SONAR_MIN_M, corridor
from sim.trials.interference.interferer import GAP_M, THRESHOLD_M, Kind
from sim.trials.interference.plots import figure
from sim.trials.interference.table import run_table
from sim.trials.interference.trial import Trial, run_trial

PARALLEL, SEQUENTIAL = Architecture.PARALLEL, Architecture.SEQUENTIAL


@pytest.fixture(scope="module")
def trials() -> dict[tuple[Kind, Architecture], Trial]:
    return {
        (kind, architecture): run_trial(kind, 4, architecture, seed=1)
        for kind in Kind
        for architecture in Architecture
    }


@pytest.mark.parametrize("kind", Kind)
def test_a_robot_that_senses_beside_acting_notices_every_obstacle_and_arrives(
    trials: dict[tuple[Kind, Architecture], Trial], kind: Kind
) -> None:
    trial = trials[kind, PARALLEL]
    assert trial.arrived
    assert (trial.detected, len(trial.interferences)) == (4, 4)


@pytest.mark.parametrize("kind", Kind)
def test_sensing_and_acting_in_turn_takes_longer(
    trials: dict[tuple[Kind, Architecture], Trial], kind: Kind
) -> None:
    assert trials[kind, SEQUENTIAL].arrived
    assert trials[kind, PARALLEL].time_s < trials[kind, SEQUENTIAL].time_s


def test_sequential_sensors_are_off_most_of_the_time_and_parallel_ones_hardly_ever(
    trials: dict[tuple[Kind, Architecture], Trial],
) -> None:
    def share_off(trial: Trial) -> float:
        return sum(instant.bumper == 0 for instant in trial.trace) / len(trial.trace)

    assert share_off(trials[Kind.BALL, PARALLEL]) < 0.05
    assert share_off(trials[Kind.BALL, SEQUENTIAL]) > 0.5
    used = [trials[Kind.BALL, each].sensing_j for each in (PARALLEL, SEQUENTIAL)]
    assert used[0] > used[1] > 0


def test_what_the_sonar_says_is_within_its_range_and_zero_while_it_is_off(
    trials: dict[tuple[Kind, Architecture], Trial],
) -> None:
    told = {instant.sonar_m for instant in trials[Kind.BOX, SEQUENTIAL].trace}
    assert 0.0 in told
    assert all(SONAR_MIN_M <= value <= 2.55 for value in told - {0.0})


def test_obstacles_are_put_within_the_threshold_and_before_a_robot_that_can_still_stop() -> None:
    spec = corridor(PARALLEL).robot(ROBOT)
    way_to_stop_m = spec.speed_m_s**2 / 2 + 0.1 * spec.speed_m_s
    assert way_to_stop_m < GAP_M[0] < GAP_M[1] < THRESHOLD_M


def test_an_obstacle_that_is_not_seen_is_run_into(trials: dict[tuple[Kind, Architecture], Trial]) -> None:
    """What counts as missed is missed: no box that was not detected was avoided by chance."""
    boxes = [one for (kind, _), trial in trials.items() if kind is Kind.BOX for one in trial.interferences]
    assert all(one.detected or one.touched for one in boxes)


def test_the_same_seed_gives_the_same_trial_to_the_last_bit(
    trials: dict[tuple[Kind, Architecture], Trial],
) -> None:
    assert run_trial(Kind.BOX, 4, SEQUENTIAL, seed=1) == trials[Kind.BOX, SEQUENTIAL]


def test_another_seed_puts_the_obstacles_elsewhere(trials: dict[tuple[Kind, Architecture], Trial]) -> None:
    other = run_trial(Kind.BALL, 4, PARALLEL, seed=2)
    since = [one.since_s for one in other.interferences]
    assert since != [one.since_s for one in trials[Kind.BALL, PARALLEL].interferences]


def test_a_figure_is_a_picture_with_a_band_an_interference(
    trials: dict[tuple[Kind, Architecture], Trial],
) -> None:
    for kind in Kind:
        text = figure(kind, {each: trials[kind, each] for each in Architecture})
        drawing = ET.fromstring(text)
        tags = [element.tag.rpartition("}")[2] for element in drawing.iter()]
        assert tags.count("polyline") == 2
        assert tags.count("rect") == 1 + 2 * 4


def test_the_table_has_the_same_figures_however_many_workers() -> None:
    conditions = [(Kind.BALL, 1)]
    one, two = (run_table(1, workers=workers, conditions=conditions) for workers in (1, 2))
    assert one == two
    assert one.rows[0].parallel.performance.mean == 1.0
    assert one.rows[0].parallel.detected.mean == 1.0
