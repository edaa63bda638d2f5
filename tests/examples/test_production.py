"""docker-compose.yml keeps to the house rules, and the script that does without containers reads it right."""

import os
import re
import signal
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

from app.settings import Settings
from examples import production
from examples.production import COMPOSE, Incomplete, filled, parts_of

SECRETS = {
    "MACTA_TOKEN": "a-token-for-the-tests",
    "MACTA_DATABASE_PASSWORD": "open-sesame",
    "MACTA_SERVICE_PASSWORD": "swordfish",
    "MACTA_FLEET_PASSWORD": "trout",
}
COMPOSED: dict[str, Any] = yaml.safe_load(COMPOSE.read_text())


SERVICES = [pytest.param(service, id=name) for name, service in COMPOSED["services"].items()]


def text_of(thing: object) -> list[str]:
    """Every piece of text in it."""
    if isinstance(thing, dict):
        return [text for value in thing.values() for text in text_of(value)]
    return [text for value in thing for text in text_of(value)] if isinstance(thing, list) else [str(thing)]


@pytest.mark.parametrize("service", SERVICES)
def test_every_service_says_whether_it_is_well_and_comes_back_when_it_dies(service: dict[str, Any]) -> None:
    assert service["healthcheck"]["test"][0] in ("CMD", "CMD-SHELL")
    assert service["restart"] == "unless-stopped"


@pytest.mark.parametrize("service", SERVICES)
def test_ports_are_of_this_machine_unless_the_operator_says_otherwise(service: dict[str, Any]) -> None:
    for port in service.get("ports", []):
        assert filled(port, {}).startswith("127.0.0.1:")


def test_only_the_api_has_a_port() -> None:
    assert [name for name, service in COMPOSED["services"].items() if "ports" in service] == ["api"]


def test_secrets_come_from_outside_and_have_no_default() -> None:
    secret = re.compile(r"PASSWORD|TOKEN|SECRET")
    for service in COMPOSED["services"].values():
        for name, value in service.get("environment", {}).items():
            if secret.search(name):
                assert re.fullmatch(r"\$\{\w+:[?-][^}]*\}", value), f"{name} is written down"
        for text in text_of(service):
            for name, kind, more in re.findall(r"\$\{(\w*(?:PASSWORD|TOKEN)\w*):([?-])([^}]*)\}", text):
                assert kind == "?" or not more, f"{name} has a default that everybody knows"


@pytest.mark.parametrize("missing", sorted(SECRETS))
def test_a_secret_that_is_missing_is_named(missing: str) -> None:
    with pytest.raises(Incomplete, match=missing):
        parts_of(COMPOSED, {name: value for name, value in SECRETS.items() if name != missing})


def test_every_service_that_is_waited_for_is_there_and_says_whether_it_is_well() -> None:
    for service in COMPOSED["services"].values():
        for needed in service.get("depends_on", {}):
            assert "healthcheck" in COMPOSED["services"][needed]


def test_our_services_are_set_with_settings_that_there_are() -> None:
    known = {f"MACTA_{name.upper()}" for name in Settings.model_fields}
    parts = {part.name: part for part in parts_of(COMPOSED, SECRETS)}
    assert set(parts) == {"api", "worker", "fleet"}
    for part in parts.values():
        assert set(part.environment) <= known, part.name
    assert parts["api"].copies >= 2
    assert parts["api"].environment["MACTA_PLANNING_PROCESSES"] == "0"
    assert "MACTA_TOKEN" not in parts["worker"].environment
    assert "MACTA_DATABASE_URL" not in parts["fleet"].environment
    users = {name: part.environment["MACTA_BROKER_USERNAME"] for name, part in parts.items()}
    assert users == {"api": "service", "worker": "service", "fleet": "fleet"}
    secrets = {name: part.environment["MACTA_BROKER_PASSWORD"] for name, part in parts.items()}
    assert secrets == {"api": "swordfish", "worker": "swordfish", "fleet": "trout"}
    assert "open-sesame@database:5432/macta" in parts["api"].environment["MACTA_DATABASE_URL"]


def test_variables_are_filled_in_as_compose_does() -> None:
    given = {"WORLD": "lab"}
    assert filled("${WORLD:-store} ${NONE:-store} $${WORLD} [${NONE:-}] ${WORLD:?needed}", given) == (
        "lab store ${WORLD} [] lab"
    )


class Shape:
    """Is told to end while it is looked at."""

    ended = 0

    def __init__(self, folder: Path, given: Mapping[str, str]) -> None:
        self.running: dict[str, production.Running] = {}

    def look(self) -> Sequence[production.Running]:
        os.kill(os.getpid(), signal.SIGTERM)
        return []

    def end(self) -> None:
        Shape.ended += 1


def test_a_signal_to_end_ends_every_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(production, "Shape", Shape)
    monkeypatch.setattr(Shape, "ended", 0)
    monkeypatch.setattr("sys.argv", ["production", str(tmp_path)])
    before = signal.getsignal(signal.SIGTERM)
    try:
        production.main()
    finally:
        signal.signal(signal.SIGTERM, before)
    assert Shape.ended == 1
