"""The service, or a part of it, is killed in the middle of a mission; what goes on, and what is begun afresh."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx2

from tests.scenarios.serving import Served, macta_serve
from tests.scenarios.storm import family, kill_family

GIVE_UP_S = 300.0
SPEED = ("--speed", "4")


def client(served: Served) -> httpx2.Client:
    return httpx2.Client(
        base_url=served.address, headers={"authorization": f"Bearer {served.token}"}, timeout=20
    )


def until(read: Callable[[], dict[str, Any]], *states: str) -> dict[str, Any]:
    give_up = time.monotonic() + GIVE_UP_S
    while (thing := read())["state"] not in states:
        assert time.monotonic() < give_up, thing
        time.sleep(0.05)
    return thing


def begun(api: httpx2.Client) -> tuple[str, str]:
    """A mission that runs, and its goal."""
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()["id"]
    mission = until(lambda: api.get(f"/v1/goals/{goal}").json(), "committed")["mission_id"]
    until(lambda: api.get(f"/v1/missions/{mission}").json(), "running")
    return mission, goal


def process_of_the_world(served: Served, data: Path) -> int:
    """The one that has the world's lock open."""
    lock = data / "worlds" / "sample_store.lock"
    for pid in family(served.process.pid):
        opened = [Path(f"/proc/{pid}/fd/{name}") for name in os.listdir(f"/proc/{pid}/fd")]
        if any(os.path.exists(one) and one.resolve() == lock for one in opened):
            return pid
    raise AssertionError("no process keeps the world")


def test_after_a_kill_the_world_its_missions_and_open_decisions_go_on(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with macta_serve(data, *SPEED) as first, client(first) as api:
        mission, goal = begun(api)
        undecided = api.post("/v1/goals", json={"text": "move sample_2 to bay_3"}).json()["id"]
        plan = until(lambda: api.get(f"/v1/goals/{undecided}").json(), "planned")["plan_id"]
        time_s = api.get("/v1/worlds/sample_store").json()["time_s"]
        kill_family(first.process.pid)
        first.process.wait()

    with macta_serve(data, *SPEED) as second, client(second) as api:
        assert second.token == first.token
        assert api.get("/v1/worlds/sample_store").json()["time_s"] >= time_s
        assert api.get(f"/v1/missions/{mission}").json()["state"] == "running"
        assert api.get(f"/v1/plans/{plan}").json()["state"] == "proposed"
        os.kill(process_of_the_world(second, data), signal.SIGKILL)  # the service itself lives on
        ended = until(lambda: api.get(f"/v1/missions/{mission}").json(), "completed", "failed")
        assert ended["state"] == "completed", ended
        assert api.get(f"/v1/goals/{goal}").json()["outcome"] == "completed"
        facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
        assert any((one["predicate"], one["args"]) == ("in", ["sample_1", "bay_7"]) for one in facts)


def test_a_world_that_is_begun_afresh_ends_what_ran_in_it_and_says_so(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with macta_serve(data) as first, client(first) as api:
        mission, goal = begun(api)

    with macta_serve(data, "--afresh") as second, client(second) as api:
        ended = api.get(f"/v1/missions/{mission}").json()
        assert (ended["state"], ended["failure"]) == ("failed", "world_changed")
        assert ended["reason"] == "the simulated world was started afresh: an operator wished it so"
        assert api.get(f"/v1/goals/{goal}").json()["state"] == "finished"
        facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
        assert any((one["predicate"], one["args"]) == ("in", ["sample_1", "door_1"]) for one in facts)
        second.process.send_signal(signal.SIGTERM)
        _, said = second.process.communicate()
        assert "World sample_store begins afresh: an operator wished it so." in said
