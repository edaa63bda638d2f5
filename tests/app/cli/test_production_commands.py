"""`macta worker` and `macta alive`: what they refuse, and what they know of a process that lives."""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.cli.alive import worker_alive
from app.cli.main import app
from app.domain.errors import Invalid, Unavailable
from app.settings import Settings
from app.store import Database
from app.workflows import PLANNING
from app.workflows.leases import ExecutorRegistry
from tests.app.undone import Noted
from tests.databases import ON_POSTGRESQL, postgresql
from tests.ports import free_port

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


def test_nothing_is_alive_where_nothing_is_shared() -> None:
    done = macta("alive", "worker")
    assert (done.exit_code, "MACTA_DATABASE_URL" in done.stderr) == (2, True)


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


@pytest.mark.parametrize("command", ["serve", "worker"])
def test_worlds_whose_robots_have_the_same_names_are_refused(command: str) -> None:
    done = macta(command, "--world", "sample_store", "--world", "sample_store_radio")
    assert (done.exit_code, "robot yard_1" in done.stderr) == (2, True)
