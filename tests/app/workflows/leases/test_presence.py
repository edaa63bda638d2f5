"""Several processes on one database: who lives, who speaks for a world, who takes over."""

import time
from collections.abc import Callable, Iterator
from math import inf

import pytest
from sqlalchemy import update

from app.domain.errors import Unavailable
from app.store import Database, ExecutorRow
from app.workflows.leases import DEAD_AFTER_S, HELD_S, ExecutorRegistry
from tests.app.undone import Noted
from tests.databases import ON_BOTH, ON_POSTGRESQL, SQLITE
from tests.waiting import until

Join = Callable[..., ExecutorRegistry]


@pytest.fixture
def taken_over() -> list[tuple[str, str]]:
    """Who took over from whom."""
    return []


@pytest.fixture
def join(database: Database, taken_over: list[tuple[str, str]]) -> Iterator[Join]:
    """A process joins those on the database; it begins to beat with `start`."""
    joined: list[ExecutorRegistry] = []

    def of(name: str, *, worlds: tuple[str, ...] = ("store",)) -> ExecutorRegistry:
        presence = ExecutorRegistry(database, Noted(name, taken_over), serves=["missions"], speaks_for=worlds)
        presence.register()
        joined.append(presence)
        return presence

    yield of
    for presence in joined:
        presence.close()


def silence(database: Database, name: str) -> None:
    """A process has not been heard of for as long as a dead one."""
    with database.write() as session:
        session.execute(
            update(ExecutorRow)
            .where(ExecutorRow.id == name)
            .values(seen_at=ExecutorRow.seen_at - DEAD_AFTER_S)
        )


@ON_POSTGRESQL
def test_one_process_speaks_for_a_world_until_it_dies(join: Join, database: Database) -> None:
    first, second = join("first"), join("second")
    assert (first.speaks_for("store"), second.speaks_for("store")) == (True, False)
    silence(database, "first")
    second.start()
    until(lambda: second.speaks_for("store"))


@ON_POSTGRESQL
def test_a_process_that_ends_hands_over_at_once(join: Join, taken_over: list[tuple[str, str]]) -> None:
    first, second = join("first"), join("second")
    first.start()
    first.close()
    second.start()
    until(lambda: second.speaks_for("store") and ("second", "first") in taken_over)
    assert [one.id for one in second.executors() if one.alive] == ["second"]


@ON_POSTGRESQL
def test_a_dead_process_is_taken_over_from_and_a_living_one_is_not(
    join: Join, database: Database, taken_over: list[tuple[str, str]]
) -> None:
    join("dead")
    living, third = join("living"), join("third")
    silence(database, "dead")
    living.start()
    third.start()
    until(lambda: bool(taken_over))
    assert {dead for _, dead in taken_over} == {"dead"}


@ON_POSTGRESQL
def test_a_process_that_cannot_say_that_it_lives_lays_its_worlds_down(
    join: Join, database: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    held_up = join("held_up")
    now = time.monotonic()
    monkeypatch.setattr("app.workflows.leases.time.monotonic", lambda: now + DEAD_AFTER_S)
    assert not held_up.speaks_for("store")


@ON_BOTH
def test_workflows_are_begun_only_while_the_others_count_on_a_process(database: Database) -> None:
    workflows = Noted("first")
    began = time.monotonic()
    ExecutorRegistry(database, workflows, serves=["missions"], speaks_for=()).register()
    if database.shared:
        assert began + HELD_S <= workflows.begins_until <= time.monotonic() + HELD_S
    else:
        assert workflows.begins_until == inf


@ON_POSTGRESQL
def test_executors_are_known_with_what_they_serve_and_whether_they_live(
    join: Join, database: Database
) -> None:
    presence = join("api")
    join("gone", worlds=())
    silence(database, "gone")
    known = {one.id: one for one in presence.executors()}
    assert known["api"].alive
    assert (known["api"].serves, known["api"].worlds) == (["missions"], ["store"])
    assert not known["gone"].alive
    assert known["gone"].seen_s >= DEAD_AFTER_S


@pytest.mark.parametrize("database_url", [SQLITE], indirect=True)
def test_on_sqlite_the_one_process_always_speaks_for_its_worlds(join: Join, database: Database) -> None:
    presence = join("embedded")
    silence(database, "embedded")
    assert presence.speaks_for("store")
    assert not presence.speaks_for("another")
    assert [one.alive for one in presence.executors()] == [True]


@ON_POSTGRESQL
def test_a_world_that_is_simulated_here_is_refused_while_another_process_has_it(
    join: Join, database: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.workflows.leases.DEAD_AFTER_S", 1.0)
    monkeypatch.setattr("app.workflows.leases.BEAT_S", 0.2)
    first, second = join("first"), join("second")
    first.start()
    with pytest.raises(Unavailable, match="world store"):
        second.register(["store"])
    first.close()
    second.register(["store"])
    assert second.speaks_for("store")
