"""A world's clock as it is seen from afar: what its fleet last proclaimed, and the wall clock since."""

import threading
import time
from collections.abc import Callable

TRUSTED_S = 3.0
"""Wall-clock seconds for which a world is taken to go on at its rate after the fleet's last word."""


class FollowingClock:
    """Implements `robots.clock.Clock`. Never goes back within a run; stands still while the fleet is away.

    Thread-safe.
    """

    def __init__(self, wall_s: Callable[[], float] = time.monotonic) -> None:
        self._wall_s = wall_s
        self._lock = threading.Lock()
        self._run = ""
        self._said_s, self._at_s, self._latest_s = 0.0, float("-inf"), 0.0
        self._goes = False
        self._rate: float | None = 1.0

    @property
    def rate(self) -> float | None:
        """World seconds a wall-clock second, as last said; None flat out."""
        return self._rate

    def set(self, run: str, time_s: float, rate: float | None, *, goes: bool) -> None:
        """The fleet's word. `goes`: it is there now, so the world goes on; else the clock stands at this time."""
        with self._lock:
            if run != self._run:
                self._run, self._latest_s = run, 0.0
            self._said_s, self._rate, self._at_s, self._goes = time_s, rate, self._wall_s(), goes

    def stop(self) -> None:
        """The fleet is gone."""
        with self._lock:
            self._latest_s = self._estimate_s()
            self._said_s, self._goes = self._latest_s, False

    def now_s(self) -> float:
        with self._lock:
            self._latest_s = self._estimate_s()
            return self._latest_s

    def _estimate_s(self) -> float:
        since_s = min(self._wall_s() - self._at_s, TRUSTED_S) if self._goes else 0.0
        return max(self._latest_s, self._said_s + since_s * (self._rate or 0.0))
