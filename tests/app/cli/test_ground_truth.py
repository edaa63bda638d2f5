"""What the command line takes to be true in the simulated world."""

import pytest

from app.cli.ground_truth import holds
from robots.physical.body import Pose
from sim import Truth
from sim.truth import SampleTruth
from tests.app.berthed_store import berthed_store
from tests.app.sample_store import said

TRUTH = Truth(
    time_s=0.0,
    robots={"yard_1": Pose(x_m=2.0, y_m=1.2, heading_rad=0.0)},
    samples={
        "sample_1": SampleTruth(x_m=0.0, y_m=0.0, place="bay_7_2"),
        "sample_2": SampleTruth(x_m=0.0, y_m=0.0, place=None, holders=("yard_1",)),
        "sample_3": SampleTruth(x_m=0.0, y_m=0.0, place=None),
    },
)
WORLD = berthed_store()


@pytest.mark.parametrize(
    "fact",
    ["in(sample_1, bay_7)", "in(sample_1, bay_7_2)", "in(sample_2, yard_1)", "near(yard_1, door_1)"],
)
def test_what_is_so_holds(fact: str) -> None:
    assert holds(said(fact), WORLD, TRUTH)


@pytest.mark.parametrize(
    "fact",
    [
        "in(sample_1, bay_7_1)",
        "in(sample_1, bay_8)",
        "in(sample_3, bay_7)",
        "in(sample_9, bay_7)",
        "near(yard_1, door_2)",
        "near(sample_1, bay_7)",
        "tracked(yard_1, yard_2)",
        "empty(yard_1)",
    ],
)
def test_what_is_false_or_not_stated_does_not_hold(fact: str) -> None:
    assert not holds(said(fact), WORLD, TRUTH)
