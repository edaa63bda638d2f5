"""PATROL of the pack `survey`: from a `wall` beside the way until the `opening` the robot drives at half its pace."""

from functools import cache
from itertools import pairwise
from math import dist
from statistics import median

import pytest

from app.packs.find import load_packs
from benchmarks.trial import Trial, packet, room
from robots.repertoire import Repertoire
from robots.wire import ScriptState
from robots.world import WorldFile
from sim.clock import CONTROL_S

END = 5.5
"""Where the passage opens, metres; it begins at 2.5."""


@cache
def repertoire() -> Repertoire:
    return load_packs(["survey"]).repertoire()


def hall(*, until: float) -> WorldFile:
    """A hall 4 m wide, narrowed to 1.1 m from 2.5 m on."""
    passage = [(2.5, 0, until, 1.45), (2.5, 2.55, until, 4)] if until else []
    content = room(size=(10, 4), boxes=passage, start=(1, 2, 0)).model_dump()
    far = {"name": "far", "kind": "place", "at": (9.3, 2), "approach_deg": (180,)}
    content["locations"] = [*content["locations"], far]
    content["robots"][0]["repertoire"] = ("PATROL",)
    return WorldFile.model_validate(content)


def patrol(world: WorldFile, seed: int) -> Trial:
    patrolling = packet("PATROL", ref2="far", timeout_s=90)
    trial = Trial(world, patrolling, seed=seed, repertoire=repertoire()).run()
    assert trial.ended is not None
    assert trial.ended.state is ScriptState.FINISHED
    assert not trial.touched
    return trial


def pace(trial: Trial, west: float, east: float) -> float:
    """The median pace between two lines, metres a second."""
    return median(
        dist((one.x_m, one.y_m), (other.x_m, other.y_m)) / CONTROL_S
        for one, other in pairwise(trial.path)
        if west < one.x_m < east
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_passage_is_driven_at_half_the_pace_until_it_opens(seed: int) -> None:
    trial = patrol(hall(until=END), seed)
    assert [event for event in trial.events if event != "rocks"] == ["wall", "opening"]
    usual = pace(trial, END + 1, 8)
    assert pace(trial, 3.2, END - 0.5) == pytest.approx(usual / 2, rel=0.1)


def test_a_passage_that_does_not_open_is_driven_slowly_to_its_end() -> None:
    trial = patrol(hall(until=10), seed=0)
    assert "opening" not in trial.events
    assert pace(trial, END + 1, 8) == pytest.approx(pace(trial, 3.2, END), rel=0.1)


def test_where_nothing_stands_beside_the_way_the_pace_stays() -> None:
    trial = patrol(hall(until=0), seed=0)
    assert "wall" not in trial.events
    assert pace(trial, 3.2, END) == pytest.approx(pace(trial, END + 1, 8), rel=0.1)
