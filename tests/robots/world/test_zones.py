"""Zones of a world file: their rules, and the areas of earlier versions."""

from json import dumps
from pathlib import Path

import pytest

from robots.world import WorldFile, ZoneRule
from tests.robots.world.test_file import refusal, small

AREA = {"name": "spill", "x": [0, 2], "y": [0, 2]}


def test_a_zone_is_only_a_name_unless_it_has_a_rule() -> None:
    world = WorldFile.model_validate(small(zones=[AREA]))
    assert [zone.rule for zone in world.zones] == [ZoneRule.NAMED]
    assert world.kept_out == {}


def test_places_in_zones_to_keep_out_of_are_known() -> None:
    world = WorldFile.model_validate(small(zones=[AREA | {"rule": "keep_out"}]))
    assert world.kept_out == {"bay_1": "spill"}


def test_areas_to_keep_out_of_as_earlier_versions_wrote_them_are_zones() -> None:
    before = small(keep_out=[AREA])
    world = WorldFile.model_validate(before)
    assert world == WorldFile.model_validate(small(zones=[AREA | {"rule": "keep_out"}]))
    assert world.zones_of(ZoneRule.KEEP_OUT) == world.zones
    assert WorldFile.model_validate_json(dumps(before)) == world  # as a snapshot has it
    assert "keep_out" in before  # what was given is left as it is


@pytest.mark.parametrize(
    ("zone", "words"),
    [
        ({"rule": "fast"}, "zones.0.rule"),
        ({"rule": "slow"}, "zones.0: spill: max_speed_m_s is of zones with the rule slow, and only of those"),
        ({"rule": "keep_out", "max_speed_m_s": 0.2}, "max_speed_m_s is of zones with the rule slow"),
        ({"rule": "slow", "max_speed_m_s": 0.01}, "zones.0.max_speed_m_s"),
        ({"x": [-1e308, 1e308]}, "zones.spill reaches farther than 100000 m"),
        ({"x": [50, 51]}, "zones.spill lies in no compartment"),
        ({"name": "bay_1"}, "names must be unique in a world"),
        ({"x": [2, 2]}, "x: 2 must be greater than 2"),
    ],
)
def test_what_is_no_zone_is_refused(tmp_path: Path, zone: dict[str, object], words: str) -> None:
    assert words in refusal(tmp_path, zones=[{**AREA, **zone}])


def test_areas_of_earlier_versions_are_checked_as_zones_are(tmp_path: Path) -> None:
    assert "keep_out" in refusal(tmp_path, keep_out="spill")
    assert "zones.0.x" in refusal(tmp_path, keep_out=[{**AREA, "x": "wide"}])
