"""Kill -9 anywhere: nothing is lost, nothing is done twice, and the record says what is true."""

from pathlib import Path

from app.cli.truth import holds
from robots.wire import SymbolicFact
from robots.world import load_world
from tests.scenarios.storm import WORLD, Storm

GOALS = {
    "one": "move sample_1 to bay_7",
    "two": "move sample_2 to bay_3",
    "three": "move sample_4 to door_2",
}


def judge(storm: Storm) -> None:
    """What must hold after any storm."""
    assert len(storm.accepted) == len(storm.goals)
    truth, world = storm.truth(), load_world(WORLD)
    for goal in storm.final:
        assert goal["state"] == "finished", goal
        assert goal["outcome"], goal
        facts = [SymbolicFact.model_validate(fact) for fact in goal["goal"]]
        if goal["outcome"] == "completed":
            assert all(holds(fact, world, truth) for fact in facts), (goal, truth.samples)
    twice = {event: count for event, count in storm.executed().items() if count > 1}
    assert not twice, "these were executed or ended more than once"
    assert storm.clock_s == sorted(storm.clock_s)
    assert all(len(instants) == 1 for instants in storm.deadlines.values()), storm.deadlines
    assert not [line for said in storm.complaints for line in said.splitlines() if "afresh" in line]


def test_a_storm_of_kills_loses_nothing_and_does_nothing_twice(tmp_path: Path) -> None:
    storm = Storm(data=tmp_path / "data", goals=GOALS, seed=5, kills=4)
    storm.rage()
    judge(storm)
    assert [goal["outcome"] for goal in storm.final] == ["completed"] * len(GOALS), storm.final
