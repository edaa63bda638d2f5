"""Vehicles of one adapter connect to a guarded broker each as itself, with what `macta robot enrol` gives them."""

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion
from typer.testing import CliRunner

from app.cli.broker_files import digest
from app.cli.main import app
from benchmarks.vda5050.vehicle import SteppedVehicle
from robots.adapters.vda5050.credentials import CredentialsError, broker_of, key_of
from robots.adapters.vda5050.fleet_member import FleetMember
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.clock import ManualClock
from robots.link.mqtt import Broker
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.robots.adapters.vda5050.driven import SETTINGS
from tests.waiting import awaited

WORLD = "hall"
SECRET = "trout"
VEHICLE = VehicleId(manufacturer="STEPPED", serial_number="AGV")


def enrol(folder: Path, robot: str, out: Path) -> None:
    words = ["robot", "enrol", robot, "--folder", str(folder), "--out", str(out)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "credentials"
    folder.mkdir()
    enrol(tmp_path / "guarded", "agv_1", folder / "agv_1.env")
    with (tmp_path / "guarded" / "passwords").open("a") as file:
        file.write(f"service:{digest(SECRET)}\n")
    return folder


@pytest.fixture
def broker(tmp_path: Path, folder: Path) -> Iterator[Mosquitto]:
    guarded = tmp_path / "guarded"
    doors = (f"password_file {guarded / 'passwords'}", f"acl_file {guarded / 'acl'}")
    with mosquitto(tmp_path / "broker", "allow_anonymous false", *doors) as broker:
        yield broker


@needs_mosquitto
def test_a_vehicle_is_there_with_its_own_credentials_alone(
    tmp_path: Path, folder: Path, broker: Mosquitto, caplog: pytest.LogCaptureFixture
) -> None:
    clock = ManualClock()
    states: dict[str, str] = {}
    service = Client(CallbackAPIVersion.VERSION2)
    service.username_pw_set("service", SECRET)
    service.on_message = lambda _, __, message: states.update(
        {message.topic.split("/")[-2]: json.loads(message.payload)["state"]}
    )
    service.connect("127.0.0.1", broker.port)
    service.subscribe(f"macta/+/{WORLD}/+/connection", qos=1)
    service.loop_start()

    def member(name: str) -> FleetMember:
        made = FleetMember(
            name,
            VEHICLE,
            SETTINGS,
            clock,
            lambda topic, message: None,
            world=WORLD,
            broker=lambda: broker_of(name, Broker.at(broker.url), folder),
            folder=tmp_path,
        )
        vehicle = SteppedVehicle(lambda topic, message: made.heard(message))
        vehicle.connect()
        vehicle.publish(Topic.FACTSHEET, vehicle.factsheet())
        vehicle.step(0.1)
        made.tick()
        return made

    with closing(member("agv_1")) as one, closing(member("agv_2")) as other:
        assert (one.is_robot, other.is_robot) == (True, False)
        assert "macta robot enrol agv_2 --out" in caplog.text
        awaited(lambda: dict(states), {"agv_1": "online"}.__eq__)
        (folder / "agv_2.env").write_text((folder / "agv_1.env").read_text())  # another one's
        clock.advance(20.0)
        other.tick()
        assert other.is_robot
    awaited(lambda: dict(states), {"agv_1": "offline"}.__eq__)  # agv_2 may not speak as agv_1 does
    service.disconnect()
    service.loop_stop()


def test_a_vehicle_enrolled_with_a_key_signs(tmp_path: Path) -> None:
    (tmp_path / "agv.env").write_text("MACTA_BROKER_USERNAME=agv\nMACTA_ROBOT_KEY=k\nMACTA_BROKER_PASSWORD=p")
    assert broker_of("agv", Broker.at("mqtt://localhost"), tmp_path).username == "agv"
    assert key_of("agv", tmp_path) == "k"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("MACTA_ROBOT_KEY=k", "neither password nor certificate"),
        ("MACTA_BROKER_USERNAME=agv", "neither password nor certificate"),
    ],
)
def test_credentials_that_cannot_be_used_are_named_without_their_secrets(
    tmp_path: Path, text: str, told: str
) -> None:
    (tmp_path / "agv.env").write_text(text)
    with pytest.raises(CredentialsError, match=told) as error:
        broker_of("agv", Broker.at("mqtt://localhost"), tmp_path)
    assert "agv.env" in str(error.value)
