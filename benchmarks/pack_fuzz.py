"""Domain packs and worlds with random changes: checking one ends with faults that name a file, never with an exception.

    uv run python -m benchmarks.pack_fuzz [PACKS] [WORLDS]

Prints how many were valid, and the longest processor time of one check. The first failure ends it, reduced by
hypothesis to its smallest form.
"""

import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import yaml
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from app.domain.errors import Invalid
from app.domain.world_model import initial_facts, objects_of
from app.packs import STORE
from app.packs.check import faults_of
from app.packs.errors import PackError
from app.packs.find import load_packs
from app.packs.pack_set import Packs
from app.packs.scaffold import write_example
from planner import KnowledgeBase, KnowledgeBaseError
from robots.data import read_yaml
from robots.repertoire import Repertoire
from robots.world import WorldFileError, digest_of, load_world
from robots.world.load import shipped_worlds

NAME = "looks"
FILES = (
    "pack.yaml",
    "knowledge_base.yaml",
    "behaviours_library.yaml",
    "verbs.yaml",
    "repertoire/observe.yaml",
    "repertoire/facts.yaml",
    "worlds/looks_yard.yaml",
)
FACTS = "sensed_facts:\n  - {fact: observed($ref), by: {sense: in_view, target: $ref}}\n"
RESULTS = "results: [{image: camera, of: $ref}, {reading: ahead_m, unit: m, of: $ref}]\n"
WORLDS = ("relocation_lab", "sample_store_radio")
SENSORS = ["camera", {"kind": "scanner", "reach_m": 1.5}]
LONE_SURROGATES = ("Cs",)
"""They cannot be written to a file."""
WORDS = st.sampled_from(
    [
        "",
        "$ref",
        "?robot",
        "OBSERVE",
        "robot",
        "camera",
        "observed(ref)",
        "{robot",
        "a: b",
        "1e999",
        "near",
        "patterns_of",
    ]
)
TEXTS = st.text(st.characters(exclude_categories=LONE_SURROGATES), max_size=8)
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | TEXTS | WORDS
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(SCALARS, inner, max_size=3),
    max_leaves=6,
)
Place = tuple[Any, ...]


def write_pack(parent: Path) -> Path:
    """A valid pack with every slot that a change may hit; its folder."""
    folder = parent / NAME
    write_example(NAME, folder)
    (folder / "repertoire" / "facts.yaml").write_text(FACTS)
    with (folder / "repertoire" / "observe.yaml").open("a") as packet:
        packet.write(RESULTS)
    return folder


def places_in(data: Any, path: Place = ()) -> list[Place]:
    """The place of every part of the data."""
    places = [path]
    if isinstance(data, dict):
        for key, value in data.items():
            places += places_in(value, (*path, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            places += places_in(value, (*path, index))
    return places


def changed(data: Any, path: Place, value: Any, how: str) -> Any:
    """The data with the part at a place replaced, removed, or given a further entry."""
    if not path:
        if how == "add" and isinstance(data, list):
            return [*data, value]
        return {**data, str(value)[:8]: value} if how == "add" and isinstance(data, dict) else value
    first, *rest = path
    removes = how == "remove" and not rest
    inner = changed(data[first], tuple(rest), value, how)
    if isinstance(data, dict):
        kept = {key: one for key, one in data.items() if key != first}
        return kept if removes else {**kept, first: inner}
    return [*data[:first], *([] if removes else [inner]), *data[first + 1 :]]


def change(file: Path, data: st.DataObject) -> None:
    """Change a YAML file in up to three places."""
    document = read_yaml(file.read_text())
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.sampled_from(places_in(document)))
        how = data.draw(st.sampled_from(["replace", "remove", "add"]))
        document = changed(document, place, data.draw(VALUES), how)
    file.write_text(yaml.safe_dump(document))


def pack_faults(folder: Path) -> list[str]:
    """What is wrong with a pack; each fault must name a file of it."""
    try:
        faults = list(faults_of(load_packs([str(folder)])))
    except PackError as error:
        faults = [error.detail]
    assert all(str(folder) in fault for fault in faults), faults
    return faults


@cache
def _store() -> tuple[Packs, KnowledgeBase, Repertoire]:
    packs = load_packs([STORE])
    return packs, packs.knowledge_base(), packs.repertoire()


def world_faults(file: Path) -> list[str]:
    """What is wrong with a world file; one that is valid has facts, objects and a digest."""
    _, knowledge_base, repertoire = _store()
    try:
        world = load_world(file, worlds={}, tags=repertoire.tags, check_tuning=repertoire.tuned)
        initial_facts(world, knowledge_base)
    except WorldFileError as error:
        faults = [str(error)]
    except (KnowledgeBaseError, Invalid) as error:
        faults = [f"{file}: {error}"]
    else:
        faults = []
        assert objects_of(world)
        assert digest_of(world)
    assert all(str(file) in fault for fault in faults), faults
    return faults


def check_changed_pack(data: st.DataObject) -> list[str]:
    with tempfile.TemporaryDirectory() as name:
        folder = write_pack(Path(name))
        change(folder / data.draw(st.sampled_from(FILES)), data)
        return pack_faults(folder)


def write_world(parent: Path, name: str) -> Path:
    """A valid world whose first robot has sensors; its file."""
    file = parent / "world.yaml"
    world = read_yaml(shipped_worlds()[name].read_text())
    world["robots"][0]["sensors"] = SENSORS
    file.write_text(yaml.safe_dump(world))
    return file


def check_changed_world(data: st.DataObject) -> list[str]:
    with tempfile.TemporaryDirectory() as name:
        file = write_world(Path(name), data.draw(st.sampled_from(WORLDS)))
        change(file, data)
        return world_faults(file)


def run(kind: str, check: Callable[[st.DataObject], list[str]], examples: int) -> None:
    counts: Counter[bool] = Counter()
    longest_s = 0.0

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate, Phase.shrink),
    )
    @given(st.data())
    def fuzzed(data: st.DataObject) -> None:
        nonlocal longest_s
        begun_s = time.process_time()
        counts[not check(data)] += 1
        longest_s = max(longest_s, time.process_time() - begun_s)

    fuzzed()
    told = f"{counts[True]} valid, {counts[False]} refused; the longest took {longest_s * 1000:.0f} ms"
    print(f"{counts.total()} {kind}, no exception: {told}", flush=True)


def main(packs: int = 10_000, worlds: int = 10_000) -> None:
    run("packs", check_changed_pack, packs)
    run("worlds", check_changed_world, worlds)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
