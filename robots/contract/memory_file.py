"""Where a robot's persistent memory is kept."""

import os
from pathlib import Path
from typing import Protocol


class MemoryStore(Protocol):
    """Keeps one text. A text is there wholly or not at all, whenever the power fails."""

    def load(self) -> str | None:
        """The text that was saved last; None if none was.

        :raises OSError: if it cannot be read.
        """
        ...

    def save(self, text: str) -> None:
        """Replace the text; it is durable when this returns.

        :raises OSError: if it cannot be written; then the former text is still there.
        """
        ...


class TextMemory:
    """Keeps the text in a variable, for a simulated robot's snapshot. Implements `MemoryStore`.

    :param text: the one that was saved last; empty if none was.
    """

    def __init__(self, text: str = "") -> None:
        self.text = text

    def load(self) -> str | None:
        return self.text or None

    def save(self, text: str) -> None:
        self.text = text


class MemoryFile:
    """Keeps the text in a file, which is written beside the old one, flushed to the disk, and renamed."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._new_path = path.with_name(path.name + ".new")

    def __str__(self) -> str:
        return str(self._path)

    def load(self) -> str | None:
        try:
            return self._path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None

    def save(self, text: str) -> None:
        draft = os.open(self._new_path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        with os.fdopen(draft, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        self._new_path.replace(self._path)
        folder = os.open(self._path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def counter_file(memory: Path) -> MemoryFile:
    """Beside a robot's memory: the counters of the orders that it has taken (`robots.link.mqtt.order_check`)."""
    return MemoryFile(memory.with_name(memory.name + ".counters"))
