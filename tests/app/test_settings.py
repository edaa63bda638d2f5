"""The token's file and the data folder: what a full disk or an older version left does not open the door."""

import errno
import os
import stat
from pathlib import Path

import pytest

from app.domain.errors import Invalid, Unavailable
from app.settings import MIN_TOKEN_LENGTH, Settings, lock_folder
from app.store import Database


def settings(data: Path) -> Settings:
    return Settings(data=data, token=None, database_url=None)


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize(
    "held", [b"", b"\n", b"short\n", b"\0" * 44, b" " * 44, b"\xff" * 44], ids=lambda held: repr(held[:6])
)
def test_a_file_that_holds_no_token_is_refused_by_name(tmp_path: Path, held: bytes) -> None:
    file = tmp_path / "token"
    file.write_bytes(held)
    with pytest.raises(Invalid, match=f"{file} .*{MIN_TOKEN_LENGTH}.*delete") as refused:
        settings(tmp_path).resolved_token()
    assert refused.value.code == "token-damaged"


def test_a_token_that_cannot_be_read_is_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "token").mkdir()
    with pytest.raises(Invalid, match=str(tmp_path / "token")):
        settings(tmp_path).resolved_token()


def test_the_token_is_made_once_and_for_its_owner_only(tmp_path: Path) -> None:
    token = settings(tmp_path).resolved_token()
    assert len(token) >= MIN_TOKEN_LENGTH
    assert settings(tmp_path).resolved_token() == token
    assert mode(tmp_path / "token") == 0o600
    assert [path.name for path in tmp_path.iterdir()] == ["token"]


def test_a_full_disk_leaves_no_token_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as disk:
        disk.setattr(os, "fsync", full)
        with pytest.raises(Unavailable, match="No space left on device"):
            settings(tmp_path).resolved_token()
    assert list(tmp_path.iterdir()) == []
    assert settings(tmp_path).resolved_token()


def test_what_an_interrupted_start_left_does_not_stand_in_the_way(tmp_path: Path) -> None:
    settings(tmp_path).resolved_token()
    (tmp_path / "token").rename(tmp_path / "token.unfinished")
    assert settings(tmp_path).resolved_token() == (tmp_path / "token").read_text().strip()


def test_an_existing_data_folder_is_closed_to_other_users(tmp_path: Path) -> None:
    data = tmp_path / "data"
    data.mkdir()
    data.chmod(0o755)
    lock_folder(data).close()
    assert mode(data) == 0o700


def test_a_folder_for_everyone_is_left_as_it_is_and_warned_of(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    tmp_path.chmod(0o1777)
    lock_folder(tmp_path).close()
    assert mode(tmp_path) == 0o1777
    assert str(tmp_path) in caplog.text


@pytest.mark.parametrize("existing", [False, True])
def test_a_database_file_is_readable_for_its_owner_only(tmp_path: Path, existing: bool) -> None:
    file = tmp_path / "macta.sqlite"
    if existing:
        for suffix in ("", "-wal", "-shm"):
            (tmp_path / f"macta.sqlite{suffix}").touch(0o644)
    umask = os.umask(0o022)
    try:
        database = Database(f"sqlite:///{file}")
        with database.write() as session:
            session.connection().exec_driver_sql("CREATE TABLE thing (id INTEGER)")
            assert {path.name: mode(path) for path in tmp_path.iterdir()} == {
                "macta.sqlite": 0o600,
                "macta.sqlite-wal": 0o600,
                "macta.sqlite-shm": 0o600,
            }
        database.close()
    finally:
        os.umask(umask)
