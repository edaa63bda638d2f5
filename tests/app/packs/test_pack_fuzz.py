"""Whatever a pack's files hold, checking them ends with faults that name a file, or with none: never with a crash."""

import tempfile
from pathlib import Path
from typing import Any

import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.packs.check import faults_of
from app.packs.errors import PackError
from app.packs.find import load_packs
from tests.app.packs.pack_folders import example

FILES = (
    "pack.yaml",
    "knowledge_base.yaml",
    "behaviours_library.yaml",
    "verbs.yaml",
    "repertoire/observe.yaml",
    "repertoire/facts.yaml",
    "worlds/looks_yard.yaml",
)
WORDS = st.sampled_from(
    [
        "",
        "$ref",
        "?robot",
        "OBSERVE",
        "robot",
        "observed(ref)",
        "{robot",
        "a: b",
        "1e999",
        "near",
        "patterns_of",
    ]
)
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | WORDS
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(SCALARS, inner, max_size=3),
    max_leaves=6,
)


FACTS = "sensed_facts:\n  - {fact: observed($ref), by: {sense: in_view, target: $ref}}\n"


def pack(parent: Path) -> Path:
    folder = example(parent)
    (folder / "repertoire" / "facts.yaml").write_text(FACTS)
    return folder


def nodes(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The place of every part of the data."""
    places = [path]
    if isinstance(data, dict):
        for key, value in data.items():
            places += nodes(value, (*path, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            places += nodes(value, (*path, index))
    return places


def changed(data: Any, path: tuple[Any, ...], value: Any, how: str) -> Any:
    """The data with the part at a place replaced, removed, or given a further entry."""
    if not path:
        if how == "add" and isinstance(data, list):
            return [*data, value]
        return {**data, str(value)[:8]: value} if how == "add" and isinstance(data, dict) else value
    inner = changed(data[path[0]], path[1:], value, how)
    if isinstance(data, dict):
        kept = {key: one for key, one in data.items() if key != path[0]}
        return kept if how == "remove" and len(path) == 1 else {**kept, path[0]: inner}
    rest = [one if index != path[0] else inner for index, one in enumerate(data)]
    return (
        [one for index, one in enumerate(rest) if index != path[0]]
        if how == "remove" and len(path) == 1
        else rest
    )


def judged(folder: Path) -> list[str]:
    try:
        return list(faults_of(load_packs([str(folder)])))
    except PackError as error:
        return [error.detail]


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_a_pack_with_any_change_is_valid_or_its_faults_name_a_file(data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = pack(Path(name))
        file = folder / data.draw(st.sampled_from(FILES))
        document = yaml.safe_load(file.read_text())
        for _ in range(data.draw(st.integers(1, 3))):
            place = data.draw(st.sampled_from(nodes(document)))
            how = data.draw(st.sampled_from(["replace", "remove", "add"]))
            document = changed(document, place, data.draw(VALUES), how)
        file.write_text(yaml.safe_dump(document))
        assert all(str(folder) in fault for fault in judged(folder)), judged(folder)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(FILES), st.binary(max_size=40), st.integers(0, 2000))
def test_a_pack_with_any_bytes_is_valid_or_its_faults_name_a_file(
    name: str, noise: bytes, position: int
) -> None:
    with tempfile.TemporaryDirectory() as parent:
        folder = pack(Path(parent))
        content = (folder / name).read_bytes()
        at = position % len(content)
        (folder / name).write_bytes(content[:at] + noise + content[at + len(noise) :])
        assert all(str(folder) in fault for fault in judged(folder)), judged(folder)
