"""Wall clocks that move only when a test says so."""

import threading

from app.domain.clock import SystemClock


class SteppedClock:
    """Stands still between steps; a wait whose event is not set passes at once, and the clock is then that much on.

    Epoch and monotonic time advance together; `set_back` moves the epoch alone, as an administrator may.
    """

    def __init__(self, epoch_s: float = 1_800_000_000.0, monotonic_s: float = 1000.0) -> None:
        self._epoch_s = epoch_s
        self._monotonic_s = monotonic_s
        self._lock = threading.Lock()

    def epoch_s(self) -> float:
        return self._epoch_s

    def monotonic_s(self) -> float:
        return self._monotonic_s

    def wait(self, event: threading.Event, timeout_s: float) -> bool:
        if event.is_set():
            return True
        self.advance(timeout_s)
        return event.is_set()

    def advance(self, step_s: float) -> None:
        if step_s < 0:
            raise ValueError(f"a monotonic clock does not run backwards: step {step_s} s")
        with self._lock:
            self._epoch_s += step_s
            self._monotonic_s += step_s

    def set_back(self, step_s: float) -> None:
        with self._lock:
            self._epoch_s -= step_s


class HeldClock(SystemClock):
    """Waits as long as the system's clock does, while its monotonic time moves only when a test says so."""

    def __init__(self) -> None:
        self.now_s = 1000.0

    def monotonic_s(self) -> float:
        return self.now_s
