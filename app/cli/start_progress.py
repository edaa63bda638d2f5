"""What a command is doing, on standard error: one line that is redrawn in a terminal, else a line per step."""

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.markup import escape
from rich.status import Status


class StartProgress:
    """Shown within a `with` block, or until `end`; `tell` shows it again. Thread-safe."""

    def __init__(self, console: Console, *, title: str = "Starting") -> None:
        self._console = console
        self._title = title
        self._status = Status(f"{title} …", console=console) if console.is_terminal else None

    def tell(self, doing: str) -> None:
        if self._status is None:
            self._console.print(f"{self._title}: {escape(doing)}.", soft_wrap=True, highlight=False)
        else:
            self._status.update(f"{self._title}: {escape(doing)} …")
            self._status.start()

    def end(self) -> None:
        """Remove the line; safe to call again."""
        if self._status is not None:
            self._status.stop()

    def __enter__(self) -> Self:
        if self._status is not None:
            self._status.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()
