"""The broker of docker-compose.yml, started by its script, with configuration and access control list as shipped."""

import getpass
import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest
from pydantic import SecretStr

from app.cli.broker_files import BrokerFiles
from examples.production import COMPOSE
from robots.link.mqtt import Broker
from tests.mosquitto import needs_mosquitto
from tests.ports import free_port
from tests.robots.link.mqtt.ends import RUN, a_fleet, a_service
from tests.waiting import until

EXAMPLES = COMPOSE.parent / "examples"
SECRETS = {"MACTA_SERVICE_PASSWORD": "sword fish", "MACTA_FLEET_PASSWORD": "trout%1$s"}


def environment(given: Mapping[str, str]) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if not name.startswith("MACTA_")}
    return {**kept, **given}


def command(folder: Path) -> list[str]:
    return ["sh", str(EXAMPLES / "start_broker.sh"), str(folder)]


@contextmanager
def started(folder: Path, robots: str = "fred:kipper\n") -> Iterator[int]:
    """The broker as shipped, but for its port; answers that. `robots`: with passwords; empty: no such file."""
    port = free_port()
    config = folder / "config"
    config.mkdir(exist_ok=True)
    shutil.copy(EXAMPLES / "mosquitto.acl", config)
    if robots:
        (config / "robots").write_text(robots)
    shipped = (EXAMPLES / "mosquitto.conf").read_text()
    assert "\nlistener 1883\n" in shipped
    # NOTE: started as root it would become a user who cannot read the test's files.
    own = shipped.replace("\nlistener 1883\n", f"\nlistener {port} 127.0.0.1\nuser {getpass.getuser()}\n")
    (config / "mosquitto.conf").write_text(own)
    with (folder / "log").open("wb") as log:
        process = subprocess.Popen(command(folder), env=environment(SECRETS), stdout=log, stderr=log)
    try:
        yield port
    finally:
        process.terminate()
        process.wait(20)


@needs_mosquitto
def test_the_shipped_broker_lets_in_who_is_known_and_nobody_else(tmp_path: Path) -> None:
    with started(tmp_path) as port:

        def known_as(user: str | None, password: str | None) -> Broker:
            secret = None if password is None else SecretStr(password)
            return Broker.at(f"mqtt://127.0.0.1:{port}", username=user, password=secret)

        service = known_as("service", SECRETS["MACTA_SERVICE_PASSWORD"])
        fleet = known_as("fleet", SECRETS["MACTA_FLEET_PASSWORD"])
        with a_service(service) as there, a_fleet(fleet):
            until(lambda: there.run == RUN, (tmp_path / "log").read_text())
        with a_service(known_as("fred", "kipper")) as robot:
            until(lambda: robot.connected)
        for stranger in (known_as(None, None), known_as("service", "trout"), known_as("ginger", "kipper")):
            with a_service(stranger) as outside:
                until(lambda link=outside: "does not let" in link.complaint)  # type: ignore[misc]
                assert not outside.connected
    assert (tmp_path / "data" / "passwords").stat().st_mode & 0o077 == 0
    kept = (tmp_path / "data" / "passwords").read_text()
    assert not any(secret in kept for secret in (*SECRETS.values(), "kipper")), (
        "passwords are kept as digests"
    )


@needs_mosquitto
def test_the_shipped_broker_keeps_enrolled_robots_over_a_restart(tmp_path: Path) -> None:
    kept = BrokerFiles(tmp_path / "data")
    secrets = {name: kept.enrol(name, world="hall").password for name in ("ginger", "basil")}
    kept.revoke("basil")
    for _ in range(2):
        with started(tmp_path, robots="") as port:
            for name, lets_in in (("ginger", True), ("basil", False)):
                broker = Broker.at(
                    f"mqtt://127.0.0.1:{port}", username=name, password=SecretStr(secrets[name])
                )
                with a_service(broker) as robot:
                    # Before the broker listens, the link complains that it cannot be reached.
                    until(lambda link=robot: link.connected or "does not let" in link.complaint)  # type: ignore[misc]
                    assert robot.connected == lets_in
        access = (tmp_path / "data" / "acl").read_text()
        assert access.count("user ginger") == access.count("user service") == 1
        assert "\npattern " not in access, "a name alone gives no rights"


@pytest.mark.parametrize("missing", sorted(SECRETS))
def test_a_password_that_is_missing_or_cannot_be_kept_is_named(tmp_path: Path, missing: str) -> None:
    for given in ({}, {missing: "with:colon"}):
        secrets = {name: value for name, value in SECRETS.items() if name != missing} | given
        ended = subprocess.run(
            command(tmp_path), env=environment(secrets), capture_output=True, text=True, check=False
        )
        assert ended.returncode != 0
        assert missing in ended.stderr
        assert not (tmp_path / "data").exists()


def test_compose_gives_the_broker_what_its_script_reads() -> None:
    """The files that the configuration and the script name are mounted where they are looked for."""
    compose = COMPOSE.read_text()
    for name in ("mosquitto.conf", "mosquitto.acl", "start_broker.sh"):
        assert f'"./examples/{name}:/mosquitto/config/{name}:ro"' in compose
