"""Sensor actions, the data stores that hold their readings, and the controller that runs them (P-SMPA §4.1, §5.2)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType
from typing import Any, Self

from robots.errors import SensorFault, SensorOff
from robots.physical.body import READS, Body, Readings, Sensor


class Mode(StrEnum):
    """How often a sensor action reads (P-SMPA §4.1, multi-mode)."""

    CYCLIC = "cyclic"
    """Every tick."""
    ONE_SHOT = "one_shot"
    """Once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorAction:
    """s = ⟨pre(s), per(s)⟩. Our choice: pre(s) and per(s) are one sensor."""

    sensor: Sensor
    mode: Mode = Mode.CYCLIC


@dataclass(slots=True)
class DataStore:
    """The keys and values of one sensor action, d(k, v); it begins and ends with the action."""

    values: dict[str, Any] = field(default_factory=dict)

    def put(self, key: str, value: Any) -> None:
        self.values[key] = value


@dataclass(frozen=True, slots=True)
class MutualDataStore:
    """The readings that an actuator action can access (P-SMPA §5.2, algorithm 3).

    Our choice: a snapshot of one tick, so that all decisions of a tick rest on the same readings.
    """

    values: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def join(cls, stores: Iterable[DataStore]) -> Self:
        return cls({key: value for store in stores for key, value in store.values.items()})

    def holds(self, keys: Iterable[str]) -> bool:
        return all(key in self.values for key in keys)

    def get(self, key: str) -> Any:
        """:raises SensorOff: if no sensor action has put it: not sensed does not mean "nothing there"."""
        try:
            return self.values[key]
        except KeyError:
            raise SensorOff(f"{key} does not run, and an action asks for its percept") from None


class SensoryController:
    """Tells the body which sensors to run, and keeps a data store for each sensor action while it runs."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self._actions: tuple[SensorAction, ...] = ()
        self._stores: dict[SensorAction, DataStore] = {}
        self.running: frozenset[Sensor] = frozenset()

    def run(self, actions: tuple[SensorAction, ...]) -> None:
        """Run these actions and end all others, with their stores. A one-shot action ends when it has read."""
        if actions != self._actions or any(action.mode is Mode.ONE_SHOT for action in actions):
            self._actions = actions
            self._stores = {action: self._stores.get(action, DataStore()) for action in actions}
            self.running = frozenset(
                action.sensor
                for action, store in self._stores.items()
                if action.mode is Mode.CYCLIC or not store.values
            )
        self._body.run_sensors(self.running)

    def collect(self, readings: Readings) -> MutualDataStore:
        """Put the readings into the actions' stores and join them.

        :raises SensorFault: if a running sensor has no reading.
        """
        for action, store in self._stores.items():
            if action.sensor in self.running:
                reading = getattr(readings, READS[action.sensor])
                if reading is None:
                    raise SensorFault(f"{action.sensor} reads nothing")
                store.put(action.sensor, reading)
        return MutualDataStore.join(self._stores.values())
