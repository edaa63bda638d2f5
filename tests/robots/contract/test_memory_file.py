"""A robot's persistent memory is replaced wholly or not at all."""

from pathlib import Path

import pytest

from robots.contract.memory_file import MemoryFile


def test_what_was_saved_last_is_read() -> None:
    assert str(MemoryFile(Path("carl.json"))) == "carl.json"


def test_a_text_outlives_its_file_object(tmp_path: Path) -> None:
    path = tmp_path / "carl.json"
    assert MemoryFile(path).load() is None
    MemoryFile(path).save("one")
    MemoryFile(path).save("zwei ü")
    assert MemoryFile(path).load() == "zwei ü"
    assert [one.name for one in tmp_path.iterdir()] == ["carl.json"]
    assert path.stat().st_mode & 0o077 == 0


def test_a_text_that_is_half_written_does_not_replace_the_former(tmp_path: Path) -> None:
    path = tmp_path / "carl.json"
    MemoryFile(path).save("one")
    path.with_name("carl.json.new").write_text("tw")
    assert MemoryFile(path).load() == "one"


def test_a_folder_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"):
        MemoryFile(tmp_path / "nowhere" / "carl.json").save("one")
