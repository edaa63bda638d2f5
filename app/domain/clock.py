"""The seam through which the service reads wall-clock and monotonic time. World time: `robots.clock.Clock`."""

import threading
import time
from datetime import UTC, datetime
from typing import Final, Protocol


class WallClock(Protocol):
    """The time of the machine that the service runs on."""

    def epoch_s(self) -> float:
        """Seconds since 1970-01-01 UTC; may be set back. For what is recorded and shown."""
        ...

    def monotonic_s(self) -> float:
        """Seconds that never run backwards, from an arbitrary origin. For timeouts and intervals."""
        ...

    def wait(self, event: threading.Event, timeout_s: float) -> bool:
        """Block until the event is set, `timeout_s` at most; True if it is set."""
        ...


class SystemClock:
    """The operating system's clock."""

    def epoch_s(self) -> float:
        return time.time()

    def monotonic_s(self) -> float:
        return time.monotonic()

    def wait(self, event: threading.Event, timeout_s: float) -> bool:
        return event.wait(timeout_s)


SYSTEM_CLOCK: Final = SystemClock()
"""The default wherever a `WallClock` is a parameter; it has no state."""


def pause(clock: WallClock, seconds: float) -> None:
    """Block for the given time."""
    clock.wait(threading.Event(), seconds)


def iso_utc(epoch_s: float) -> str:
    """The instant in ISO 8601, UTC, milliseconds: `2026-01-31T12:00:00.000Z`."""
    return datetime.fromtimestamp(epoch_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
