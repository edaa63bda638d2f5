"""An operator drives robots of every kind of body by set-points, and none of them into a wall."""

import pytest

from benchmarks.bodies import embodied
from robots.wire import Message, Performative, SetPoint, Telemetry
from robots.world import load_world
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation
from tests.sim.rig import with_only

ROBOT = "yard_1"


class Driver:
    """An operator of the only robot in a sample store."""

    def __init__(self, body: object, store: str = "sample_store") -> None:
        world = embodied(with_only(load_world(store), ROBOT), body)
        self.simulation = Simulation(world, make_agent=behavioural_agent, seed=2, jitter_m=0.0)
        self.number = 0
        self.told: list[Telemetry] = []

    @property
    def pose(self) -> tuple[float, float]:
        pose = self.simulation.truth().robots[ROBOT]
        return pose.x_m, pose.y_m

    def drive(self, time_s: float, speed_m_s: float = 0.0, turn_rad_s: float = 0.0) -> None:
        for tick in range(round(time_s * 60)):
            if tick % 12 == 0:
                self._wish(speed_m_s, turn_rad_s)
            self.rest(1 / 60)

    def rest(self, time_s: float) -> None:
        """The world goes on without a word of the operator."""
        for _ in range(round(time_s * 60)):
            self.simulation.step()
            heard = [m for m in self.simulation.link.receive() if m.sender == ROBOT]
            self.told += [m.body for m in heard if isinstance(m.body, Telemetry)]

    def _wish(self, speed_m_s: float, turn_rad_s: float) -> None:
        self.number += 1
        wanted = SetPoint(
            driver="ada", number=self.number, speed_m_s=speed_m_s, turn_rad_s=turn_rad_s, valid_s=0.5
        )
        self.simulation.link.send(
            Message(
                performative=Performative.REQUEST,
                sender="service",
                receiver=ROBOT,
                sent_at_s=self.simulation.clock.now_s(),
                body=wanted,
            )
        )


@pytest.mark.parametrize("body", ["velocity", "wheeled", "avatar"])
def test_a_driven_robot_goes_and_stops_with_its_operator(body: str) -> None:
    driver = Driver(body)
    start = complex(*driver.pose)
    driver.drive(4, 0.2)
    gone_m = abs(complex(*driver.pose) - start)
    assert 0.5 < gone_m < 0.85
    assert driver.told[-1].driven_by == "ada"
    driver.rest(0.9)
    stands = complex(*driver.pose)
    assert abs(stands - start) < gone_m + 0.2 * 0.6
    driver.rest(3)
    assert abs(complex(*driver.pose) - stands) < 0.02
    assert driver.told[-1].driven_by is None


@pytest.mark.parametrize("body", ["velocity", "wheeled", "avatar"])
def test_a_driven_robot_touches_nothing(body: str) -> None:
    driver = Driver(body)
    driver.drive(30, 0.3)
    assert driver.told[-1].driven_by == "ada"
    ahead_m = min(one for one in driver.told[-1].ranges_m if one is not None)
    assert 0.02 < ahead_m < 0.3


def test_over_a_poor_radio_it_goes_while_it_hears_and_does_not_set_off_again_when_contact_comes_back() -> (
    None
):
    """A third of all is lost, the rest comes up to 2.6 s late and out of order, nothing at all from 25 to 45 s."""
    driver = Driver("velocity", "sample_store_radio")
    driver.drive(4)
    start = complex(*driver.pose)
    driver.drive(20, 0.1, 0.1)
    stretch = complex(*driver.pose)
    assert abs(stretch - start) > 0.9
    driver.drive(5, 0.1, 0.1)
    stood = complex(*driver.pose)
    driver.drive(20, 0.1, 0.1)
    assert abs(complex(*driver.pose) - stood) < 0.01
    assert driver.told[-1].driven_by is None
