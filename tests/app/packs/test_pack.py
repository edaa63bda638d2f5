"""A pack's folder: its manifest and the files that it may hold."""

from pathlib import Path

import pytest

from app.packs.errors import PackError
from app.packs.pack import read_pack
from app.packs.pack_set import difference
from tests.app.packs.pack_folders import bare, change, example


def test_a_packs_files_are_found_by_their_names(tmp_path: Path) -> None:
    folder = example(tmp_path)
    pack = read_pack(folder)
    assert (pack.name, pack.version, pack.needs) == ("looks", "0.1", {"store": "1.0"})
    assert pack.knowledge_bases == (folder / "knowledge_base.yaml",)
    assert pack.libraries == (folder / "behaviours_library.yaml",)
    assert pack.packets == (folder / "repertoire" / "observe.yaml",)
    assert pack.worlds == {"looks_yard": folder / "worlds" / "looks_yard.yaml"}
    assert pack.verbs == (folder / "verbs.yaml",)


def test_a_pack_may_have_any_of_them(tmp_path: Path) -> None:
    pack = read_pack(bare(tmp_path, "empty"))
    assert (pack.knowledge_bases, pack.packets, pack.verbs, pack.worlds) == ((), (), (), {})


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("name: looks", "name: Looks!", ["line 2, name"]),
        ('version: "0.1"', "version: new", ["line 3, version"]),
        ("needs: {store", "needs: {Store", ["needs"]),
        ("about: Robots", "abuot: Robots", ["line 4, abuot"]),
        ("name: looks", "name: [looks", ["cannot be read"]),
        ("name: looks", "", ["name: Field required"]),
    ],
)
def test_a_malformed_manifest_is_refused_with_file_and_line(
    tmp_path: Path, right: str, wrong: str, words: list[str]
) -> None:
    folder = example(tmp_path)
    change(folder / "pack.yaml", right, wrong)
    with pytest.raises(PackError) as refused:
        read_pack(folder)
    said = refused.value.detail
    assert [word for word in (*words, str(folder / "pack.yaml")) if word not in said] == [], said


def test_a_version_may_be_a_number(tmp_path: Path) -> None:
    folder = example(tmp_path)
    change(folder / "pack.yaml", 'version: "0.1"', "version: 0.1")
    assert read_pack(folder).version == "0.1"


def test_a_folder_without_a_manifest_is_no_pack(tmp_path: Path) -> None:
    with pytest.raises(PackError, match=r"is no domain pack: it has no pack\.yaml"):
        read_pack(tmp_path)


@pytest.mark.parametrize(
    "name", ["knowledgebase.yaml", "verbs.yml", "packets/observe.yaml", "worlds/yard.yml", "worlds.yaml"]
)
def test_a_file_that_would_not_be_read_is_refused_with_the_choices(tmp_path: Path, name: str) -> None:
    folder = example(tmp_path)
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_text("{}")
    with pytest.raises(PackError) as refused:
        read_pack(folder)
    assert str(folder / name) in refused.value.detail
    assert "knowledge_base.yaml" in refused.value.choices
    assert "repertoire/*.yaml" in refused.value.choices


@pytest.mark.parametrize(
    ("version", "least", "enough"),
    [
        ("1.0", "1", True),
        ("1", "1.0", True),
        ("1.10", "1.9", True),
        ("1.9", "1.10", False),
        ("2", "1.9.9", True),
        ("0.9", "1", False),
    ],
)
def test_versions_are_compared_by_their_numbers(
    tmp_path: Path, version: str, least: str, enough: bool
) -> None:
    assert read_pack(bare(tmp_path, "one", version)).is_at_least(least) is enough


def test_a_digest_is_of_the_files_wherever_they_lie_and_differs_with_any_of_them(tmp_path: Path) -> None:
    here = example(tmp_path / "here")
    there = example(tmp_path / "there")
    assert read_pack(here).digest() == read_pack(there).digest()
    for name in ("pack.yaml", "verbs.yaml", "repertoire/observe.yaml", "worlds/looks_yard.yaml"):
        before = read_pack(there).digest()
        file = there / name
        file.write_text(file.read_text().replace("0.1", "0.2") + "# a remark\n")
        assert read_pack(there).digest() != before, name


def test_the_packs_that_differ_are_named() -> None:
    ours = {"store": "1", "looks": "2", "survey": "3"}
    assert difference(ours, dict(ours)) == ""
    theirs = {"store": "1", "looks": "4", "photography": "5"}
    assert difference(ours, theirs) == (
        "pack looks is another, pack photography is not here, pack survey is missing"
    )
