"""Stores recordings: a folder for each mission, a file for each process that recorded it; deletes the oldest."""

import re
import shutil
import struct
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader
from mcap.records import Channel, Message, Schema
from mcap.writer import Writer

from app.domain.errors import NotFound
from app.recordings.mcap_writer import McapWriter
from app.settings import Settings

Entry = tuple[Schema | None, Channel, Message]
CUT_OFF = (McapError, EOFError, struct.error, FileNotFoundError)
"""Raised at the end of a file that its process could not finish, and for a file that was deleted meanwhile."""
PART = "part-"
_ID = re.compile("[A-Za-z0-9-]{1,120}")
MEASUREMENTS_PER_BUDGET = 100
"""The folders are measured each time that this part of the budget, 1 / N, was written."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """A mission's recording; `written_at` is when it was last written to (epoch seconds)."""

    mission_id: str
    size_bytes: int
    written_at: float


class RecordingStore:
    """The recordings in a folder, within a budget of bytes."""

    def __init__(self, folder: Path, *, budget_bytes: int) -> None:
        self._folder = folder
        self._budget_bytes = budget_bytes
        self._unmeasured_bytes = budget_bytes

    @classmethod
    def of(cls, settings: Settings) -> "RecordingStore":
        """In the data folder, as the settings say."""
        return cls(settings.data / "recordings", budget_bytes=settings.recordings_mb * 1_000_000)

    @property
    def is_disabled(self) -> bool:
        return self._budget_bytes == 0

    @property
    def is_measurement_due(self) -> bool:
        """True once enough was written since the last measurement; measuring every folder takes time."""
        return self._unmeasured_bytes * MEASUREMENTS_PER_BUDGET >= self._budget_bytes

    def new_part(self, mission_id: str) -> McapWriter:
        """A writer for the mission's next part."""
        folder = self._folder / mission_id
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        return McapWriter(folder / f"{PART}{len(self._parts(mission_id)):04d}.mcap", wrote=self._wrote)

    def _wrote(self, size_bytes: int) -> None:
        self._unmeasured_bytes += size_bytes

    def has(self, mission_id: str) -> bool:
        return bool(self._parts(mission_id))

    def recordings(self) -> list[Recording]:
        """The newest first."""
        found = [self._measured(folder) for folder in self._folder.glob("*/")]
        return sorted((one for one in found if one), key=lambda one: one.written_at, reverse=True)

    def entries(self, mission_id: str) -> Iterator[Entry]:
        """All entries in the order they were recorded; a truncated end is left out.

        :raises NotFound: if there is no recording of the mission.
        """
        parts = self._parts(mission_id)
        if not parts:
            why = "none was made, or it was deleted to make room for newer ones"
            raise NotFound(f"no recording of mission {mission_id!r}: {why}", code="no-recording")
        return chain.from_iterable(entries_of(part) for part in parts)

    def merged_file(self, mission_id: str) -> IO[bytes]:
        """All parts merged into one unnamed temporary file, open at its start; the caller closes it.

        :raises NotFound: if there is no recording of the mission.
        """
        entries = self.entries(mission_id)
        with ExitStack() as on_failure:
            stream = on_failure.enter_context(TemporaryFile(dir=self._folder))
            writer = Writer(stream)
            writer.start(profile="", library="macta")
            _copy(entries, writer)
            writer.finish()  # type: ignore[no-untyped-call]
            stream.seek(0)
            on_failure.pop_all()
        return stream

    def delete_oldest(self, *, keep: frozenset[str] = frozenset()) -> list[str]:
        """Delete the oldest recordings beyond the budget, except those to `keep`; returns their missions."""
        deleted = []
        size_bytes = 0
        self._unmeasured_bytes = 0
        for recording in self.recordings():
            size_bytes += recording.size_bytes
            if size_bytes > self._budget_bytes and recording.mission_id not in keep:
                shutil.rmtree(self._folder / recording.mission_id, ignore_errors=True)
                deleted.append(recording.mission_id)
        return deleted

    def _parts(self, mission_id: str) -> list[Path]:
        # The id comes from a client: it must not name a path outside the folder.
        if _ID.fullmatch(mission_id) is None:
            return []
        return sorted((self._folder / mission_id).glob(f"{PART}*.mcap"))

    def _measured(self, folder: Path) -> Recording | None:
        sizes = []
        times = []
        with suppress(FileNotFoundError):  # being deleted
            for path in folder.iterdir():
                known = path.stat()
                sizes.append(known.st_size)
                times.append(known.st_mtime)
        if not times:
            return None
        return Recording(mission_id=folder.name, size_bytes=sum(sizes), written_at=max(times))


def entries_of(part: Path) -> Iterator[Entry]:
    """The entries of one file; none of a file that is no MCAP."""
    with suppress(*CUT_OFF), part.open("rb") as stream:
        yield from NonSeekingReader(stream).iter_messages(log_time_order=False)


def _copy(entries: Iterator[Entry], writer: Writer) -> None:
    channels: dict[str, int] = {}
    for schema, channel, message in entries:
        if channel.topic not in channels:
            kind = 0 if schema is None else writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.topic] = writer.register_channel(channel.topic, channel.message_encoding, kind)
        writer.add_message(
            channels[channel.topic],
            log_time=message.log_time,
            data=message.data,
            publish_time=message.publish_time,
        )
