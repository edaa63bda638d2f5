"""Where a world's snapshot lies on the disk, and its clock beside it. One process at a time may use them."""

import fcntl
import os
import struct
import time
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import Self

from pydantic import ValidationError

from robots.world import WorldFile
from sim.error import NotResumable, SimulationError
from sim.physics.scene import TICK_S
from sim.snapshot import FORMAT, WorldSnapshot, digest_of

PATIENCE_S = 10.0
"""How long the process before, which may be about to end, is waited for."""
PAUSE_S = 0.05
_CLOCK = struct.Struct("<d")


class SnapshotFile:
    """A snapshot is replaced as a whole, so that there is always a whole one. The clock is written before it is shown:
    a world that is resumed shows no time twice.
    """

    def __init__(self, path: Path) -> None:
        """:raises SimulationError: if another process keeps its world there, or the folder cannot be written."""
        self._path, self._new = path, path.with_suffix(".new")
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._lock = os.open(path.with_suffix(".lock"), os.O_RDWR | os.O_CREAT, 0o600)
            _lock(self._lock, path)
            self._clock = os.open(path.with_suffix(".clock"), os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise SimulationError(f"cannot keep snapshots at {path}: {error.strerror}") from error

    def read(self, world: WorldFile) -> WorldSnapshot:
        """The snapshot of a world, its clock where it was last shown.

        :raises NotResumable: if there is none, or it is of something else, or not whole; says which.
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
        """:raises OSError: if it cannot be written; the one before is still there."""
        with os.fdopen(os.open(self._new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as file:
            file.write(snapshot.model_dump_json().encode())
            file.flush()
            os.fsync(file.fileno())
        self._new.replace(self._path)

    def show_time(self, now_s: float) -> None:
        """Before anybody is shown a time. A full disk does not matter here: it is always the same eight bytes."""
        with suppress(OSError):
            os.pwrite(self._clock, _CLOCK.pack(now_s), 0)

    def _shown_ticks(self) -> int:
        shown = os.pread(self._clock, _CLOCK.size, 0)
        time_s = _CLOCK.unpack(shown)[0] if len(shown) == _CLOCK.size else 0.0
        return round(time_s / TICK_S) if isfinite(time_s) else 0

    def close(self) -> None:
        """Let another process use it; so does the end of this one, however it comes."""
        os.close(self._clock)
        os.close(self._lock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _lock(lock: int, path: Path) -> None:
    give_up_s = time.monotonic() + PATIENCE_S
    while True:
        try:
            return fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > give_up_s:
                raise SimulationError(
                    f"another process keeps its world at {path}; end it, or choose another data folder"
                ) from None
            time.sleep(PAUSE_S)
