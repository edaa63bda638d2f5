"""The production shape: two APIs, two workers and a fleet, on PostgreSQL and Mosquitto; any of them may die at any
instant, the servers included. The broker is behind TLS, passwords and the access control list of the example.
"""

import random
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from app.cli.trials.observer import EventFollower
from examples.production import Shape
from tests.cluster import Cluster, own_cluster
from tests.mosquitto import ACL, Mosquitto, mosquitto, needs_mosquitto
from tests.papers import make_papers, passwords
from tests.scenarios.judge import judge, run_of
from tests.scenarios.shape import TOKEN, Production
from tests.scenarios.witness import Witness

SEED = 3
VICTIMS = ("api-1", "api-2", "worker-1", "fleet-1", "world", "database", "broker")
MOST_S = 3.0
"""At most so long between two kills."""
GOALS = {
    "one": "move sample_1 to bay_7",
    "two": "move sample_2 to bay_3",
    "three": "move sample_4 to door_2",
}


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    with own_cluster() as cluster:
        yield cluster


@pytest.fixture
def papers(tmp_path: Path) -> Path:
    folder = tmp_path / "papers"
    folder.mkdir()
    passwords(folder / "passwords", service=TOKEN, fleet=TOKEN[::-1])
    return make_papers(folder)


@pytest.fixture
def broker(tmp_path: Path, papers: Path) -> Iterator[Mosquitto]:
    tls = [f"{kind}file {papers / name}" for kind, name in (("cert", "broker.pem"), ("key", "broker.key"))]
    doors = ["allow_anonymous false", f"password_file {papers / 'passwords'}", f"acl_file {ACL}"]
    with mosquitto(tmp_path / "broker", *tls, *doors) as broker:
        yield broker


@pytest.fixture
def production(cluster: Cluster, broker: Mosquitto, papers: Path, tmp_path: Path) -> Iterator[Production]:
    given = {
        "MACTA_TOKEN": TOKEN,
        "MACTA_DATABASE_HOST": "127.0.0.1",
        "MACTA_DATABASE_PORT": str(cluster.port),
        "MACTA_DATABASE_USER": "postgres",
        "MACTA_DATABASE_PASSWORD": "unused",
        "MACTA_DATABASE_NAME": "postgres",
        "MACTA_BROKER_URL": broker.url.replace("mqtt://", "mqtts://"),
        "MACTA_SERVICE_PASSWORD": TOKEN,
        "MACTA_FLEET_PASSWORD": TOKEN[::-1],
        "MACTA_BROKER_CA": str(papers / "ca.pem"),
        "MACTA_PLANNING_PROCESSES": "1",
        "MACTA_SPEED": "12",
    }
    production = Production(Shape(tmp_path, given), cluster, broker, tmp_path)
    with production.run():
        yield production


@needs_mosquitto
@pytest.mark.timeout(900)
def test_a_storm_over_every_process_loses_nothing_and_does_nothing_twice(
    production: Production, tmp_path: Path
) -> None:
    seen = Witness(GOALS, by_hand=frozenset({"three"}))
    # The services may be ready before the fleet has announced the world's run.
    production.through_any(
        lambda api, _: seen.state_goals(api),
        lambda: len(seen.accepted) < len(GOALS) or not run_of(production.database_url),
    )
    run = run_of(production.database_url)
    follower = EventFollower(production.api)
    with follower.following(), ThreadPoolExecutor(1) as thread:
        storm = thread.submit(production.kill_all, VICTIMS, random.Random(SEED), MOST_S)
        production.through_any(seen.look, lambda: not (seen.over and storm.done()))
        storm.result()
        events = production.events()
        production.through_any(seen.look, lambda: len(follower.seen) < len(events))
        assert follower.seen[: len(events)] == events == sorted(set(events))
    production.end()

    judge(seen, data=tmp_path / "fleet-1", database_url=production.database_url)
    assert [goal["outcome"] for goal in seen.final] == ["completed"] * len(GOALS), seen.final
    assert run_of(production.database_url) == run, "the world started a new run"
