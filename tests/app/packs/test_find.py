"""Which packs are loaded: those named and those that they need, in that order."""

from pathlib import Path

import pytest

from app.packs import STORE, chosen_packs
from app.packs.errors import PackError
from app.packs.find import installed_names, load_packs
from app.packs.pack_set import Packs
from app.settings import Settings
from robots.world import PERIPHERAL_TAGS
from robots.world.parts import PHASE_TAGS, STORE_TAGS
from tests.app.packs.pack_folders import bare, change, example
from tests.packages import installed, write_package

ENTRY = "[macta.packs]\nlooks = looks_pack\n"


def names(packs: Packs) -> list[str]:
    return [pack.name for pack in packs.packs]


def refusal(*wanted: Path | str) -> str:
    with pytest.raises(PackError) as refused:
        load_packs([str(one) for one in wanted])
    return f"{refused.value.detail}; {', '.join(refused.value.choices)}"


def package(folder: Path, entry: str = ENTRY) -> Path:
    """An installed package that brings the pack `looks`."""
    pack = example(folder / "source")
    files = {f"looks_pack/{file.relative_to(pack)}": file.read_text() for file in pack.rglob("*.yaml")}
    code = "raise RuntimeError('the code of a pack is not run to find its files')"
    return write_package(folder / "site", "macta_looks", entry, {**files, "looks_pack/__init__.py": code})


def test_what_ships_is_a_pack() -> None:
    packs = load_packs(["store"])
    assert names(packs) == ["store"]
    of_peripherals = {*PERIPHERAL_TAGS}
    whole = {*packs.repertoire().tags} - {*PHASE_TAGS}
    assert set(packs.knowledge_base().actions) - {"CARRY", "CHARGE"} == whole | of_peripherals
    assert set(packs.worlds()) == {
        "busy_store",
        "sample_store",
        "sample_store_radio",
        "relocation_lab",
        "guarded_store",
        "soccer",
        "waltz",
    }


def test_a_pack_comes_after_those_that_it_needs(tmp_path: Path) -> None:
    last = bare(tmp_path, "last", middle="1.0")
    middle = bare(tmp_path, "middle", first="1.0", store="1.0")
    first = bare(tmp_path, "first")
    assert names(load_packs([str(last), str(middle), str(first)])) == ["first", "store", "middle", "last"]


def test_a_missing_pack_is_refused_with_the_choices(tmp_path: Path) -> None:
    assert "no domain pack or folder 'looks'; store" in refusal("looks")


def test_a_needed_pack_that_is_missing_is_refused_naming_who_needs_it(tmp_path: Path) -> None:
    folder = bare(tmp_path, "one", other="1.0")
    said = refusal(folder)
    assert f"pack one ({folder}) needs the pack other, which is not installed" in said
    assert said.endswith("; store, survey")


def test_an_older_pack_than_needed_is_refused(tmp_path: Path) -> None:
    assert "needs store 99.0 or later; ships with Macta is 1.0" in refusal(
        bare(tmp_path, "one", store="99.0")
    )


def test_packs_that_need_each_other_are_refused(tmp_path: Path) -> None:
    one = bare(tmp_path, "one", two="1.0")
    two = bare(tmp_path, "two", one="1.0")
    assert "needs itself: one needs two needs one" in refusal(one, two)


def test_two_packs_of_one_name_are_refused_naming_both(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    folders = [bare(tmp_path / "a", "one"), bare(tmp_path / "b", "one")]
    said = refusal(*folders)
    assert all(str(folder) in said for folder in folders)


def test_a_pack_named_twice_is_loaded_once(tmp_path: Path) -> None:
    folder = bare(tmp_path, "one")
    assert names(load_packs([str(folder), str(folder)])) == ["one"]


def test_an_installed_pack_is_found_by_its_name_without_running_its_code(tmp_path: Path) -> None:
    with installed(package(tmp_path)):
        assert installed_names() == ("store", "survey", "looks")
        packs = load_packs(["looks"])
    assert names(packs) == ["store", "looks"]
    assert packs.packs[1].source == "package looks_pack of macta_looks 1.2"
    assert "OBSERVE" in packs.knowledge_base().actions


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("[macta.packs]\nlooks = nowhere\n", "nowhere of macta_looks 1.2 is no package of modules"),
        ("[macta.packs]\nlooks = nowhere.deep\n", "No module named 'nowhere'"),
        ("[macta.packs]\nsees = looks_pack\n", "registers the pack looks as sees"),
    ],
)
def test_a_broken_entry_point_is_refused_naming_the_package(tmp_path: Path, entry: str, words: str) -> None:
    with installed(package(tmp_path, entry)):
        said = refusal("looks" if "looks =" in entry else "sees")
    assert words in said
    assert "macta_looks 1.2" in said


def test_worlds_of_one_name_are_refused_naming_both(tmp_path: Path) -> None:
    one = example(tmp_path, "one")
    two = example(tmp_path, "two")
    (one / "worlds" / "one_yard.yaml").rename(one / "worlds" / "two_yard.yaml")
    with pytest.raises(PackError, match="world two_yard is in two packs"):
        load_packs([str(one), str(two)]).worlds()


def test_what_two_packs_define_differently_is_refused_naming_both_files(tmp_path: Path) -> None:
    one = example(tmp_path, "one")
    two = example(tmp_path, "two")
    change(two / "knowledge_base.yaml", "duration: 6", "duration: 7")
    with pytest.raises(PackError) as refused:
        load_packs([str(one), str(two)]).knowledge_base()
    assert all(str(folder / "knowledge_base.yaml") in refused.value.detail for folder in (one, two))


def test_packs_without_a_knowledge_base_or_library_are_refused(tmp_path: Path) -> None:
    packs = load_packs([str(bare(tmp_path, "one"))])
    with pytest.raises(PackError, match="no knowledge base is in the packs one"):
        packs.knowledge_base()
    with pytest.raises(PackError, match="no behaviours library is in the packs one"):
        packs.library()


@pytest.mark.parametrize(
    ("given", "variable", "chosen"),
    [
        (None, None, ("store",)),
        (None, "", ("store",)),
        (None, "survey, ./mine", ("survey", "./mine")),
        (["looks"], "survey", ("looks",)),
    ],
)
def test_options_come_before_the_environment_and_that_before_the_store(
    monkeypatch: pytest.MonkeyPatch, given: list[str] | None, variable: str | None, chosen: tuple[str, ...]
) -> None:
    if variable is None:
        monkeypatch.delenv("MACTA_PACKS", raising=False)
    else:
        monkeypatch.setenv("MACTA_PACKS", variable)
    assert chosen_packs(given) == chosen
    if given is None:
        assert Settings().packs == chosen
    else:
        assert Settings(packs=tuple(given)).packs == chosen


def test_the_tags_are_those_of_the_repertoire(tmp_path: Path) -> None:
    packs = load_packs([str(example(tmp_path))])
    assert packs.tags() == packs.repertoire().tags
    assert load_packs([STORE]).tags() == tuple(sorted((*STORE_TAGS, *PHASE_TAGS)))


def test_a_packet_that_is_no_yaml_is_refused_naming_its_file(tmp_path: Path) -> None:
    folder = example(tmp_path)
    (folder / "repertoire" / "broken.yaml").write_text("tag: [")
    with pytest.raises(PackError, match=r"broken\.yaml"):
        load_packs([str(folder)]).tags()
