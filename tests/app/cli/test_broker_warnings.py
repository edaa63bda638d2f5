"""What a command says at its start about the broker that it is given."""

import pytest
from pydantic import SecretStr

from app.cli.long_running import warn_of_broker
from robots.link.mqtt import Broker


def said(broker: Broker | None, capsys: pytest.CaptureFixture[str]) -> list[str]:
    warn_of_broker(broker)
    return capsys.readouterr().err.splitlines()


@pytest.mark.parametrize("url", ["mqtt://broker", "mqtts://10.0.0.7", "mqtt://[fe80::1]"])
def test_an_anonymous_broker_beyond_this_machine_is_warned_of_in_one_line_that_names_the_way_out(
    url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    broker = Broker.at(url)
    (line,) = said(broker, capsys)
    assert line.startswith(f"{broker} accepts anonymous clients")
    assert "MACTA_BROKER_USERNAME" in line


def test_without_a_broker_on_loopback_and_with_a_user_over_tls_nothing_is_warned_of(
    capsys: pytest.CaptureFixture[str],
) -> None:
    known = Broker.at("mqtts://broker", username="service", password=SecretStr("hush"))
    for broker in (None, Broker.at("mqtt://127.0.0.1"), known):
        assert said(broker, capsys) == []


def test_a_password_in_clear_text_is_warned_of_and_does_not_show(capsys: pytest.CaptureFixture[str]) -> None:
    broker = Broker.at("mqtt://broker", username="service", password=SecretStr("hush"))
    (line,) = said(broker, capsys)
    assert "not encrypted" in line
    assert "hush" not in line
