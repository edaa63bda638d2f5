"""Whatever files of packs and worlds hold, checking them ends with faults that name a file, or with none: never with a
crash. `python -m benchmarks.pack_fuzz` checks many more.
"""

import tempfile
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.pack_fuzz import (
    FILES,
    WORLDS,
    check_changed_pack,
    check_changed_world,
    pack_faults,
    world_faults,
    write_pack,
    write_world,
)

FEW = settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def test_what_is_changed_is_valid_before(tmp_path: Path) -> None:
    assert pack_faults(write_pack(tmp_path)) == []
    for name in WORLDS:
        assert world_faults(write_world(tmp_path, name)) == []


@FEW
@given(st.data())
def test_a_pack_with_any_change_is_valid_or_its_faults_name_a_file(data: st.DataObject) -> None:
    check_changed_pack(data)


@FEW
@given(st.data())
def test_a_world_with_any_change_is_valid_or_its_fault_names_the_file(data: st.DataObject) -> None:
    check_changed_world(data)


@FEW
@given(st.sampled_from(FILES), st.binary(max_size=40), st.integers(0, 2000))
def test_a_pack_with_any_bytes_is_valid_or_its_faults_name_a_file(
    name: str, noise: bytes, position: int
) -> None:
    with tempfile.TemporaryDirectory() as parent:
        folder = write_pack(Path(parent))
        content = (folder / name).read_bytes()
        at = position % len(content)
        (folder / name).write_bytes(content[:at] + noise + content[at + len(noise) :])
        pack_faults(folder)
