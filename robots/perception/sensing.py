"""The sensory controller (P-SMPA §4.1): runs the sensor actions that are asked for, and no others."""

from robots.errors import SensorFault
from robots.executive.actions import Mode, SensorAction
from robots.perception.datastore import DataStore, MutualDataStore
from robots.physical.body import READS, Body, Readings, Sensor


class SensoryController:
    """Tells the body which sensors to run, and keeps a data store a sensor action, as long as it runs."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self._actions: tuple[SensorAction, ...] = ()
        self._stores: dict[SensorAction, DataStore] = {}
        self.running: frozenset[Sensor] = frozenset()

    def run(self, actions: tuple[SensorAction, ...]) -> None:
        """Go on with these actions and end all others, with their stores; a one-shot that has read is over."""
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
        """Put what was read into the actions' stores and join them.

        :raises SensorFault: if a sensor that runs has read nothing.
        """
        for action, store in self._stores.items():
            if action.sensor in self.running:
                read = getattr(readings, READS[action.sensor])
                if read is None:
                    raise SensorFault(f"{action.sensor} reads nothing")
                store.put(action.sensor, read)
        return MutualDataStore.join(self._stores.values())
