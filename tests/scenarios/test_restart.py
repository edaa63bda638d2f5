"""The service is killed in the middle of a mission and started again on the same record."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx2

from tests.scenarios.serving import Served, macta_serve

GIVE_UP_S = 40.0


def client(served: Served) -> httpx2.Client:
    return httpx2.Client(
        base_url=served.address, headers={"authorization": f"Bearer {served.token}"}, timeout=10
    )


def until(read: Callable[[], dict[str, Any]], *states: str) -> dict[str, Any]:
    give_up = time.monotonic() + GIVE_UP_S
    while (thing := read())["state"] not in states:
        assert time.monotonic() < give_up, thing
        time.sleep(0.05)
    return thing


def test_after_a_kill_every_mission_and_goal_has_a_truthful_state(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with macta_serve(data) as first, client(first) as api:
        running = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
        mission_id = until(lambda: api.get(f"/v1/goals/{running['id']}").json(), "committed")["mission_id"]
        until(lambda: api.get(f"/v1/missions/{mission_id}").json(), "running")
        undecided = api.post("/v1/goals", json={"text": "move sample_2 to bay_3"}).json()
        old_plan = until(lambda: api.get(f"/v1/goals/{undecided['id']}").json(), "planned")["plan_id"]
        first.process.kill()
        first.process.wait()

    with macta_serve(data) as second, client(second) as api:
        assert second.token == first.token
        mission = api.get(f"/v1/missions/{mission_id}").json()
        assert (mission["state"], mission["failure"]) == ("failed", "world_changed")
        assert "started afresh" in mission["reason"]
        assert api.get(f"/v1/goals/{running['id']}").json()["state"] == "finished"
        facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
        assert {"predicate": "in", "args": ["sample_1", "door_1"]}.items() <= next(
            fact for fact in facts if fact["args"][0] == "sample_1"
        ).items()

        again = until(lambda: api.get(f"/v1/goals/{undecided['id']}").json(), "planned")
        assert again["plan_id"] != old_plan
        assert api.get(f"/v1/plans/{old_plan}").json()["state"] == "expired"
        assert api.post(f"/v1/plans/{again['plan_id']}:approve").status_code == 202
