from pathlib import Path
from typing import Any

import pytest

from robots.world import WorldFile
from robots.world.bodies import AvatarBodySpec, VelocityBodySpec, WheeledBodySpec
from tests.robots.world.test_file import refusal, small


def robot(body: Any, **slots: Any) -> dict[str, Any]:
    return {"name": "left", "compartment": "floor", "start": [3, 3, 0], "body": body, **slots}


@pytest.mark.parametrize(
    ("body", "spec"),
    [
        ("velocity", VelocityBodySpec()),
        ("wheeled", WheeledBodySpec()),
        ("avatar", AvatarBodySpec()),
        ({"kind": "wheeled", "base_m": 0.3}, WheeledBodySpec(base_m=0.3)),
    ],
)
def test_a_body_is_a_kind_or_a_kind_with_measures(body: Any, spec: Any) -> None:
    world = WorldFile.model_validate(small(robots=[robot(body)]))
    assert world.robots[0].body == spec
    assert WorldFile.model_validate(world.model_dump()) == world


@pytest.mark.parametrize(
    ("body", "slots", "said"),
    [
        (
            "flying",
            {},
            "robots.0.body: unknown kind 'flying'; choices: avatar, velocity, wheeled",
        ),
        ({"kind": "wheeled", "base_m": 2}, {}, "robots.0.body.wheeled.base_m: Input should be less than"),
        (
            {"kind": "avatar", "base_m": 0.3},
            {},
            "robots.0.body.avatar.base_m: Extra inputs are not permitted",
        ),
        (
            "wheeled",
            {"speed_m_s": 1.5},
            "left.speed_m_s is 1.5, but its wheels of 0.07 m at 14.0 rad/s reach 0.98",
        ),
        (
            "wheeled",
            {"turn_rad_s": 6},
            "left.turn_rad_s is 6.0, but its wheels, 0.36 m apart, turn it at 5.44",
        ),
    ],
    ids=["unknown", "out of bounds", "of another kind", "too slow ahead", "too slow to turn"],
)
def test_a_body_that_cannot_be_is_refused_by_name(
    tmp_path: Path, body: Any, slots: dict[str, Any], said: str
) -> None:
    assert said in refusal(tmp_path, robots=[robot(body, **slots)])
