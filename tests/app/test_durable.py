"""Durable workflows: begun when the transaction that starts them commits."""

from collections.abc import Iterator
from queue import Empty, Queue

import pytest

from app.database import Database
from app.database.migrate import migrate
from app.durable import MISSIONS, PLANNING, Workflows
from app.durable import Queue as WorkflowQueue
from tests.databases import ON_BOTH

pytestmark = ON_BOTH
HARDLY_EVER_S = 3600.0


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    database = Database(database_url)
    migrate(database)
    yield database
    database.close()


@pytest.fixture
def carried_out() -> Queue[str]:
    return Queue()


@pytest.fixture
def workflows(database: Database, carried_out: Queue[str]) -> Iterator[Workflows]:
    """Workflows that are hardly ever looked for."""
    workflows = Workflows(database.url, queue_polling_s=HARDLY_EVER_S)
    workflows.register("note", carried_out.put)
    workflows.launch()
    yield workflows
    workflows.close()


@pytest.mark.parametrize("queue", [PLANNING, MISSIONS])
def test_a_workflow_begins_when_its_transaction_commits_and_not_with_the_next_look(
    database: Database, workflows: Workflows, carried_out: Queue[str], queue: WorkflowQueue
) -> None:
    with database.write() as session:
        workflows.start(session, queue, "note", "first", "one")
    assert carried_out.get(timeout=30) == "one"
    with database.write() as session:
        workflows.start(session, queue, "note", "second", "another")
    assert carried_out.get(timeout=30) == "another"


def test_a_workflow_of_a_transaction_that_fails_never_begins(
    database: Database, workflows: Workflows, carried_out: Queue[str]
) -> None:
    def fail() -> None:
        with database.write() as session:
            workflows.start(session, PLANNING, "note", "never", "nothing")
            raise LookupError

    with pytest.raises(LookupError):
        fail()
    with database.write() as session:
        workflows.start(session, PLANNING, "note", "after", "something")
    assert carried_out.get(timeout=30) == "something"
    with pytest.raises(Empty):
        carried_out.get_nowait()
