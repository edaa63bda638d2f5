"""Cursors: symbols anchored in what is perceived (SRA; Coradeschi & Saffiotti 2001).

A robot in a hall tracks a dozen things at once, twenty times a second: they are columns, fused by compiled arithmetic
(numba).
"""

from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from math import exp2, hypot, inf
from operator import itemgetter

import numba
import numpy as np
from numpy.typing import NDArray


class Modality(StrEnum):
    """Through which sense something is perceived."""

    INFRA_RED = "infra_red"
    ULTRASONIC = "ultrasonic"
    TOUCH = "touch"

    __hash__ = str.__hash__  # as of sensors, to be looked up quickly


WEIGHT = {Modality.INFRA_RED: 0.3, Modality.ULTRASONIC: 0.1, Modality.TOUCH: 0.5}
"""How much of what is missing to certainty one observation adds (our choice)."""
SIGMA_M = {Modality.INFRA_RED: 0.05, Modality.ULTRASONIC: 0.1, Modality.TOUCH: 0.15}
"""How far the place it tells may be off, metres (our choice)."""


@dataclass(frozen=True, slots=True)
class Observation:
    """Things by name, and where each is.

    :param at: shape (N,), complex, world frame, metres.
    """

    names: tuple[str, ...]
    modality: Modality
    at: NDArray[np.complex128]

    @classmethod
    def of_one(cls, name: str, modality: Modality, at: complex) -> "Observation":
        return cls((name,), modality, np.array([at], dtype=np.complex128))


MOVING_S = 1.5
"""A thing that left its place this long ago and not again stands still."""
HALF_LIFE_S = 2.0
"""Evidence that nothing renews halves in this time (our choice)."""
STILL_M = 0.1
"""Something that seems to move by less than this has not moved: it is within the sensor's noise."""
GONE_S = 0.5
"""Out of view for longer than this breaks a view."""
JUMP_M = 0.5
"""What seems to be this far off was carried there, or is another's echo: it is believed anew."""
VELOCITY_GAIN = 0.1
DRIFT_M2_S = 0.01
"""How uncertain a place becomes that is not observed, variance a second."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cursor:
    """A thing as it is believed to be. World frame, metres; times on the robot's clock, seconds.

    `at` and `velocity` are filtered, as of `seen_s`; `evidence` in [0, 1], as of then; `variance_m2` of the place.
    `viewed_s`: last in infra-red; `in_view_since_s`: there without a break. `anchor`: where it was when it was last
    found to have moved; `rest` and `moved_s`: where it was filtered, and when that last left there.
    """

    at: complex
    anchor: complex
    velocity: complex = 0j
    rest: complex = 0j
    seen_s: float
    viewed_s: float = -inf
    in_view_since_s: float
    still_since_s: float
    moved_s: float = -inf
    evidence: float = 0.0
    variance_m2: float = 1.0

    def moving_at(self, now_s: float) -> bool:
        """True while it does not keep its place."""
        return now_s - self.moved_s <= MOVING_S

    def evidence_at(self, now_s: float) -> float:
        """What is left of its evidence."""
        return self.evidence * exp2(-max(0.0, now_s - self.seen_s) / HALF_LIFE_S)


POINTS = ("at", "anchor", "velocity", "rest")
NUMBERS = ("seen_s", "viewed_s", "in_view_since_s", "still_since_s", "moved_s", "evidence", "variance_m2")
AT, ANCHOR, VELOCITY, REST = range(len(POINTS))
SEEN_S, VIEWED_S, IN_VIEW_SINCE_S, STILL_SINCE_S, MOVED_S, EVIDENCE, VARIANCE_M2 = range(len(NUMBERS))


class Cursors(Mapping[str, Cursor]):
    """The things believed in, by name: columns, and one cursor for who asks for one.

    :param rows: each name's row.
    :param points: shape (K, 4), complex: a row's `POINTS`. :param numbers: shape (K, 7): its `NUMBERS`.
    """

    __slots__ = ("numbers", "points", "rows")

    def __init__(
        self, rows: Mapping[str, int], points: NDArray[np.complex128], numbers: NDArray[np.float64]
    ) -> None:
        self.rows, self.points, self.numbers = rows, points, numbers

    @classmethod
    def of(cls, cursors: Mapping[str, Cursor]) -> "Cursors":
        """From cursors one by one."""
        points = [[getattr(one, name) for name in POINTS] for one in cursors.values()]
        numbers = [[getattr(one, name) for name in NUMBERS] for one in cursors.values()]
        return cls(
            {name: row for row, name in enumerate(cursors)},
            np.array(points, dtype=np.complex128).reshape(-1, len(POINTS)),
            np.array(numbers, dtype=np.float64).reshape(-1, len(NUMBERS)),
        )

    def copy(self) -> "Cursors":
        """As they are now. Names are never added to `rows` in place, only values are changed."""
        return Cursors(self.rows, self.points.copy(), self.numbers.copy())

    def with_new(self, names: Iterable[str]) -> "Cursors":
        """With a row, of no evidence, for each name that has none."""
        new = [name for name in names if name not in self.rows]
        rows = {**self.rows, **{name: len(self.rows) + n for n, name in enumerate(new)}}
        return Cursors(
            rows,
            np.concatenate([self.points, np.zeros((len(new), len(POINTS)), np.complex128)]),
            np.concatenate([self.numbers, np.zeros((len(new), len(NUMBERS)))]),
        )

    def only(self, rows: NDArray[np.int64]) -> "Cursors":
        """Those of these rows."""
        names = list(self.rows)
        kept = {names[row]: n for n, row in enumerate(rows.tolist())}
        return Cursors(kept, self.points[rows], self.numbers[rows])

    def evidence_at(self, now_s: float) -> NDArray[np.float64]:
        """Shape (K,): what is left of each one's evidence."""
        since_s = np.maximum(0.0, now_s - self.numbers[:, SEEN_S])
        return np.asarray(self.numbers[:, EVIDENCE] * np.exp2(-since_s / HALF_LIFE_S))

    def fuse(
        self,
        rows: NDArray[np.int64],
        told: NDArray[np.complex128],
        now_s: float,
        *,
        weight: float,
        noise_m2: float,
        viewed: bool,
    ) -> None:
        """Account, in place, for where these things were told to be; shape (N,), world frame, metres."""
        _fuse(self.points, self.numbers, rows, told, now_s, weight, noise_m2, viewed)

    def __getitem__(self, name: str) -> Cursor:
        row = self.rows[name]
        points = zip(POINTS, self.points[row].tolist(), strict=True)
        numbers = zip(NUMBERS, self.numbers[row].tolist(), strict=True)
        return Cursor(**dict(points), **dict(numbers))

    def __contains__(self, name: object) -> bool:
        return name in self.rows

    def __iter__(self) -> Iterator[str]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def nearest(self, at: complex, but: Container[str]) -> tuple[str, float] | None:
        """The thing believed to be nearest to a point, without some, and how far off it is, metres."""
        places = zip(self.rows, self.points[:, AT].tolist(), strict=True)
        off_m = [(name, abs(place - at)) for name, place in places if name not in but]
        return min(off_m, key=itemgetter(1), default=None)


@numba.njit(cache=True)
def _fuse(
    points: NDArray[np.complex128],
    numbers: NDArray[np.float64],
    rows: NDArray[np.int64],
    told: NDArray[np.complex128],
    now_s: float,
    weight: float,
    noise_m2: float,
    viewed: bool,
) -> None:
    """Evidence: e + w (1 - e), of what has not decayed. Place: a Kalman filter's; velocity: a share of the surprise.

    Since when it has been in view, and still, is by infra-red alone.

    :param points, numbers: of `Cursors`, changed in place. :param rows, told: shape (N,): which things, and where.
    """
    for n in range(len(rows)):
        place, about, at = points[rows[n]], numbers[rows[n]], told[n]
        if about[EVIDENCE] == 0.0:  # new
            place[AT], place[ANCHOR], place[VELOCITY], place[REST] = at, at, 0j, at
            about[SEEN_S], about[IN_VIEW_SINCE_S], about[STILL_SINCE_S] = now_s, now_s, now_s
            about[VIEWED_S], about[MOVED_S] = now_s if viewed else -inf, -inf
            about[EVIDENCE], about[VARIANCE_M2] = weight, noise_m2
            continue
        step_s = now_s - about[SEEN_S]
        evidence = about[EVIDENCE] * exp2(-max(0.0, step_s) / HALF_LIFE_S)
        about[EVIDENCE] = evidence + weight * (1 - evidence)
        expected = place[AT] + place[VELOCITY] * min(step_s, GONE_S)
        variance_m2 = about[VARIANCE_M2] + DRIFT_M2_S * step_s
        gain = variance_m2 / (variance_m2 + noise_m2)
        surprise = at - expected
        if _size(surprise) > JUMP_M:
            place[AT], place[VELOCITY], about[VARIANCE_M2] = at, 0j, noise_m2
        else:
            place[AT], about[VARIANCE_M2] = expected + gain * surprise, (1 - gain) * variance_m2
            if step_s > 0:
                place[VELOCITY] += VELOCITY_GAIN * surprise / step_s
        if _size(place[AT] - place[REST]) > STILL_M:
            place[REST], about[MOVED_S] = place[AT], now_s
        about[SEEN_S] = now_s
        if not viewed:
            continue
        new_view = now_s - about[VIEWED_S] > GONE_S
        moved = _size(at - place[ANCHOR]) > STILL_M
        about[VIEWED_S] = now_s
        if new_view:
            about[IN_VIEW_SINCE_S] = now_s
        if moved:
            place[ANCHOR] = at
        if moved or new_view:
            about[STILL_SINCE_S] = now_s


@numba.njit(cache=True)
def _size(way: complex) -> float:
    return hypot(way.real, way.imag)


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
