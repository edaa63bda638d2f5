"""`macta robot enrol` and `revoke`: the files that they write, and what the real broker lets through with them."""

import json
import signal
import ssl
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from paho.mqtt.client import Client, MQTTMessage
from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion
from typer.testing import CliRunner, Result

from app.cli.broker_files import BrokerFiles, digest
from app.cli.main import app
from tests.mosquitto import ACL, Mosquitto, mosquitto, needs_mosquitto
from tests.papers import make_papers
from tests.waiting import until

WAIT_S = 10.0
SERVICE_SECRET = "trout"


def macta(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def enrol(folder: Path, *words: object) -> dict[str, str]:
    """Enrol a robot; the settings that it is given."""
    result = macta("robot", "enrol", *words, "--folder", folder)
    assert result.exit_code == 0, result.output
    lines = [line for line in result.output.splitlines() if line.startswith("MACTA_")]
    return dict(line.split("=", 1) for line in lines)


class Peer:
    """A client of the broker with MQTT 5, which tells why a message was refused."""

    def __init__(
        self, broker: Mosquitto, user: str, password: str | None, tls: ssl.SSLContext | None = None
    ) -> None:
        self.heard: list[str] = []
        self.refused = ""
        self.lost = threading.Event()
        self._port = broker.port
        self._up = threading.Event()
        self._answered = threading.Event()
        self._answers: list[str] = []
        self._client = Client(CallbackAPIVersion.VERSION2, protocol=MQTTProtocolVersion.MQTTv5)
        if password is not None:
            self._client.username_pw_set(user, password)
        if tls is not None:
            self._client.tls_set_context(tls)
        self._client.on_connect = self._connected
        self._client.on_disconnect = lambda *_: self.lost.set()
        self._client.on_message = self._hear
        self._client.on_subscribe = lambda *_: self._up.set()
        self._client.on_publish = lambda _, __, ___, reason, ____: self._answer(str(reason))

    def __enter__(self) -> "Peer":
        self._client.connect("127.0.0.1", self._port)
        self._client.loop_start()
        assert self._up.wait(WAIT_S), "the broker does not answer"
        return self

    def __exit__(self, *_: object) -> None:
        self._client.disconnect()
        self._client.loop_stop()

    def say(self, topic: str) -> str:
        """Publish; the broker's answer."""
        self._answered.clear()
        self._client.publish(f"macta/v1/{topic}", b"{}", qos=1)
        assert self._answered.wait(WAIT_S), topic
        return self._answers[-1]

    def _connected(self, client: Client, _: object, __: object, reason: object, ___: object) -> None:
        if getattr(reason, "is_failure", False):
            self.refused = str(reason)
            self._up.set()
        else:
            client.subscribe("macta/#", qos=1)

    def _hear(self, _: object, __: object, message: MQTTMessage) -> None:
        self.heard.append(message.topic.removeprefix("macta/v1/"))

    def _answer(self, reason: str) -> None:
        self._answers.append(reason)
        self._answered.set()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "guarded"


def doors(folder: Path) -> Sequence[str]:
    return ("allow_anonymous false", f"password_file {folder / 'passwords'}", f"acl_file {folder / 'acl'}")


@pytest.fixture
def enrolled(folder: Path) -> dict[str, str]:
    """The passwords of two enrolled robots, `fred` only for one world, and of the service."""
    secrets = {
        "fred": enrol(folder, "fred", "--world", "hall")["MACTA_BROKER_PASSWORD"],
        "ginger": enrol(folder, "ginger")["MACTA_BROKER_PASSWORD"],
        "service": SERVICE_SECRET,
    }
    with (folder / "passwords").open("a") as file:
        file.write(f"service:{digest(SERVICE_SECRET)}\n")
    return secrets


@pytest.fixture
def broker(tmp_path: Path, folder: Path, enrolled: dict[str, str]) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker", *doors(folder)) as broker:
        yield broker


def test_secrets_are_shown_once_and_stored_as_digests(folder: Path) -> None:
    shown = enrol(folder, "fred", "--sign")
    assert set(shown) == {"MACTA_BROKER_USERNAME", "MACTA_BROKER_PASSWORD", "MACTA_ROBOT_KEY"}
    assert shown["MACTA_BROKER_PASSWORD"] not in (folder / "passwords").read_text()
    files = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert enrol(folder, "fred", "--sign") == {}, "it keeps its secrets"
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == files
    renewed = enrol(folder, "fred", "--renew")
    assert renewed["MACTA_BROKER_PASSWORD"] != shown["MACTA_BROKER_PASSWORD"]
    assert renewed["MACTA_ROBOT_KEY"] != shown["MACTA_ROBOT_KEY"]


def test_secrets_may_go_to_a_file_that_only_its_owner_reads(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "fred.env"
    out.write_text("of another time")
    out.chmod(0o644)
    assert enrol(folder, "fred", "--out", out) == {}
    assert out.read_text().startswith("MACTA_BROKER_USERNAME=fred\nMACTA_BROKER_PASSWORD=")
    private = [out, folder / "passwords", folder / "acl"]
    assert [file.stat().st_mode & 0o777 for file in private] == [0o600] * 3


def test_a_new_folder_of_broker_files_is_for_its_owner_alone(tmp_path: Path) -> None:
    enrol(tmp_path / "new" / "broker", "fred")
    assert (tmp_path / "new" / "broker").stat().st_mode & 0o777 == 0o700


def test_files_of_the_brokers_own_user_stay_readable_for_it(folder: Path) -> None:
    enrol(folder, "fred")
    (folder / "passwords").chmod(0o640)
    enrol(folder, "ginger")
    assert (folder / "passwords").stat().st_mode & 0o777 == 0o640


def test_lines_of_others_are_kept(folder: Path) -> None:
    folder.mkdir()
    (folder / "acl").write_text("user auditor\ntopic read #\n\n# Each by its name.\npattern read x/%u\n")
    (folder / "passwords").write_text("auditor:$7$1$AAAA$AAAA")
    enrol(folder, "fred")
    enrol(folder, "ginger")
    assert macta("robot", "revoke", "fred", "--folder", folder).exit_code == 0
    access = (folder / "acl").read_text()
    assert access.startswith("user auditor\ntopic read #\n")
    assert access.endswith("\n# Each by its name.\npattern read x/%u\n")
    assert "user ginger" in access
    assert "fred" not in access
    users = [line.split(":")[0] for line in (folder / "passwords").read_text().splitlines()]
    assert users == ["auditor", "ginger"]


def test_the_list_names_robots_without_their_secrets(folder: Path) -> None:
    enrol(folder, "ginger", "--sign")
    enrol(folder, "fred", "--world", "hall", "--certificate")
    listed = json.loads(macta("robot", "enrolled", "--json", "--folder", folder).output)
    assert listed["items"] == [
        {"name": "fred", "world": "hall", "password": False, "certificate": True, "signs": False},
        {"name": "ginger", "world": None, "password": True, "certificate": False, "signs": True},
    ]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("enrol", "Fred"), "'Fred' is no robot's name"),
        (("enrol", "fred#"), "is no robot's name"),
        (("enrol", "fred", "--world", "+"), "'+' is no world's name"),
        (("enrol", "service"), "no robot may be named service"),
        (("revoke", "ginger"), "no robot 'ginger' is enrolled"),
    ],
)
def test_what_cannot_be_enrolled_or_revoked_is_named(folder: Path, words: Sequence[str], told: str) -> None:
    result = macta("robot", *words, "--folder", folder)
    assert result.exit_code == 2
    assert told in result.stderr
    assert not (folder / "passwords").exists()


def test_a_user_that_was_not_enrolled_is_not_taken_over(folder: Path) -> None:
    folder.mkdir()
    (folder / "passwords").write_text("fred:$7$1$AAAA$AAAA\n")
    result = macta("robot", "enrol", "fred", "--folder", folder)
    assert result.exit_code == 2
    assert "that was not enrolled" in result.stderr


def test_a_robot_is_not_kept_to_a_world_by_a_list_that_lets_everybody_in_by_name(folder: Path) -> None:
    folder.mkdir()
    (folder / "acl").write_text(ACL.read_text())
    result = macta("robot", "enrol", "fred", "--world", "hall", "--folder", folder)
    assert result.exit_code == 2
    assert "remove them to restrict fred to hall" in result.stderr


@needs_mosquitto
def test_the_broker_lets_an_enrolled_robot_speak_for_itself_alone(
    broker: Mosquitto, enrolled: dict[str, str]
) -> None:
    with (
        Peer(broker, "fred", enrolled["fred"]) as fred,
        Peer(broker, "ginger", enrolled["ginger"]) as ginger,
        Peer(broker, "service", enrolled["service"]) as service,
    ):
        own = [f"hall/fred/{channel}" for channel in ("state", "visualization", "connection", "factsheet")]
        assert {fred.say(topic) for topic in own} == {"Success"}
        forbidden = [
            *(f"hall/ginger/{channel}" for channel in ("state", "visualization", "connection", "factsheet")),
            *("hall/fred/order", "hall/ginger/instantActions", "hall/world", "hall/_world/state"),
            *("yard/fred/state", "yard/fred/speech/ginger"),  # another world than the one that it is let into
            "hall/ginger/speech/fred",
        ]
        assert {fred.say(topic) for topic in forbidden} == {"Not authorized"}
        spoken = ["hall/fred/speech/basil", "hall/fred/speech/ginger"]
        assert {fred.say(topic) for topic in spoken} == {"Success"}
        assert ginger.say("yard/ginger/state") == "Success"
        until(lambda: "yard/ginger/state" in service.heard)
        assert service.heard == [*own, "yard/ginger/state"]
        service.say("hall/ginger/order")
        service.say("hall/fred/order")
        until(lambda: "hall/fred/order" in fred.heard)
        until(lambda: "hall/ginger/order" in ginger.heard)
        assert fred.heard == ["hall/fred/order"]
        assert ginger.heard == ["hall/fred/speech/ginger", "hall/ginger/order"], (
            "what is said to it, not to basil"
        )


@needs_mosquitto
def test_a_broker_without_our_passwords_lets_nobody_in(broker: Mosquitto, enrolled: dict[str, str]) -> None:
    with Peer(broker, "fred", enrolled["ginger"]) as impostor:
        assert impostor.refused == "Not authorized"


@needs_mosquitto
def test_a_reload_lets_a_new_robot_in_and_cuts_a_revoked_one_off(
    broker: Mosquitto, folder: Path, enrolled: dict[str, str]
) -> None:
    with (
        Peer(broker, "fred", enrolled["fred"]) as fred,
        Peer(broker, "service", enrolled["service"]) as service,
    ):
        assert macta("robot", "revoke", "fred", "--folder", folder).exit_code == 0
        secret = enrol(folder, "basil", "--world", "hall")["MACTA_BROKER_PASSWORD"]
        broker.signal(signal.SIGHUP)
        assert fred.lost.wait(WAIT_S), "its connection is ended"

        def basil_speaks() -> bool:
            with Peer(broker, "basil", secret) as basil:
                return not basil.refused and basil.say("hall/basil/state") == "Success"

        until(basil_speaks)
        until(lambda: "hall/basil/state" in service.heard)
    with Peer(broker, "fred", enrolled["fred"]) as again:
        assert again.refused == "Not authorized"


@needs_mosquitto
def test_a_robot_may_show_a_certificate_instead_of_a_password(tmp_path: Path, folder: Path) -> None:
    given = enrol(folder, "fred", "--world", "hall", "--certificate")
    assert set(given) == {"MACTA_BROKER_CA", "MACTA_BROKER_CERTIFICATE", "MACTA_BROKER_KEY"}
    assert Path(given["MACTA_BROKER_KEY"]).stat().st_mode & 0o777 == 0o600
    papers = make_papers(tmp_path)
    tls = [
        f"certfile {papers / 'broker.pem'}",
        f"keyfile {papers / 'broker.key'}",
        f"cafile {folder / 'ca.pem'}",
        "require_certificate true",
        "use_identity_as_username true",
        f"acl_file {folder / 'acl'}",
    ]
    context = ssl.create_default_context(cafile=papers / "ca.pem")
    context.load_cert_chain(given["MACTA_BROKER_CERTIFICATE"], given["MACTA_BROKER_KEY"])
    with mosquitto(tmp_path / "broker", *tls) as broker, Peer(broker, "", None, context) as fred:
        assert fred.say("hall/fred/state") == "Success"
        assert fred.say("hall/ginger/state") == "Not authorized"
        assert macta("robot", "revoke", "fred", "--folder", folder).exit_code == 0
        broker.signal(signal.SIGHUP)
        until(lambda: fred.say("hall/fred/state") == "Not authorized")
    assert BrokerFiles(folder).enrolled() == []
    assert not Path(given["MACTA_BROKER_KEY"]).exists()
