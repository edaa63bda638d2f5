"""A broker's address and credentials: what cannot be used is named, and secrets never show."""

from pathlib import Path

import pytest
from pydantic import SecretStr

from robots.link.mqtt import Broker, BrokerError
from tests.papers import make_papers


def test_an_address_has_its_schemes_port_unless_told() -> None:
    assert (Broker.at("mqtt://broker").port, Broker.at("mqtts://broker").port) == (1883, 8883)
    assert str(Broker.at("mqtts://broker:9")) == "mqtts://broker:9"
    assert str(Broker.at("mqtt://[::1]")) == "mqtt://[::1]:1883"


@pytest.mark.parametrize(
    "url",
    ["broker", "http://b", "mqtt://", "mqtt://b:0", "mqtt://b:99999", "mqtt://b/topic", "mqtt://b?x=1", ""],
)
def test_what_is_no_address_is_refused_with_an_example(url: str) -> None:
    with pytest.raises(BrokerError, match=r"mqtt://HOST"):
        Broker.at(url)


def test_credentials_in_the_address_are_refused_and_not_repeated() -> None:
    with pytest.raises(BrokerError, match="MACTA_BROKER_PASSWORD") as refused:
        Broker.at("mqtt://me:hush@broker")
    assert "hush" not in str(refused.value)


def test_a_password_without_a_name_and_certificates_without_tls_are_refused() -> None:
    with pytest.raises(BrokerError, match="user name"):
        Broker.at("mqtt://b", password=SecretStr("hush"))
    with pytest.raises(BrokerError, match="mqtts://b"):
        Broker.at("mqtt://b", ca=Path("ca.pem"))
    with pytest.raises(BrokerError, match="come together"):
        Broker.at("mqtts://b", certificate=Path("me.pem"))
    with pytest.raises(BrokerError, match=r"nowhere\.pem"):
        Broker.at("mqtts://b", ca=Path("nowhere.pem"))


def test_a_password_shows_nowhere() -> None:
    broker = Broker.at("mqtt://127.0.0.1", username="me", password=SecretStr("hush"))
    assert "hush" not in f"{broker} {broker!r}"


def test_who_names_neither_a_user_nor_has_a_certificate_is_anonymous(tmp_path: Path) -> None:
    papers = make_papers(tmp_path)
    own = {"certificate": papers / "fleet.pem", "key": papers / "fleet.key"}
    assert Broker.at("mqtt://b").is_anonymous
    assert Broker.at("mqtts://b").is_anonymous
    assert not Broker.at("mqtt://b", username="service").is_anonymous
    assert not Broker.at("mqtts://b", **own).is_anonymous


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "127.1.2.3", "[::1]"])
def test_loopback_is_of_this_machine_alone(host: str) -> None:
    assert Broker.at(f"mqtt://{host}").is_on_loopback


@pytest.mark.parametrize("host", ["broker", "10.0.0.1", "0.0.0.0", "[fe80::1]"])
def test_anything_else_is_not_loopback(host: str) -> None:
    assert not Broker.at(f"mqtt://{host}").is_on_loopback


def test_only_tls_and_loopback_are_private() -> None:
    assert Broker.at("mqtts://b").is_private
    assert Broker.at("mqtt://localhost").is_private
    assert not Broker.at("mqtt://b").is_private
