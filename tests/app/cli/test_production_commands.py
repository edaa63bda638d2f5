"""`macta worker` and `macta alive`: what they refuse, and what they know of a process that lives."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.cli.alive import fleet_alive, worker_alive
from app.cli.main import app
from app.domain.errors import Invalid, Unavailable
from app.settings import Settings
from app.store import Database
from app.workflows import PLANNING
from app.workflows.leases import ExecutorRegistry
from robots.link.mqtt import Broker, FleetLink
from robots.world import digest_of, load_world
from tests.app.undone import Noted
from tests.databases import ON_POSTGRESQL, postgresql
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.ports import free_port
from tests.waiting import until

SHARED = "postgresql+psycopg://macta:open-sesame@database.example:5432/macta"


def macta(*words: str) -> Result:
    return CliRunner().invoke(app, words)


def test_a_worker_without_anybody_to_plan_for_is_refused() -> None:
    done = macta("worker", "--broker", "mqtt://127.0.0.1")
    assert (done.exit_code, "MACTA_DATABASE_URL" in done.stderr) == (2, True)


@pytest.mark.parametrize(
    ("settings", "named"), [({}, "--broker"), ({"MACTA_PLANNING_PROCESSES": "0"}, "MACTA_PLANNING_PROCESSES")]
)
def test_a_worker_that_could_not_plan_is_refused(
    monkeypatch: pytest.MonkeyPatch, settings: dict[str, str], named: str
) -> None:
    for name, value in {"MACTA_DATABASE_URL": SHARED, **settings}.items():
        monkeypatch.setenv(name, value)
    done = macta("worker")
    assert (done.exit_code, named in done.stderr) == (2, True)
    assert "open-sesame" not in done.stderr


def without_database(command: Sequence[str], folder: Path) -> "subprocess.CompletedProcess[str]":
    """How the command ends whose database does not answer."""
    nobody = f"postgresql+psycopg://macta:open-sesame@127.0.0.1:{free_port()}/macta"
    given = {"DATABASE_URL": nobody, "TOKEN": "known-to-all-of-them", "DATA": str(folder)}
    return subprocess.run(
        [sys.executable, "-c", "from app.cli import main; main()", *command],
        env={**os.environ, **{f"MACTA_{name}": value for name, value in given.items()}},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize("command", [("worker",), ("serve", "--port", "0")])
def test_of_a_broker_that_lets_anybody_in_is_warned_in_a_line(command: Sequence[str], tmp_path: Path) -> None:
    done = without_database([*command, "--broker", "mqtt://broker.example"], tmp_path)
    told = [line for line in done.stderr.splitlines() if "accepts anonymous clients" in line]
    assert len(told) == 1, done.stderr


@pytest.mark.parametrize("command", [("worker", "--broker", "mqtt://127.0.0.1"), ("serve", "--port", "0")])
def test_a_database_that_does_not_answer_is_said_in_a_line(command: Sequence[str], tmp_path: Path) -> None:
    done = without_database(command, tmp_path)
    assert done.returncode == 2, done.stderr
    last = done.stderr.splitlines()[-1]
    assert last.startswith("macta: the database cannot be used: connection failed"), done.stderr
    assert "MACTA_DATABASE_URL" in last
    assert "open-sesame" not in done.stderr
    assert "Traceback" not in done.stderr


def test_a_record_that_others_share_wants_a_token_that_they_know() -> None:
    with pytest.raises(Invalid, match="MACTA_TOKEN"):
        Settings(database_url=SHARED).resolved_token()
    assert Settings(database_url=SHARED, token="known-to-all-of-them").resolved_token()


def test_where_the_record_is_printed_without_the_password() -> None:
    assert Settings(database_url=SHARED).database_location == "database macta on database.example"


@pytest.mark.parametrize(
    ("url", "why"),
    [
        ("", "set the PostgreSQL database"),
        ("sqlite:////folder/file", "set the PostgreSQL database"),
        ("mysql://macta:open-sesame@host/macta", "mysql is not supported"),
        (f"{SHARED}?bogus=1", 'invalid connection option "bogus"'),
    ],
)
def test_nothing_is_alive_where_nothing_is_shared(
    monkeypatch: pytest.MonkeyPatch, url: str, why: str
) -> None:
    monkeypatch.setenv("MACTA_DATABASE_URL", url)
    done = macta("alive", "worker")
    assert done.exit_code == 2
    assert done.stderr.startswith(f"macta: MACTA_DATABASE_URL: {why}")
    assert "open-sesame" not in done.stderr


@ON_POSTGRESQL
def test_a_worker_is_alive_while_it_says_so(database_url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with postgresql() as without_tables:
        monkeypatch.setenv("MACTA_DATABASE_URL", without_tables)
        with pytest.raises(Unavailable, match="does not answer"):
            worker_alive()
    monkeypatch.setenv("MACTA_DATABASE_URL", database_url)
    database = Database(database_url)
    with pytest.raises(Unavailable, match="no running planning process"):
        worker_alive()
    ExecutorRegistry(database, Noted("worker"), serves=[PLANNING.name], worlds=()).register()
    assert "plans" in worker_alive()
    database.close()


@needs_mosquitto
def test_a_fleet_is_alive_while_it_announces_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    world = load_world("sample_store")
    with mosquitto(tmp_path / "broker") as broker:
        monkeypatch.setenv("MACTA_BROKER_URL", broker.url)
        fleet = FleetLink(world.name, (), Broker.at(broker.url), run="a", digest=digest_of(world))
        fleet.start()
        until(lambda: fleet.connected, "the fleet is not connected")
        with announcing(fleet):
            assert "is running" in fleet_alive(world)
        monkeypatch.setattr("app.cli.alive.TIMEOUT_S", 2.0)
        with pytest.raises(Unavailable, match="does not announce itself"):
            fleet_alive(world)  # the broker has kept its last announcement, which says `online`
        fleet.close()


@contextmanager
def announcing(fleet: FleetLink) -> Iterator[None]:
    ending = threading.Event()

    def announce() -> None:
        while not ending.wait(0.1):
            fleet.announce(1.0, 1.0)

    thread = threading.Thread(target=announce)
    thread.start()
    try:
        yield
    finally:
        ending.set()
        thread.join()


@pytest.mark.parametrize("command", ["serve", "worker"])
def test_worlds_whose_robots_have_the_same_names_are_refused(command: str) -> None:
    done = macta(command, "--world", "sample_store", "--world", "sample_store_radio")
    assert (done.exit_code, "robot yard_1" in done.stderr) == (2, True)
