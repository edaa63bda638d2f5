"""Robots of a world that others drive: they stand in the way, are seen, and what they move is where they told."""

from math import hypot

import pytest

from robots.physical.body import RADIUS_M, Sensor
from robots.wire import WORLD, ForeignState, Message, MovedSample, Performative, WorldChange
from robots.world import WorldFile, load_world
from sim.snapshot import WorldSnapshot
from sim.world.agent import AgentSetup
from sim.world.simulation import Simulation
from tests.sim.rig import run_s

FOREIGN = "yard_2"
STORE = load_world("sample_store")
AHEAD = (3.0, 1.8, 3.14)
"""Before yard_1, which starts at (1.4, 1.8) and looks there."""


def mixed(*external: str) -> WorldFile:
    document = STORE.model_dump(mode="json")
    for robot in document["robots"]:
        robot["external"] = robot["name"] in external
    return WorldFile.model_validate(document)


class Driver:
    """Drives straight ahead with all sensors running."""

    seen: set[str]

    def __init__(self, setup: AgentSetup) -> None:
        self.others = setup.others
        self._body = setup.body
        self.seen = set()
        self.ahead_m = float("inf")

    def tick(self) -> None:
        self._body.run_sensors(frozenset(Sensor))
        readings = self._body.sense()
        if readings.sightings is not None:
            self.seen = set(readings.sightings.names)
        if readings.ranges_m is not None:
            self.ahead_m = float(readings.ranges_m[0])
        self._body.set_velocity(0.5, 0.0)

    def save(self) -> object:
        return None


def simulated(world: WorldFile, snapshot: WorldSnapshot | None = None) -> Simulation:
    return Simulation(world, make_agent=Driver, seed=3, jitter_m=0.0, snapshot=snapshot)  # type: ignore[arg-type]


def tell(
    simulation: Simulation, version: int = 1, *moved: MovedSample, **robots: tuple[float, float, float]
) -> None:
    said = ForeignState(version=version, robots=robots, samples=moved)
    simulation.link.send(
        Message(performative=Performative.INFORM, sender="service", receiver=WORLD, sent_at_s=0.0, body=said)
    )
    run_s(simulation, 0.1)


def moved(place: str, at_s: float, sample: str = "sample_1") -> MovedSample:
    return MovedSample(sample=sample, place=place, at_s=at_s)


def test_a_simulated_robot_sees_a_foreign_one_and_does_not_drive_through_it() -> None:
    simulation = simulated(mixed(FOREIGN))
    driver = simulation.agents["yard_1"]
    assert isinstance(driver, Driver)
    assert FOREIGN in driver.others
    run_s(simulation, 0.2)
    assert FOREIGN not in driver.seen, "nobody knows where it is"
    tell(simulation, **{FOREIGN: AHEAD})
    assert FOREIGN in driver.seen
    assert driver.ahead_m < 1.5
    for _ in range(10):
        run_s(simulation, 1.0)
        pose = simulation.truth().robots["yard_1"]
        assert hypot(pose.x_m - AHEAD[0], pose.y_m - AHEAD[1]) > 2 * RADIUS_M - 0.02
    tell(simulation, **{FOREIGN: (6.6, 3.0, 0.0)})
    run_s(simulation, 3.0)
    assert simulation.truth().robots["yard_1"].x_m > AHEAD[0], "it made way"


def test_what_a_foreign_robot_takes_and_brings_is_where_it_told() -> None:
    simulation = simulated(mixed(FOREIGN))
    assert simulation.truth().samples["sample_1"].place == "door_1"
    tell(simulation, 1, moved(FOREIGN, 5.0), **{FOREIGN: (6.0, 2.0, 0.0)})
    held = simulation.truth().samples["sample_1"]
    assert held.holders == (FOREIGN,)
    tell(simulation, 1, moved(FOREIGN, 5.0), **{FOREIGN: (6.0, 2.6, 1.57)})
    carried = simulation.truth().samples["sample_1"]
    assert hypot(carried.x_m - 6.0, carried.y_m - 2.6) < 0.6, "it goes with the robot"
    tell(simulation, 2, moved("interchange_2", 20.0), **{FOREIGN: (6.0, 2.6, 1.57)})
    assert simulation.truth().samples["sample_1"].ref == "interchange_2"


def test_a_move_is_followed_once() -> None:
    """A simulated robot may have taken the sample on, and its report may be on the way."""
    simulation = simulated(mixed(FOREIGN))
    tell(simulation, 1, moved("interchange_1", 5.0))
    simulation.scene.set_down("sample_1", (2.0, 2.0))
    for version in (1, 2):
        tell(simulation, version, moved("interchange_1", 5.0))
    assert simulation.truth().samples["sample_1"].place is None
    tell(simulation, 1, moved("door_2", 6.0))
    assert simulation.truth().samples["sample_1"].place is None, "an outdated state"
    tell(simulation, 3, moved("interchange_1", 30.0))
    assert simulation.truth().samples["sample_1"].place == "interchange_1"


@pytest.mark.parametrize(
    ("sample", "place"), [("sample_9", "door_2"), ("sample_1", "yard_1"), ("sample_1", "nowhere")]
)
def test_what_the_world_does_not_have_is_passed_over(sample: str, place: str) -> None:
    simulation = simulated(mixed(FOREIGN))
    before = simulation.truth().samples
    tell(simulation, 1, moved(place, 5.0, sample), ginger=(1.0, 1.0, 0.0))
    assert simulation.truth().samples == before


def test_a_resumed_world_knows_what_it_was_told() -> None:
    world = mixed(FOREIGN)
    simulation = simulated(world)
    tell(simulation, 4, moved(FOREIGN, 5.0), moved("door_2", 4.0, "sample_2"), **{FOREIGN: (6.0, 2.0, 0.0)})
    snapshot = WorldSnapshot.model_validate_json(simulation.snapshot().model_dump_json())
    resumed = simulated(world, snapshot)
    assert resumed.truth() == simulation.truth()
    run_s(resumed, 0.2)
    driver = resumed.agents["yard_1"]
    assert isinstance(driver, Driver)
    assert FOREIGN in driver.seen
    tell(resumed, 5, moved("interchange_2", 20.0), **{FOREIGN: (6.0, 2.6, 0.0)})
    assert resumed.truth().samples["sample_1"].ref == "interchange_2"


def test_a_twin_goes_on_where_the_robot_was_reported_and_the_robot_where_its_twin_was() -> None:
    simulation = simulated(mixed(FOREIGN))
    tell(simulation, **{FOREIGN: (5.0, 1.2, 1.0)})

    def ask(edition: int, world: WorldFile) -> None:
        change = WorldChange(edition=edition, world=world.model_dump(mode="json"))
        simulation.link.send(
            Message(
                performative=Performative.REQUEST,
                sender="service",
                receiver=WORLD,
                sent_at_s=0.0,
                body=change,
            )
        )
        simulation.step_control_cycle()

    ask(1, mixed())
    twin = simulation.truth().robots[FOREIGN]
    assert (twin.x_m, twin.y_m) == pytest.approx((5.0, 1.2), abs=0.05)
    ask(2, mixed(FOREIGN))
    assert FOREIGN not in simulation.truth().robots
