"""The Object Tracking activity (SRA): reinforces evidence, keeps cursors, lets go of what nothing tells of any more."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from robots.perception.observation import SIGMA_M, WEIGHT, Modality, Observation
from robots.perception.tracking import Cursors

FORGOTTEN = 0.02
TIDY_S = 1.0


class ObjectTracking:
    """Fuses observations of any modality into one cursor a thing. Feed it once a tick."""

    def __init__(self) -> None:
        self._cursors = Cursors.of({})
        self._rows: dict[tuple[str, ...], NDArray[np.int64]] = {}
        self._tidied_s = float("-inf")

    @property
    def cursors(self) -> Cursors:
        """All things believed in, by name, as they are until the next observation."""
        return self._cursors

    def observe(self, told: Iterable[Observation], now_s: float) -> None:
        """Account for what sensors told at one instant."""
        for one in told:
            if one.names:
                self._fuse(one, now_s)
        if now_s - self._tidied_s >= TIDY_S:
            self._tidied_s = now_s
            kept = np.flatnonzero(self._cursors.evidence_at(now_s) >= FORGOTTEN)
            self._cursors, self._rows = self._cursors.only(kept), {}

    def _fuse(self, told: Observation, now_s: float) -> None:
        rows, viewed = self._rows_of(told.names), told.modality is Modality.INFRA_RED
        weight, noise_m2 = WEIGHT[told.modality], SIGMA_M[told.modality] ** 2
        self._cursors.fuse(rows, told.at, now_s, weight=weight, noise_m2=noise_m2, viewed=viewed)

    def _rows_of(self, names: tuple[str, ...]) -> NDArray[np.int64]:
        """Shape (N,): the rows of things, those that are new with no evidence yet."""
        if names not in self._rows:
            self._cursors = self._cursors.with_new(names)
            self._rows[names] = np.array([self._cursors.rows[name] for name in names], dtype=np.int64)
        return self._rows[names]
