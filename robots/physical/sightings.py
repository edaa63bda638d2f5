"""Readings of the beacon sensor: one sighting, and all sightings of a tick as columns.

A robot sees dozens of beacons and tags twenty times a second, so localisation, tracking and obstacles work on columns.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import cos, isfinite, sin

import numpy as np
from numpy.typing import NDArray

from robots.compiled import kernel


@dataclass(frozen=True, slots=True, kw_only=True)
class Sighting:
    """One infra-red beacon in view: a fixed beacon, another robot's beacon, or the tag of a sample (MACTA §5).

    `aspect_rad` is how far the observer stands off the beacon's nearest emitting axis (0: straight in front of it),
    positive when the observer is counter-clockwise of the axis seen from the beacon; 0 for a beacon without an axis.
    """

    identity: str
    range_m: float
    bearing_rad: float
    aspect_rad: float = 0.0

    @property
    def read(self) -> tuple[float, float, float]:
        """Range, bearing and aspect."""
        return self.range_m, self.bearing_rad, self.aspect_rad

    @property
    def sound(self) -> bool:
        """True if all its readings are finite."""
        return isfinite(sum(self.read))


class Sightings(Mapping[str, Sighting]):
    """What is in view in one tick, by identity; immutable.

    :param names: the N identities, each once.
    :param read: shape (N, 3): range (metres), bearing and aspect (radians) of each.
    """

    __slots__ = ("_rows", "_sound", "names", "read")

    def __init__(self, names: tuple[str, ...], read: NDArray[np.float64]) -> None:
        self.names = names
        self.read = read
        self._rows: dict[str, int] | None = None
        self._sound: bool | None = None

    @classmethod
    def of(cls, sightings: Iterable[Sighting]) -> "Sightings":
        """From sightings one by one."""
        each = {one.identity: one.read for one in sightings}
        return cls(tuple(each), np.array(list(each.values()), dtype=np.float64).reshape(-1, 3))

    @property
    def rows(self) -> Mapping[str, int]:
        """Identity to row."""
        if self._rows is None:
            self._rows = {name: row for row, name in enumerate(self.names)}
        return self._rows

    @property
    def sound(self) -> bool:
        """True if every reading is finite."""
        if self._sound is None:
            self._sound = isfinite(self.read.sum())
        return self._sound

    def in_world(self, x_m: float, y_m: float, heading_rad: float) -> NDArray[np.complex128]:
        """Shape (N,), complex, metres: their places in the frame of the observer's pose."""
        return _in_world(self.read, x_m, y_m, heading_rad)

    def only(self, names: Collection[str]) -> "Sightings":
        """The sightings of these identities."""
        kept = [row for row, name in enumerate(self.names) if name in names]
        return Sightings(tuple(self.names[row] for row in kept), self.read[kept])

    def __getitem__(self, identity: str) -> Sighting:
        range_m, bearing_rad, aspect_rad = self.read[self.rows[identity]].tolist()
        return Sighting(identity=identity, range_m=range_m, bearing_rad=bearing_rad, aspect_rad=aspect_rad)

    def __contains__(self, identity: object) -> bool:
        return identity in self.rows

    def get(self, identity: str, default: Sighting | None = None) -> Sighting | None:  # type: ignore[override]
        return self[identity] if identity in self.rows else default

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sightings):
            return NotImplemented
        return self.names == other.names and self.read.tobytes() == other.read.tobytes()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Sightings({list(self.values())})"


@kernel
def _in_world(
    read: NDArray[np.float64], x_m: float, y_m: float, heading_rad: float
) -> NDArray[np.complex128]:
    ahead = complex(cos(heading_rad), sin(heading_rad))
    at = np.empty(len(read), np.complex128)
    for n in range(len(read)):
        seen = complex(read[n, 0] * cos(read[n, 1]), read[n, 0] * sin(read[n, 1]))
        at[n] = complex(x_m, y_m) + seen * ahead
    return at


NONE_IN_VIEW = Sightings((), np.empty((0, 3)))
