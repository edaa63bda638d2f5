"""The file with a world's snapshot, and its clock beside it. One process at a time may use them."""

import fcntl
import os
import struct
from contextlib import suppress
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Self

from pydantic import ValidationError

from robots.world import WorldFile, digest_of
from sim.clock import TICK_S, SleepingClock, WallClock
from sim.error import NotResumable, SimulationError
from sim.snapshot import FORMAT, WorldSnapshot

LOCK_TIMEOUT_S = 10.0
"""How long to wait for a previous process that may be about to end."""
LOCK_RETRY_S = 0.05
_CLOCK = struct.Struct("<d")


@dataclass(frozen=True, slots=True, kw_only=True)
class SnapshotSettings:
    """Where a world's snapshots are stored, and whether to resume from them.

    :param run: the run to resume, None if none is known.
    :param any_run: resume whatever run is there: the record of runs is kept elsewhere.
    :param start_new: do not resume, whatever is there.
    :param resume_only: fail rather than start a new world.
    """

    folder: Path
    run: str | None = None
    any_run: bool = False
    start_new: bool = False
    resume_only: bool = False

    def path_of(self, world: WorldFile) -> Path:
        return self.folder / f"{world.name}.json"

    def shown_s(self, world: WorldFile) -> float:
        """The time of the world's clock that was shown last; 0 if it will not be resumed."""
        if self.start_new or self.run is None:
            return 0.0
        try:
            return _seconds(self.path_of(world).with_suffix(".clock").read_bytes())
        except OSError:
            return 0.0


class SnapshotFile:
    """Stores the snapshot atomically, and the clock before it is shown: a resumed world's clock does not go back.

    :raises SimulationError: if another process uses the file, or the folder cannot be written.
    """

    def __init__(self, path: Path, wall_clock: SleepingClock | None = None) -> None:
        self._path = path
        self._new_path = path.with_suffix(".new")
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._lock = os.open(path.with_suffix(".lock"), os.O_RDWR | os.O_CREAT, 0o600)
            _lock(self._lock, path, wall_clock or WallClock())
            self._clock = os.open(path.with_suffix(".clock"), os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise SimulationError(f"cannot store snapshots at {path}: {error.strerror}") from error

    def read(self, world: WorldFile) -> WorldSnapshot:
        """The snapshot of a world, its clock where it was last shown.

        :raises NotResumable: if there is none, it is of another world or format, or it is damaged.
        """
        try:
            text = self._path.read_bytes()
        except FileNotFoundError:
            raise NotResumable("there is no snapshot of it") from None
        if b'"format":%d,' % FORMAT not in text[:40]:
            raise NotResumable(f"its snapshot is not of format {FORMAT}")
        try:
            snapshot = WorldSnapshot.model_validate_json(text)
        except ValidationError as error:
            raise NotResumable(f"its snapshot cannot be read: {error.errors()[0]['msg']}") from error
        if snapshot.digest != digest_of(world):
            raise NotResumable("its snapshot is of another world file")
        return snapshot.model_copy(update={"ticks": max(snapshot.ticks, self._shown_ticks())})

    def write(self, snapshot: WorldSnapshot) -> None:
        """:raises OSError: if it cannot be written; the previous snapshot is still there."""
        with os.fdopen(os.open(self._new_path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as file:
            file.write(snapshot.model_dump_json().encode())
            file.flush()
            os.fsync(file.fileno())
        self._new_path.replace(self._path)

    def write_clock(self, now_s: float) -> None:
        """To be called before a time is shown. A full disk does not matter: the same eight bytes are rewritten."""
        with suppress(OSError):
            os.pwrite(self._clock, _CLOCK.pack(now_s), 0)

    def _shown_ticks(self) -> int:
        return round(_seconds(os.pread(self._clock, _CLOCK.size, 0)) / TICK_S)

    def close(self) -> None:
        """Unlock the file for other processes; the end of this process does the same."""
        os.close(self._clock)
        os.close(self._lock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _seconds(shown: bytes) -> float:
    time_s: float = _CLOCK.unpack(shown)[0] if len(shown) == _CLOCK.size else 0.0
    return time_s if isfinite(time_s) else 0.0


def _lock(lock: int, path: Path, wall_clock: SleepingClock) -> None:
    deadline_s = wall_clock.now_s() + LOCK_TIMEOUT_S
    while True:
        try:
            return fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if wall_clock.now_s() > deadline_s:
                os.close(lock)
                raise SimulationError(
                    f"another process keeps its world at {path}; end it, or choose another data folder"
                ) from None
            wall_clock.sleep(LOCK_RETRY_S)
