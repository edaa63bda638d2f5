"""Object tracking (SRA): observations of several sensors become cursors, whose evidence grows and decays.

A cursor is a symbol anchored in perception (SRA; Coradeschi & Saffiotti 2001). A robot tracks a dozen things twenty
times a second, so cursors are columns, updated by compiled functions (numba).
"""

import sys
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import hypot, inf
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from robots.compiled import kernel, part
from robots.data import StrEnum

if sys.version_info >= (3, 11):
    from math import exp2  # novm
else:

    @part
    def exp2(x: float) -> float:
        """Two to the power of x."""
        return 2.0**x  # type: ignore[no-any-return]


class Modality(StrEnum):
    """Through which sense something is perceived."""

    INFRA_RED = "infra_red"
    ULTRASONIC = "ultrasonic"
    TOUCH = "touch"

    __hash__ = str.__hash__  # as of sensors, to be looked up quickly


WEIGHT = {Modality.INFRA_RED: 0.3, Modality.ULTRASONIC: 0.1, Modality.TOUCH: 0.5}
"""The share of the missing evidence that one observation adds (our choice)."""
SIGMA_M = {Modality.INFRA_RED: 0.05, Modality.ULTRASONIC: 0.1, Modality.TOUCH: 0.15}
"""Standard deviation of an observed place, metres (our choice)."""


@dataclass(frozen=True, slots=True)
class Observation:
    """The places of named things, by one sensor in one tick.

    :param at: shape (N,), complex, world frame, metres.
    """

    names: tuple[str, ...]
    modality: Modality
    at: NDArray[np.complex128]

    @classmethod
    def of_one(cls, name: str, modality: Modality, at: complex) -> "Observation":
        return cls((name,), modality, np.array([at], dtype=np.complex128))


MOVING_S = 1.5
"""A thing moves until this long after it last left its resting place."""
HALF_LIFE_S = 2.0
"""Of evidence without observations (our choice)."""
STILL_M = 0.1
"""A smaller movement is sensor noise."""
GONE_S = 0.5
"""A view ends after this long out of view."""
JUMP_M = 0.5
"""A larger deviation from the expected place restarts the filter: the thing was carried, or it is another one."""
VELOCITY_GAIN = 0.1
DRIFT_M2_S = 0.01
"""The growth of an unobserved place's variance, a second."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cursor:
    """The belief about one thing. World frame, metres; times on the robot's clock, seconds.

    `at`, `velocity` (both filtered), `evidence` in [0, 1] and `variance_m2` are as of `seen_s`. `viewed_s`: last in
    infra-red; `in_view_since_s`: since when without a break. `anchor`: the raw place of the last movement; `rest`: the
    filtered one, which it last left at `moved_s`.
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
        """True if it has left its resting place recently."""
        return now_s - self.moved_s <= MOVING_S

    def evidence_at(self, now_s: float) -> float:
        """Its decayed evidence."""
        return self.evidence * exp2(-max(0.0, now_s - self.seen_s) / HALF_LIFE_S)


POINTS = ("at", "anchor", "velocity", "rest")
NUMBERS = ("seen_s", "viewed_s", "in_view_since_s", "still_since_s", "moved_s", "evidence", "variance_m2")
AT, ANCHOR, VELOCITY, REST = range(len(POINTS))
SEEN_S, VIEWED_S, IN_VIEW_SINCE_S, STILL_SINCE_S, MOVED_S, EVIDENCE, VARIANCE_M2 = range(len(NUMBERS))


class Cursors(Mapping[str, Cursor]):
    """Cursors by name, kept as columns.

    :param rows: name to row.
    :param points: shape (K, 4), complex: a row's `POINTS`. :param numbers: shape (K, 7): its `NUMBERS`.
    """

    __slots__ = ("numbers", "points", "rows")

    def __init__(
        self, rows: Mapping[str, int], points: NDArray[np.complex128], numbers: NDArray[np.float64]
    ) -> None:
        self.rows = rows
        self.points = points
        self.numbers = numbers

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
        """A snapshot. `rows` is shared, for it is never changed in place."""
        return Cursors(self.rows, self.points.copy(), self.numbers.copy())

    def with_new(self, names: Iterable[str]) -> "Cursors":
        """With a row without evidence for each new name."""
        new = [name for name in names if name not in self.rows]
        rows = {**self.rows, **{name: len(self.rows) + n for n, name in enumerate(new)}}
        return Cursors(
            rows,
            np.concatenate([self.points, np.zeros((len(new), len(POINTS)), np.complex128)]),
            np.concatenate([self.numbers, np.zeros((len(new), len(NUMBERS)))]),
        )

    def only(self, rows: NDArray[np.int64]) -> "Cursors":
        """The cursors of these rows."""
        names = list(self.rows)
        kept = {names[row]: n for n, row in enumerate(rows.tolist())}
        return Cursors(kept, self.points[rows], self.numbers[rows])

    def evidence_at(self, now_s: float) -> NDArray[np.float64]:
        """Shape (K,): the decayed evidence of each."""
        since_s = np.maximum(0.0, now_s - self.numbers[:, SEEN_S])
        return np.asarray(self.numbers[:, EVIDENCE] * np.exp2(-since_s / HALF_LIFE_S))

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
        """The name of the nearest thing that is not in `but`, and its distance, metres."""
        places = zip(self.rows, self.points[:, AT].tolist(), strict=True)
        off_m = [(name, abs(place - at)) for name, place in places if name not in but]
        return min(off_m, key=itemgetter(1), default=None)


@kernel
def _fuse(
    points: NDArray[np.complex128],
    numbers: NDArray[np.float64],
    rows: NDArray[np.int64],
    observed: NDArray[np.complex128],
    now_s: float,
    weight: float,
    noise_m2: float,
    viewed: bool,
) -> None:
    """Evidence e becomes e + w (1 - e). The place is Kalman-filtered; the velocity takes a share of the innovation.

    The times in view and at rest are by infra-red alone.

    :param points, numbers: of `Cursors`, changed in place. :param rows, observed: shape (N,): which things, and where.
    """
    for n in range(len(rows)):
        place = points[rows[n]]
        about = numbers[rows[n]]
        at = observed[n]
        if about[EVIDENCE] == 0.0:  # new
            place[:] = at
            place[VELOCITY] = 0j
            about[SEEN_S] = now_s
            about[IN_VIEW_SINCE_S] = now_s
            about[STILL_SINCE_S] = now_s
            about[VIEWED_S] = now_s if viewed else -inf
            about[MOVED_S] = -inf
            about[EVIDENCE] = weight
            about[VARIANCE_M2] = noise_m2
            continue
        step_s = now_s - about[SEEN_S]
        evidence = about[EVIDENCE] * exp2(-max(0.0, step_s) / HALF_LIFE_S)
        about[EVIDENCE] = evidence + weight * (1 - evidence)
        expected = place[AT] + place[VELOCITY] * min(step_s, GONE_S)
        variance_m2 = about[VARIANCE_M2] + DRIFT_M2_S * step_s
        gain = variance_m2 / (variance_m2 + noise_m2)
        innovation = at - expected
        if _size(innovation) > JUMP_M:
            place[AT] = at
            place[VELOCITY] = 0j
            about[VARIANCE_M2] = noise_m2
        else:
            place[AT] = expected + gain * innovation
            about[VARIANCE_M2] = (1 - gain) * variance_m2
            if step_s > 0:
                place[VELOCITY] += VELOCITY_GAIN * innovation / step_s
        if _size(place[AT] - place[REST]) > STILL_M:
            place[REST] = place[AT]
            about[MOVED_S] = now_s
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


@part
def _size(way: complex) -> float:
    return hypot(way.real, way.imag)


FORGOTTEN = 0.02
"""Things with less evidence are dropped."""
CLEANUP_S = 1.0


class ObjectTracking:
    """Fuses observations of all modalities into one cursor a thing. To be called once a tick."""

    def __init__(self) -> None:
        self.cursors = Cursors.of({})
        """By name; valid until the next observation."""
        self._rows: dict[tuple[str, ...], NDArray[np.int64]] = {}
        self._cleaned_s = float("-inf")

    def observe(self, observed: Iterable[Observation], now_s: float) -> None:
        """Account for the observations of one tick."""
        for one in observed:
            if one.names:
                self._fuse(one, now_s)
        if now_s - self._cleaned_s >= CLEANUP_S:
            self._cleaned_s = now_s
            kept = np.flatnonzero(self.cursors.evidence_at(now_s) >= FORGOTTEN)
            self.cursors = self.cursors.only(kept)
            self._rows = {}

    def _fuse(self, observed: Observation, now_s: float) -> None:
        rows = self._rows_of(observed.names)
        weight = WEIGHT[observed.modality]
        noise_m2 = SIGMA_M[observed.modality] ** 2
        viewed = observed.modality is Modality.INFRA_RED
        points = self.cursors.points
        _fuse(points, self.cursors.numbers, rows, observed.at, now_s, weight, noise_m2, viewed)

    def _rows_of(self, names: tuple[str, ...]) -> NDArray[np.int64]:
        """Shape (N,): the rows of things; new ones are added."""
        if names not in self._rows:
            self.cursors = self.cursors.with_new(names)
            self._rows[names] = np.array([self.cursors.rows[name] for name in names], dtype=np.int64)
        return self._rows[names]
