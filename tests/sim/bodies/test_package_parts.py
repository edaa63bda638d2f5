"""Bodies and sensors of installed packages, named in a world file."""

from itertools import count
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from robots.conditions.own_state import Measured
from robots.world import WorldFile, digest_of, load_world
from robots.world.parts import RobotSpec
from sim.bodies.velocity import VelocityBody
from sim.clock import TICKS_PER_CONTROL
from sim.error import SimulationError
from sim.world.agent import AgentSetup
from sim.world.simulation import Simulation
from tests.packages import installed, write_package

NUMBERS = count(1)
ENTRY_POINTS = """\
[macta.bodies]
hover = {module}:HoverSpec
brick = {module}:BrickSpec
[macta.sensors]
thermometer = {module}:ThermometerSpec
endoscope = {module}:EndoscopeSpec
"""
PYTHON = """\
from dataclasses import replace
from typing import Literal

from robots.physical.body import Image
from robots.world.bodies import PackageBodySpec, Ramps
from robots.world.sensors import PackageSensorSpec
from sim.bodies.velocity import VelocityBody


class HoverSpec(PackageBodySpec):
    kind: Literal["hover"] = "hover"
    thrust_n: float = 5.0

    def check_speeds(self, robot, *, linear_m_s, angular_rad_s):
        if linear_m_s > 1:
            raise ValueError(f"{robot}.speed_m_s is {linear_m_s}, a hovering body reaches 1")

    def make_body(self, parts):
        ramps = Ramps(acceleration_m_s2=self.thrust_n)
        return HoverBody(parts.spec, ramps, parts.jaws, parts.scene, parts.odometry)


class HoverBody(VelocityBody):
    pass


class BrickSpec(PackageBodySpec):
    kind: Literal["brick"] = "brick"


class ThermometerSpec(PackageSensorSpec):
    kind: Literal["thermometer"] = "thermometer"
    per_m: float = 2.0

    def make_sensor(self, site):
        return Thermometer(site, self.per_m)


class Thermometer:
    def __init__(self, site, per_m):
        self.site = site
        self.per_m = per_m

    def process(self, readings):
        measured = {**readings.measured, "temperature_c": 20 + self.per_m * self.site.pose().x_m}
        return replace(readings, measured=measured)


class EndoscopeSpec(PackageSensorSpec):
    takes_images = True
    kind: Literal["endoscope"] = "endoscope"

    def make_sensor(self, site):
        return Endoscope()


class Endoscope:
    def take(self):
        return Image(media_type="image/jpeg", data=bytes([0xFF, 0xD8, 0xFF]))
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    module = f"floating_rovers_{next(NUMBERS)}"
    return write_package(tmp_path, module, ENTRY_POINTS.format(module=module), {f"{module}.py": PYTHON})


def world(**slots: Any) -> WorldFile:
    file = load_world("relocation_lab").model_dump(mode="json", exclude_defaults=True)
    file["robots"][0] |= slots
    return WorldFile.model_validate(file)


class Idle:
    """Keeps what its body senses."""

    def __init__(self, setup: AgentSetup) -> None:
        self.body = setup.body
        self.spec: RobotSpec = setup.spec

    def tick(self) -> None:
        self.body.set_velocity(0.4, 0.0)


def simulation(file: WorldFile) -> Simulation:
    return Simulation(file, make_agent=Idle, seed=1, jitter_m=0.0)


def refusal(**slots: Any) -> str:
    with pytest.raises(ValidationError) as refused:
        world(**slots)
    return str(refused.value)


def test_a_packages_body_is_simulated_with_its_parameters(site: Path) -> None:
    with installed(site):
        file = world(body={"kind": "hover", "thrust_n": 9})
        with_it = simulation(file)
        body = with_it.bodies["fred"]
        assert isinstance(body, VelocityBody)
        assert type(body).__name__ == "HoverBody"
        start = with_it.truth().robots["fred"]
        for _ in range(60):
            with_it.step()
        assert with_it.truth().robots["fred"].x_m > start.x_m + 0.2
        with_it.close()


def test_a_world_with_a_packages_parts_is_the_same_when_written_and_read(site: Path) -> None:
    with installed(site):
        file = world(body="hover", sensors=["thermometer"])
        written = file.model_dump(mode="json")
        assert written["robots"][0]["body"] == {"kind": "hover", "thrust_n": 5.0}
        assert WorldFile.model_validate(written) == file
        assert WorldFile.model_validate(file.model_dump(mode="json", exclude_defaults=True)) == file
        assert digest_of(world(body={"kind": "hover", "thrust_n": 6})) != digest_of(file)


@pytest.mark.parametrize("kind", ["wheeled", "avatar"])
def test_a_world_with_a_body_of_a_kind_is_the_same_when_written_and_read(kind: str) -> None:
    file = world(body=kind)
    assert WorldFile.model_validate(file.model_dump(mode="json", exclude_defaults=True)) == file
    assert digest_of(file) != digest_of(world())


def test_the_digest_of_a_world_without_them_is_what_it_was() -> None:
    told = load_world("sample_store").model_dump(mode="json", exclude_defaults=True)
    assert all("body" not in robot and "sensors" not in robot for robot in told["robots"])


def test_what_a_packages_sensor_measures_reaches_the_robots_conditions(site: Path) -> None:
    with installed(site):
        file = world(sensors=[{"kind": "thermometer", "per_m": 10}])
        with_it = simulation(file)
        with_it.step()
        x_m = with_it.truth().robots["fred"].x_m
        measured = with_it.bodies["fred"].sense().measured
        assert measured["temperature_c"] == pytest.approx(20 + 10 * x_m, abs=0.2)
        assert with_it.bodies["ginger"].sense().measured == {}
        with_it.close()


def test_cameras_take_images_only_while_they_run(site: Path) -> None:
    with installed(site):
        file = world(sensors=["camera", "endoscope", "thermometer"])
        assert WorldFile.model_validate(file.model_dump(mode="json", exclude_defaults=True)) == file
        with_it = simulation(file)
        body = with_it.bodies["fred"]
        with_it.step()
        assert body.sense().images == {}
        body.run_sensors(frozenset({"camera", "endoscope"}))
        for _ in range(TICKS_PER_CONTROL):
            with_it.step()
        images = body.sense().images
        assert images["endoscope"].data == b"\xff\xd8\xff"
        assert images["camera"].data.startswith(b"\x89PNG")
        with_it.close()


@pytest.mark.parametrize(
    ("slots", "words"),
    [
        ({"body": "balloon"}, "unknown kind 'balloon'; choices: avatar, brick, hover, velocity, wheeled"),
        ({"body": {"kind": "hover", "thrust_n": "much"}}, "thrust_n"),
        ({"body": {"kind": "hover", "lift": 1}}, "lift"),
        ({"body": "hover", "speed_m_s": 1.5}, "fred.speed_m_s is 1.5, a hovering body reaches 1"),
        ({"body": {}}, "kind"),
        ({"body": 3}, "body"),
        ({"sensors": ["nose"]}, "unknown kind 'nose'; choices: camera, endoscope, scanner, thermometer"),
        ({"sensors": [{"per_m": 1}]}, "kind"),
        ({"sensors": [{"kind": "camera", "width": 1}]}, "width"),
        (
            {"sensors": ["camera", {"kind": "camera", "view_deg": 90}]},
            "fred has several cameras of kind camera",
        ),
        ({"sensors": [{"kind": "thermometer", "per_m": []}]}, "per_m"),
    ],
)
def test_what_does_not_fit_is_refused_with_the_choices(site: Path, slots: dict[str, Any], words: str) -> None:
    with installed(site):
        assert words in refusal(**slots)


def test_a_body_that_cannot_be_simulated_is_named(site: Path) -> None:
    with (
        installed(site),
        pytest.raises(SimulationError, match="fred: a body of kind brick cannot be simulated"),
    ):
        simulation(world(body="brick"))


def test_a_sensor_of_no_package_is_refused() -> None:
    assert "unknown kind 'nose'; choices: camera" in refusal(sensors=["nose"])


def test_a_quantity_that_is_not_measured_is_within_no_limits() -> None:
    from tests.robots.sensed import percepts

    assert not Measured(quantity="temperature_c").check(percepts()).holds
