"""A robot under another master control, on a link that loses, repeats and delays, with restarts of the adapter.

Our own driver, which sends again what the vehicle's state does not show, is the master.
"""

from datetime import timedelta
from random import Random

import pytest

from benchmarks.vda5050.channel import Channel, Faults
from robots.adapters.driver import ProgressState
from robots.adapters.vda5050.codec import Encoder, decode
from robots.adapters.vda5050.messages import Headed
from robots.adapters.vda5050.robot_vehicle import RobotVehicle
from robots.adapters.vda5050.topics import Topic
from robots.contract.memory_file import TextMemory
from tests.robots.adapters.vda5050.driven import ERRAND, SETTINGS, START
from tests.robots.adapters.vda5050.test_robot_vehicle import Mastered

SEEDS = (89, *range(9))
"""With 89 an order arrives after a restart before it is known where the robot is."""
LIMIT_S = 900
FAULTS = Faults(lost=0.2, repeated=0.3, delay_s=3.0)
RESTARTS_PER_S = 0.2


class Troubled(Mastered):
    """Messages pass by channels with faults."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.flash = TextMemory()
        self.restarts = 0
        super().__init__()
        self._codec = Encoder(lambda: START + timedelta(seconds=self.clock.now_s()))
        self._to_master = Channel(self.random, FAULTS, self._at_master)
        self._from_master = Channel(self.random, FAULTS, self._at_vehicle)
        self.restart()

    def restart(self) -> None:
        self.restarts += 1
        self.vehicle = RobotVehicle(
            "rover", self.id, SETTINGS, self._service_end, self.clock, self._publish, store=self.flash
        )
        self.vehicle.enter_run("run")

    def step(self, seconds: float, *, masters: bool = True) -> None:
        for _ in range(round(seconds * 10)):
            if self.random.random() < RESTARTS_PER_S * 0.1:
                self.restart()
            self._to_master.step(0.1)
            self._from_master.step(0.1)
            super().step(0.1, masters=masters)

    def _publish(self, topic: Topic, message: Headed) -> None:
        self._to_master.send(topic, self._codec.encode(self.id, topic, message))

    def _to_vehicle(self, topic: Topic, message: Headed) -> None:
        self._from_master.send(topic, self._codec.encode(self.id, topic, message))

    def _at_master(self, topic: str, payload: bytes) -> None:
        self.master.heard(decode(self.id, Topic(topic), payload))

    def _at_vehicle(self, topic: str, payload: bytes) -> None:
        self.vehicle.heard(decode(self.id, Topic(topic), payload))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_robot_does_each_step_once_whatever_the_link_does(seed: int) -> None:
    troubled = Troubled(seed)
    troubled.step(5.0)
    assert troubled.master.objection(ERRAND) is None
    for packet in ERRAND.packets:
        assert troubled.master.start(packet.model_copy(update={"id": f"s1/{packet.id}"})) is None
        for _ in range(LIMIT_S):
            troubled.step(1.0)
            if troubled.master.poll().state is not ProgressState.RUNNING:
                break
        assert troubled.master.poll().state is ProgressState.FINISHED, troubled.master.poll()
    done = [(tag, arguments.get("ref1") or arguments.get("ref2")) for tag, arguments in troubled.robot.done]
    assert done == [("NAVIGATE", "bay"), ("DOCK", "bay"), ("TRANSPORT", "door"), ("RELEASE2", "door")]
    assert troubled.restarts > 1
