"""Sensor actions, the data stores that hold their readings, and the controller that runs them (P-SMPA §4.1, §5.2)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from robots.data import StrEnum
from robots.errors import SensorFault, SensorOff
from robots.physical.body import Body, Readings


class Mode(StrEnum):
    """How often a sensor action reads (P-SMPA §4.1, multi-mode)."""

    CYCLIC = "cyclic"
    """Every tick."""
    ONE_SHOT = "one_shot"
    """Once."""

    __hash__ = str.__hash__  # as of sensors, to be looked up quickly


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorAction:
    """s = ⟨pre(s), per(s)⟩. Our choice: pre(s) and per(s) are one sensor."""

    sensor: str
    mode: Mode = Mode.CYCLIC


@dataclass(frozen=True, slots=True)
class MutualDataStore:
    """What a sensor action and the actuator action beside it put for each other (P-SMPA §5.2, algorithm 3).

    Our choice: a snapshot of one tick, so that all decisions of a tick rest on the same readings.

    :param values: the readings, by sensor. :param wanted: what the actuator action is about, by name: the sensing side
        looks for these (perceptors `FOR ?x IN wanted`).
    """

    values: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    wanted: tuple[str, ...] = ()

    def holds(self, keys: Iterable[str]) -> bool:
        return all(key in self.values for key in keys)

    def get(self, key: str) -> Any:
        """:raises SensorOff: if no sensor action has put it: not sensed does not mean "nothing there"."""
        try:
            return self.values[key]
        except KeyError:
            raise SensorOff(f"{key} does not run, and an action asks for its percept") from None


class SensoryController:
    """Tells the body which sensors to run, and keeps what each sensor action has read while it runs: its data store."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self._actions: tuple[SensorAction, ...] = ()
        self._has_one_shots = False
        self._stores: dict[SensorAction, Any] = {}
        self._wanted: tuple[str, ...] = ()
        self.running: frozenset[str] = frozenset()

    def run(self, actions: tuple[SensorAction, ...], wanted: tuple[str, ...] = ()) -> None:
        """Run these actions and end all others, with their stores. A one-shot action ends when it has read.

        :param wanted: what the actuator action beside them puts into the mutual store.
        """
        self._wanted = wanted
        if actions != self._actions or self._has_one_shots:
            self._actions = actions
            self._has_one_shots = any(action.mode is Mode.ONE_SHOT for action in actions)
            self._stores = {action: self._stores[action] for action in actions if action in self._stores}
            self.running = frozenset(
                action.sensor
                for action in actions
                if action.mode is Mode.CYCLIC or action not in self._stores
            )
        self._body.run_sensors(self.running)

    def collect(self, readings: Readings) -> MutualDataStore:
        """Put the readings into the actions' stores and join them.

        :raises SensorFault: if a running sensor has no reading.
        """
        read = readings.by_sensor()
        for action in self._actions:
            if action.sensor in self.running:
                if action.sensor not in read:
                    raise SensorFault(f"{action.sensor} reads nothing")
                self._stores[action] = read[action.sensor]
        read_now = {action.sensor: reading for action, reading in self._stores.items()}
        return MutualDataStore(read_now, self._wanted)
