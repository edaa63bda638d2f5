"""TLS and passwords: who may come in, who is recognised, and that secrets are told to nobody."""

import logging
from collections.abc import Iterator
from pathlib import Path

import pytest
from pydantic import SecretStr

from robots.link.mqtt import Broker
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.papers import make_papers, passwords
from tests.robots.link.mqtt.ends import RUN, a_fleet, a_service, both, received, report
from tests.waiting import until

pytestmark = needs_mosquitto
PASSWORD = "swordfish"


@pytest.fixture(scope="module")
def papers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_papers(tmp_path_factory.mktemp("papers"))


@pytest.fixture
def guarded(tmp_path: Path, papers: Path) -> Iterator[Mosquitto]:
    """A broker that speaks TLS alone, and lets in only who has a certificate of the authority."""
    lines = [
        f"cafile {papers / 'ca.pem'}",
        f"certfile {papers / 'broker.pem'}",
        f"keyfile {papers / 'broker.key'}",
    ]
    with mosquitto(
        tmp_path / "broker", *lines, "require_certificate true", "use_identity_as_username true"
    ) as broker:
        yield broker


@pytest.fixture
def locked(tmp_path: Path) -> Iterator[Mosquitto]:
    """A broker that asks for a password."""
    secrets = passwords(tmp_path / "passwords", macta=PASSWORD)
    with mosquitto(tmp_path / "broker", "allow_anonymous false", f"password_file {secrets}") as broker:
        yield broker


def encrypted(broker: Mosquitto, papers: Path, *, ca: str = "ca", own: str | None = "fleet") -> Broker:
    certificate, key = (papers / f"{own}.pem", papers / f"{own}.key") if own else (None, None)
    return Broker.at(
        f"mqtts://127.0.0.1:{broker.port}", ca=papers / f"{ca}.pem", certificate=certificate, key=key
    )


def test_messages_pass_over_tls_with_certificates_of_both_ends(guarded: Mosquitto, papers: Path) -> None:
    with both(encrypted(guarded, papers)) as (service, fleet):
        for number in range(50):
            fleet.send(report("fred", str(number)))
        assert len(received(service, 50)) == 50


# NOTE: paho leaves the socket of a handshake that failed to the interpreter to close.
@pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <ssl.SSLSocket:pytest.PytestUnraisableExceptionWarning"
)
def test_a_broker_that_our_authority_does_not_know_is_not_spoken_to(guarded: Mosquitto, papers: Path) -> None:
    with a_fleet(encrypted(guarded, papers, ca="other")) as fleet:
        until(lambda: "certificate verify failed" in fleet.complaint)
        assert not fleet.connected


def test_without_a_certificate_of_our_own_it_does_not_let_us_in(guarded: Mosquitto, papers: Path) -> None:
    with a_service(encrypted(guarded, papers, own=None)) as service:
        until(lambda: "client certificate" in service.complaint)
        assert not service.connected


def test_with_the_password_we_are_let_in(locked: Mosquitto) -> None:
    broker = Broker.at(locked.url, username="macta", password=SecretStr(PASSWORD))
    with a_service(broker) as service, a_fleet(broker):
        until(lambda: service.run == RUN)


@pytest.mark.parametrize("password", [None, SecretStr("sword" + "fis")])
def test_with_a_wrong_password_or_none_the_broker_is_said_to_refuse_and_no_secret_shows(
    locked: Mosquitto, password: SecretStr | None, caplog: pytest.LogCaptureFixture
) -> None:
    broker = Broker.at(locked.url, username="macta" if password else None, password=password)
    with caplog.at_level(logging.DEBUG), a_fleet(broker) as fleet:
        until(lambda: fleet.refused)
        assert "does not let" in fleet.complaint
        refused = {fleet.complaint}
        until(lambda: refused.add(fleet.complaint) or len(refused) > 1, "only one of its clients tries")
        assert "uthori" in fleet.complaint
        assert not fleet.connected
    told = [record for record in caplog.records if "does not let" in record.getMessage()]
    assert len(told) == 1, "said once, however often it is tried"
    assert "swordfis" not in caplog.text + fleet.complaint
