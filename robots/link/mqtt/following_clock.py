"""A world's clock as others than its fleet see it: the last announcement, and the wall clock since."""

import threading
import time
from collections.abc import Callable

EXTRAPOLATED_S = 3.0
"""Wall-clock seconds for which the service's clock runs on after the last announcement."""


class FollowingClock:
    """Implements `robots.clock.Clock`. Never goes back within a run; stops without a fleet. Thread-safe."""

    def __init__(
        self, wall_s: Callable[[], float] = time.monotonic, *, extrapolated_s: float = EXTRAPOLATED_S
    ) -> None:
        """:param extrapolated_s: wall-clock seconds for which it runs on after the last announcement."""
        self._wall_s = wall_s
        self._extrapolated_s = extrapolated_s
        self._lock = threading.Lock()
        self._run = ""
        self._announced_s = 0.0
        self._announced_wall_s = float("-inf")
        self._latest_s = 0.0
        self._running = False
        self._rate: float | None = 1.0

    @property
    def rate(self) -> float | None:
        """World seconds a wall-clock second, as last announced; None as fast as possible."""
        return self._rate

    @property
    def is_running(self) -> bool:
        """True while a connected fleet announces the world's time."""
        with self._lock:
            return self._running and self._wall_s() - self._announced_wall_s < self._extrapolated_s

    def set(self, run: str, time_s: float, rate: float | None, *, running: bool) -> None:
        """Note an announcement. `running`: the fleet is connected; otherwise the clock stops at this time."""
        with self._lock:
            if run != self._run:
                self._run = run
                self._latest_s = 0.0
            self._announced_s = time_s
            self._rate = rate
            self._announced_wall_s = self._wall_s()
            self._running = running

    def stop(self) -> None:
        """Stop at the present time: the fleet is disconnected."""
        with self._lock:
            self._latest_s = self._estimate_s()
            self._announced_s = self._latest_s
            self._running = False

    def now_s(self) -> float:
        with self._lock:
            self._latest_s = self._estimate_s()
            return self._latest_s

    def _estimate_s(self) -> float:
        since_s = min(self._wall_s() - self._announced_wall_s, self._extrapolated_s) if self._running else 0.0
        return max(self._latest_s, self._announced_s + since_s * (self._rate or 0.0))
