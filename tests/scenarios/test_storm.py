"""Kill -9 anywhere: nothing is lost, nothing is done twice, and the record says what is true."""

from pathlib import Path

import pytest

from tests.scenarios.judge import judge
from tests.scenarios.storm import Storm
from tests.scenarios.witness import Witness

GOALS = {
    "one": "move sample_1 to bay_7",
    "two": "move sample_2 to bay_3",
    "three": "move sample_4 to door_2",
}


def weather(storm: Storm) -> None:
    """The storm, and what must hold after it."""
    storm.rage()
    judge(storm.seen, data=storm.data, database_url=storm.database_url)
    assert not [line for said in storm.complaints for line in said.splitlines() if "afresh" in line]


@pytest.mark.timeout(900)
def test_a_storm_of_kills_loses_nothing_and_does_nothing_twice(tmp_path: Path) -> None:
    storm = Storm(data=tmp_path / "data", seen=Witness(GOALS), seed=5, kills=4)
    weather(storm)
    assert [goal["outcome"] for goal in storm.seen.final] == ["completed"] * len(GOALS), storm.seen.final
