"""The access control list of examples/: what a user may not say arrives nowhere, nor does what it may not hear.

An auditor, whom only this test knows, hears everything. A message that is allowed follows each that is not, by the same
connection: when it has arrived, the other one would have.
"""

import threading
from collections.abc import Iterator

import pytest
from paho.mqtt.client import Client, MQTTMessage
from paho.mqtt.enums import CallbackAPIVersion
from pydantic import SecretStr

from robots.link.mqtt import Broker, ConnectionState
from tests.mosquitto import ACL, Mosquitto, mosquitto, needs_mosquitto
from tests.papers import passwords
from tests.robots.link.mqtt.ends import (
    ROBOTS,
    RUN,
    Board,
    a_fleet,
    a_service,
    received,
    report,
    script_request,
    telemetry,
)
from tests.waiting import until

pytestmark = needs_mosquitto
USERS = {user: f"{user}s-secret" for user in ("service", "fleet", "auditor", *ROBOTS)}
TO_ROBOTS = ("order", "instantActions")
OF_ROBOTS = ("state", "visualization", "connection", "factsheet")
ALLOWED = [
    *(("service", f"fred/{channel}") for channel in TO_ROBOTS),
    *(("fleet", f"fred/{channel}") for channel in OF_ROBOTS),
    *(("fred", f"fred/{channel}") for channel in OF_ROBOTS),
    ("fleet", "world"),
    ("service", "world"),
]
FORBIDDEN = [
    *(("service", f"fred/{channel}") for channel in OF_ROBOTS),
    *(("fleet", f"fred/{channel}") for channel in TO_ROBOTS),
    *(("fred", topic) for topic in ("world", *(f"fred/{channel}" for channel in TO_ROBOTS))),
    *(("fred", f"ginger/{channel}") for channel in (*TO_ROBOTS, *OF_ROBOTS)),
]
MAY_SAY = {"service": "ginger/order", "fleet": "ginger/state", "fred": "fred/state", "ginger": "ginger/state"}


@pytest.fixture(scope="module")
def broker(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mosquitto]:
    folder = tmp_path_factory.mktemp("guarded")
    acl = folder / "acl"
    acl.write_text("user auditor\ntopic read #\n\n" + ACL.read_text())
    secrets = passwords(folder / "passwords", **USERS)
    doors = ("allow_anonymous false", f"password_file {secrets}", f"acl_file {acl}")
    with mosquitto(folder / "broker", *doors) as broker:
        yield broker


def known_as(user: str, broker: Mosquitto) -> Broker:
    return Broker.at(broker.url, username=user, password=SecretStr(USERS[user]))


class User:
    """A client of the broker; `heard` are the topics of what it was sent."""

    def __init__(self, name: str, broker: Mosquitto) -> None:
        self.heard: list[str] = []
        self._port = broker.port
        self._hears = threading.Event()
        self._client = Client(CallbackAPIVersion.VERSION2)
        self._client.username_pw_set(name, USERS[name])
        self._client.on_message = self._hear
        self._client.on_subscribe = lambda *_: self._hears.set()

    def _hear(self, _: object, __: object, message: MQTTMessage) -> None:
        if not message.retain:  # one that the broker remembers of an earlier test
            self.heard.append(message.topic)

    def __enter__(self) -> "User":
        self._client.connect("127.0.0.1", self._port)
        self._client.loop_start()
        self._client.subscribe("#", qos=1)
        assert self._hears.wait(10)
        return self

    def __exit__(self, *_: object) -> None:
        self._client.disconnect()
        self._client.loop_stop()

    def say(self, topic: str) -> None:
        self._client.publish(f"macta/v1/hall/{topic}", b"{}", qos=1).wait_for_publish(10)


@pytest.mark.parametrize(("user", "topic"), ALLOWED)
def test_everybody_may_say_what_is_theirs_to_say(broker: Mosquitto, user: str, topic: str) -> None:
    with User("auditor", broker) as auditor, User(user, broker) as sender:
        sender.say(topic)
        until(lambda: auditor.heard == [f"macta/v1/hall/{topic}"])


@pytest.mark.parametrize(("user", "topic"), FORBIDDEN)
def test_what_is_not_theirs_to_say_arrives_nowhere(broker: Mosquitto, user: str, topic: str) -> None:
    with User("auditor", broker) as auditor, User(user, broker) as sender:
        sender.say(topic)
        sender.say(MAY_SAY[user])
        until(lambda: auditor.heard)
        assert auditor.heard == [f"macta/v1/hall/{MAY_SAY[user]}"]


def test_a_robot_hears_its_own_orders_alone(broker: Mosquitto) -> None:
    with User("fred", broker) as fred, User("service", broker) as service, User("ginger", broker) as ginger:
        service.say("ginger/order")
        ginger.say("ginger/state")
        service.say("fred/instantActions")
        until(lambda: fred.heard)
        assert fred.heard == ["macta/v1/hall/fred/instantActions"]


def test_a_service_and_a_fleet_that_are_known_by_their_names_work_together(broker: Mosquitto) -> None:
    board = Board()
    with (
        a_service(known_as("service", broker), board) as service,
        a_fleet(known_as("fleet", broker)) as fleet,
    ):
        until(lambda: service.run == RUN and fleet.connected)
        service.take_up(RUN)
        until(lambda: board.are_all(ConnectionState.ONLINE))
        fleet.send(telemetry("fred", 2.5))  # lost if there is anything else to write
        service.send(script_request("fred"))
        fleet.send(report("ginger"))
        assert [message.body.kind for message in received(fleet, 1)] == ["script_request"]
        assert [message.sender for message in received(service, 1)] == ["ginger"]
        until(lambda: board.telemetry == [("fred", 2.5)])


def test_a_robot_drives_no_world_and_speaks_for_no_other(broker: Mosquitto) -> None:
    with User("auditor", broker) as auditor, User("fleet", broker) as fleet:
        with a_fleet(known_as("fred", broker), run="forged") as impostor:
            until(lambda: impostor.connected)
            impostor.announce(7.0, 1.0)
            impostor.send(report("ginger"))
            impostor.send(report("fred"))
        fleet.say("world")
        until(lambda: "macta/v1/hall/world" in auditor.heard)
        until(lambda: "macta/v1/hall/fred/state" in auditor.heard)
        assert auditor.heard.count("macta/v1/hall/world") == 1
        assert not any("/ginger/" in topic for topic in auditor.heard)
