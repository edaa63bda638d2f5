"""The service, or a part of it, is killed in the middle of a mission; what goes on, and what is started again."""

import os
import signal
from pathlib import Path

import httpx2

from tests.scenarios.killing import kill_family, process_of_the_world
from tests.scenarios.serving import macta_serve
from tests.waiting import in_state, mission_of

SPEED = ("--speed", "8")


def begun(api: httpx2.Client) -> tuple[str, str]:
    """A mission that runs, and its goal."""
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()["id"]
    mission = mission_of(api, goal)
    in_state(api, f"/v1/missions/{mission}", "running")
    return mission, goal


def test_after_a_kill_the_world_its_missions_and_open_decisions_go_on(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with macta_serve(data, *SPEED) as first, first.client() as api:
        undecided = api.post("/v1/goals", json={"text": "move sample_2 to bay_3"}).json()["id"]
        plan = in_state(api, f"/v1/goals/{undecided}", "planned")["plan_id"]
        mission, goal = begun(api)
        time_s = api.get("/v1/worlds/sample_store").json()["time_s"]
        kill_family(first.process.pid)
        first.process.wait()

    with macta_serve(data, *SPEED) as second, second.client() as api:
        assert second.token == first.token
        assert api.get("/v1/worlds/sample_store").json()["time_s"] >= time_s
        assert api.get(f"/v1/missions/{mission}").json()["state"] == "running"
        assert api.get(f"/v1/plans/{plan}").json()["state"] == "proposed"
        os.kill(process_of_the_world(second.process.pid, data), signal.SIGKILL)  # the service itself lives on
        ended = in_state(api, f"/v1/missions/{mission}", "completed", "failed")
        assert ended["state"] == "completed", ended
        assert api.get(f"/v1/goals/{goal}").json()["outcome"] == "completed"
        facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
        assert any((one["predicate"], one["args"]) == ("in", ["sample_1", "bay_7"]) for one in facts)


def test_a_world_that_is_started_again_ends_what_ran_in_it_and_says_so(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with macta_serve(data) as first, first.client() as api:
        mission, goal = begun(api)

    with macta_serve(data, "--afresh") as second, second.client() as api:
        ended = api.get(f"/v1/missions/{mission}").json()
        assert (ended["state"], ended["failure"]) == ("failed", "world_changed")
        assert ended["reason"] == "the simulated world was started again: an operator wished it so"
        assert api.get(f"/v1/goals/{goal}").json()["state"] == "finished"
        facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
        assert any((one["predicate"], one["args"]) == ("in", ["sample_1", "door_1"]) for one in facts)
        second.process.send_signal(signal.SIGTERM)
        _, said = second.process.communicate()
        assert "World sample_store starts a new run: an operator wished it so." in said
