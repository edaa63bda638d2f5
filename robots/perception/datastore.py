"""Data stores of behaviours, and what joins them (P-SMPA §5.2, algorithm 3)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Self

from robots.errors import SensorOff


@dataclass(slots=True)
class DataStore:
    """One behaviour's keys and values, d(k, v). It begins and ends with its behaviour."""

    values: dict[str, Any] = field(default_factory=dict)

    def put(self, key: str, value: Any) -> None:
        self.values[key] = value


@dataclass(frozen=True, slots=True)
class MutualDataStore:
    """What an actuator action can get at this instant from the sensor actions beside it.

    Our choice: a picture of one instant, so that all of a tick's decisions rest on the same readings.
    """

    values: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def join(cls, stores: Iterable[DataStore]) -> Self:
        return cls({key: value for store in stores for key, value in store.values.items()})

    def holds(self, keys: Iterable[str]) -> bool:
        return all(key in self.values for key in keys)

    def get(self, key: str) -> Any:
        """:raises SensorOff: if no behaviour has put it: what is not sensed is not "nothing there"."""
        try:
            return self.values[key]
        except KeyError:
            raise SensorOff(f"{key} does not run, and an action asks for its percept") from None
