"""Rule files that a world file names for its robots."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from robots.deliberative.rule_set import check_rule_set
from robots.repertoire import load_repertoire
from robots.world import RobotSpec, RoleSpec, WorldFile, WorldFileError, load_world, read_world
from tests.robots.world.test_file import small

GUARD = "AGENT guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));\n"


def ruled(rules: Any) -> dict[str, Any]:
    """The small world; its first robot has these rules."""
    world = small()
    world["robots"][0]["rules"] = rules
    return world


def loaded(folder: Path, rules: Any) -> WorldFile:
    (folder / "roles").mkdir(exist_ok=True)
    (folder / "roles" / "guard.rules").write_text(GUARD)
    file = folder / "room.yaml"
    file.write_text(yaml.safe_dump(ruled(rules)))
    repertoire = load_repertoire()
    return load_world(file, check_rules=lambda files: check_rule_set(files, repertoire))


def playing(folder: Path, role: Any) -> RobotSpec:
    """The first robot of the small world, in this role."""
    (folder / "roles").mkdir(exist_ok=True)
    (folder / "roles" / "guard.rules").write_text(GUARD)
    stated = ruled(["soccer_player"])
    stated["robots"][0]["role"] = role
    file = folder / "room.yaml"
    file.write_text(yaml.safe_dump(stated))
    repertoire = load_repertoire()
    world = load_world(
        file, tags=repertoire.tags, check_rules=lambda files: check_rule_set(files, repertoire)
    )
    return world.robot("left")


def test_a_path_relative_to_the_world_file_is_replaced_by_the_text(tmp_path: Path) -> None:
    world = loaded(tmp_path, ["roles/guard.rules"])
    assert world.robot("left").rules == {"guard": GUARD}
    assert world.robot("right").rules == {}
    assert WorldFile.model_validate_json(world.model_dump_json(exclude_defaults=True)) == world


@pytest.mark.parametrize(
    ("rules", "words"),
    [
        (["roles/watch.rules"], "robots.0.rules.0: roles/watch.rules: "),
        (["no_such_rules"], "robots.0.rules.0: no_such_rules: no shipped rule file; choices: "),
        (
            ["roles/guard.rules", "./roles/guard.rules"],
            "rules.1: ./roles/guard.rules: two files are called guard",
        ),
        ({"guard": GUARD + "BELIEF(on_duty) => COMMIT(dance());"}, "robots.left.rules: guard:3:"),
        ({"watch": GUARD}, "robots.left.rules: watch:1:1: the file says that it is guard"),
    ],
)
def test_what_cannot_be_used_is_refused_with_its_place(tmp_path: Path, rules: Any, words: str) -> None:
    with pytest.raises(WorldFileError) as refused:
        loaded(tmp_path, rules)
    assert words in str(refused.value)


def test_a_world_that_is_no_file_has_no_paths(tmp_path: Path) -> None:
    (tmp_path / "guard.rules").write_text(GUARD)
    with pytest.raises(WorldFileError, match=r"rules.0: .*guard.rules: a path, which only the file"):
        read_world(yaml.safe_dump(ruled([str(tmp_path / "guard.rules")])), "the request")


@pytest.mark.parametrize(
    ("role", "words"),
    [
        ({"name": "watch", "rules": "roles/no.rules"}, "robots.0.role.rules: roles/no.rules: "),
        (
            {"name": "watch", "rules": "roles/guard.rules"},
            "robots.left.rules: watch:1:1: the file says that it is guard",
        ),
        ({"name": "watch", "tags": ["FLY"]}, "left has no packet 'FLY'; its packets: "),
    ],
)
def test_a_role_that_cannot_be_played_is_refused_with_its_place(
    tmp_path: Path, role: dict[str, Any], words: str
) -> None:
    with pytest.raises(WorldFileError) as refused:
        playing(tmp_path, role)
    assert words in str(refused.value)


def test_a_role_has_a_name_alone_or_with_a_file_and_tags(tmp_path: Path) -> None:
    assert playing(tmp_path, "guard").role == RoleSpec(name="guard")
    world = playing(tmp_path, {"name": "left_defender", "rules": "left_defender", "tags": ["NAVIGATE"]})
    assert world.role is not None
    assert world.role.tags == ("NAVIGATE",)
    assert world.rule_files["left_defender"].count("ROLE left_defender;")
