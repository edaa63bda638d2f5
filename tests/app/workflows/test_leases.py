"""Several processes on one database: which of them live, which hold a world's lease, which recover from the dead."""

from collections.abc import Callable, Iterator
from math import inf

import pytest
from sqlalchemy import update

from app.domain.errors import Unavailable
from app.store import Database, ExecutorRow
from app.workflows.leases import DEAD_AFTER_S, LEASE_S, ExecutorRegistry
from tests.app.stepped_clock import SteppedClock
from tests.app.undone import Noted
from tests.databases import ON_BOTH, ON_POSTGRESQL, SQLITE

Join = Callable[..., ExecutorRegistry]


@pytest.fixture
def recovered() -> list[tuple[str, str]]:
    """Who recovered from whom."""
    return []


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock()


@pytest.fixture
def join(database: Database, recovered: list[tuple[str, str]], clock: SteppedClock) -> Iterator[Join]:
    """A process joins those on the database; it beats and recovers when told to, or by itself after `start`."""
    joined: list[ExecutorRegistry] = []

    def of(name: str, *, worlds: tuple[str, ...] = ("store",)) -> ExecutorRegistry:
        registry = ExecutorRegistry(
            database, Noted(name, recovered), serves=["missions"], worlds=worlds, clock=clock
        )
        registry.register()
        joined.append(registry)
        return registry

    yield of
    for registry in joined:
        registry.close()


def silence(database: Database, name: str) -> None:
    """A process has not been heard of for as long as a dead one."""
    with database.write() as session:
        session.execute(
            update(ExecutorRow)
            .where(ExecutorRow.id == name)
            .values(seen_at=ExecutorRow.seen_at - DEAD_AFTER_S)
        )


@ON_POSTGRESQL
def test_one_process_holds_a_worlds_lease_until_it_dies(join: Join, database: Database) -> None:
    first, second = join("first"), join("second")
    assert (first.holds_lease("store"), second.holds_lease("store")) == (True, False)
    second.beat()
    assert not second.holds_lease("store")
    silence(database, "first")
    second.beat()
    assert second.holds_lease("store")


@ON_POSTGRESQL
def test_a_process_that_ends_hands_over_at_once(join: Join, recovered: list[tuple[str, str]]) -> None:
    first, second = join("first"), join("second")
    first.start()
    first.close()
    second.beat()
    second.recover()
    assert second.holds_lease("store")
    assert ("second", "first") in recovered
    assert [one.id for one in second.executors() if one.alive] == ["second"]


@ON_POSTGRESQL
def test_a_dead_process_is_recovered_from_and_a_living_one_is_not(
    join: Join, database: Database, recovered: list[tuple[str, str]]
) -> None:
    join("dead")
    living, third = join("living"), join("third")
    silence(database, "dead")
    living.recover()
    third.recover()
    assert {dead for _, dead in recovered} == {"dead"}


@ON_POSTGRESQL
def test_a_process_whose_heartbeats_fail_lets_its_leases_lapse(join: Join, clock: SteppedClock) -> None:
    held_up = join("held_up")
    clock.advance(LEASE_S - 0.1)
    assert held_up.holds_lease("store")
    clock.advance(0.2)
    assert not held_up.holds_lease("store")


@ON_BOTH
def test_workflows_are_dequeued_only_while_the_others_count_on_a_process(
    database: Database, clock: SteppedClock
) -> None:
    workflows = Noted("first")
    ExecutorRegistry(database, workflows, serves=["missions"], worlds=(), clock=clock).register()
    assert workflows.dequeues_until == (clock.monotonic_s() + LEASE_S if database.shared else inf)


@ON_POSTGRESQL
def test_executors_are_known_with_what_they_serve_and_whether_they_live(
    join: Join, database: Database
) -> None:
    registry = join("api")
    join("gone", worlds=())
    silence(database, "gone")
    known = {one.id: one for one in registry.executors()}
    assert known["api"].alive
    assert (known["api"].serves, known["api"].worlds) == (["missions"], ["store"])
    assert not known["gone"].alive
    assert known["gone"].seen_s >= DEAD_AFTER_S


@pytest.mark.parametrize("database_url", [SQLITE], indirect=True)
def test_on_sqlite_the_one_process_always_holds_its_leases(join: Join, database: Database) -> None:
    registry = join("embedded")
    silence(database, "embedded")
    assert registry.holds_lease("store")
    assert not registry.holds_lease("another")
    assert [one.alive for one in registry.executors()] == [True]


@ON_POSTGRESQL
def test_a_world_that_is_simulated_here_is_refused_while_another_process_has_it(
    join: Join, database: Database, clock: SteppedClock
) -> None:
    first, second = join("first"), join("second")
    began_s = clock.monotonic_s()
    with pytest.raises(Unavailable, match="world store"):
        second.register(["store"])
    assert clock.monotonic_s() - began_s > DEAD_AFTER_S
    silence(database, "first")
    second.register(["store"])
    assert second.holds_lease("store")
    assert first.executors()[0].worlds == ()
