"""What a robot may say of itself."""

from typing import Any

import pytest
from pydantic import ValidationError

from robots.wire import Factsheet

DOOR = {"repertoire": ("OPEN", "CLOSE"), "peripheral": {"kind": "door"}}
ROBOT = {"repertoire": ("NAVIGATE",), "speed_m_s": 0.3, "turn_rad_s": 1.0}


def test_only_a_robot_has_speeds() -> None:
    door = Factsheet(**DOOR)
    assert (door.speed_m_s, door.turn_rad_s) == (0.0, 0.0)
    with pytest.raises(ValidationError, match="has speed_m_s and turn_rad_s, both greater than 0"):
        Factsheet(repertoire=("NAVIGATE",))


@pytest.mark.parametrize("said", [DOOR, ROBOT])
@pytest.mark.parametrize("values", [{"speed_m_s": -0.1}, {"turn_rad_s": -0.1}, {"number": -1}])
def test_no_figure_is_negative(said: dict[str, Any], values: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match="greater than or equal to 0"):
        Factsheet(**(said | values))
