"""Robots are taken out of a world, but not the last one."""

import pytest

from app.domain.errors import Conflict
from app.domain.world_model.edits import RemoveRobot
from tests.app.sample_store import Store

STORE = Store()


def test_a_robot_is_removed_unless_it_is_the_only_one() -> None:
    without = RemoveRobot(name="yard_2").apply(STORE.world, STORE.facts).world
    assert "yard_2" not in {robot.name for robot in without.robots}
    alone = STORE.world.model_copy(update={"robots": STORE.world.robots[:1]})
    with pytest.raises(Conflict, match=r"is the only robot of sample_store") as refused:
        RemoveRobot(name=alone.robots[0].name).apply(alone, STORE.facts)
    assert refused.value.code == "last-robot"
