"""The behaviours library and its index."""

from pathlib import Path

import pytest
import yaml

from app.domain.mission_organiser import LibraryError, load_library
from app.domain.mission_organiser.behaviours_library import Template, matches
from planner import Fact, load_knowledge_base
from robots.world import PERIPHERAL_TAGS
from robots.world.parts import PHASE_TAGS, STORE_TAGS

BASE = load_knowledge_base()
ENTRY = {
    "tag": "GRAB",
    "agent": "?robot",
    "requires": ["vacant(?ref)"],
    "achieves": ["tracked(?robot, ?other)"],
}


def written(folder: Path, **changes: object) -> Path:
    path = folder / "library.yaml"
    path.write_text(yaml.safe_dump({"packets": [{**ENTRY, **changes}]}))
    return path


def test_the_library_has_an_entry_for_every_action_of_the_knowledge_base_and_every_packet() -> None:
    tags = {entry.tag for entry in load_library(BASE).entries}
    assert tags == {*STORE_TAGS, *PHASE_TAGS, *PERIPHERAL_TAGS, "RECHARGE"}
    own = {"CARRY", "CHARGE"}  # robots do these by their TRANSPORT and RECHARGE
    assert tags - {*PHASE_TAGS, "RECHARGE"} == set(BASE.actions) - own


def test_packets_are_found_by_all_the_goals_they_achieve() -> None:
    library = load_library(BASE)
    empty = Fact("robot_attribute", ("yard_1", "gripper", "empty"))
    lies = Fact("object_position", ("sample_1", "in", "bay_1"))
    assert {entry.tag for entry in library.achieving([empty])} == {"DOCK", "DOCK2", "RELEASE1", "RELEASE2"}
    assert {entry.tag for entry in library.achieving([empty, lies])} == {"DOCK", "DOCK2", "RELEASE2"}
    assert library.achieving([Fact("clear", ("bay_1", "aisle_1"))]) == ()
    assert library.achieving([]) == ()


def test_a_library_of_ones_own_is_read(tmp_path: Path) -> None:
    assert [entry.tag for entry in load_library(BASE, written(tmp_path)).entries] == ["GRAB"]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"achieves": ["flown(?robot)"]},
            r"packets.0.achieves.0: GRAB: .*unknown predicate 'flown'; choices: .*tracked",
        ),
        ({"achieves": ["tracked(?robot)"]}, r"tracked takes \(robot1, robot2\)"),
        ({"requires": ["robot_attribute(?robot, gripper, ajar)"]}, "unknown name 'ajar'; choices: .*empty"),
        ({"requires": ["vacant ?ref"]}, "not of the form"),
        ({"requires": ["vacant(?ref!)"]}, "neither a name nor a"),
        ({"agent": "?someone"}, r"line \d+, packets.0.agent: GRAB: \?someone is in none"),
        ({"achieves": []}, "packets.0.achieves"),
        ({"colour": "red"}, "packets.0.colour"),
    ],
)
def test_what_does_not_fit_is_named_with_its_slot(
    tmp_path: Path, changes: dict[str, object], says: str
) -> None:
    with pytest.raises(LibraryError, match=says):
        load_library(BASE, written(tmp_path, **changes))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(LibraryError, match=r"nowhere\.yaml cannot be read"):
        load_library(BASE, tmp_path / "nowhere.yaml")


def test_each_template_takes_a_fact_of_its_own() -> None:
    templates = [Template.parse("object_position(?o, in, ?a)"), Template.parse("object_position(?o, in, ?b)")]
    one, other = (Fact("object_position", ("rock", "in", robot)) for robot in ("fred", "ginger"))
    assert list(matches(templates, [one], {})) == []
    assert {(found["?a"], found["?b"]) for found in matches(templates, [one, other], {})} == {
        ("fred", "ginger"),
        ("ginger", "fred"),
    }


def test_a_variable_stands_for_one_name_throughout() -> None:
    template = Template.parse("tracked(?robot, ?robot)")
    assert template.matched(Fact("tracked", ("fred", "ginger")), {}) is None
    assert template.matched(Fact("tracked", ("fred", "fred")), {}) == {"?robot": "fred"}
    assert template.matched(Fact("tracked", ("fred", "fred")), {"?robot": "ginger"}) is None
