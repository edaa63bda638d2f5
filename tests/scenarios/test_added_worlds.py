"""A world is added to a running service with simulations of its own, survives a kill, and is removed."""

from pathlib import Path

from app.planning.pool.process_tree import tree_of
from tests.app.world_hosts import hall
from tests.scenarios.killing import kill_family
from tests.scenarios.serving import macta_serve
from tests.waiting import in_state, mission_of, read_until

SPEED = ("--speed", "8")
WORLD = "/v1/worlds/hall"
KEPT = {"sample_store.json", "sample_store.clock", "sample_store.lock"}


def holders(pid: int, file: Path) -> set[int]:
    """Of a process's family, those that have a file open."""
    return {
        one.pid
        for one in tree_of(pid)
        if any(link.resolve() == file.resolve() for link in Path(f"/proc/{one.pid}/fd").iterdir())
    }


def test_an_added_world_is_simulated_resumed_after_a_kill_and_ends_when_it_is_removed(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with macta_serve(data, *SPEED) as first, first.client() as api:
        api.post("/v1/worlds", json=hall("hall").model_dump(mode="json")).raise_for_status()
        body = {"text": "move sample_1 to bay_7", "world": "hall", "auto_approve": True}
        goal = api.post("/v1/goals", json=body).raise_for_status().json()["id"]
        mission = mission_of(api, goal)
        in_state(api, f"/v1/missions/{mission}", "running")
        read_until(api, "/v1/robots/hall_yard_1", lambda robot: robot["pose"])
        time_s = api.get(WORLD).json()["time_s"]
        kill_family(first.process.pid)
        first.process.wait()

    with macta_serve(data, *SPEED) as second, second.client() as api:
        assert api.get(WORLD).json()["time_s"] >= time_s  # also before it is built again
        read_until(api, WORLD, lambda world: world["status"] == "running")
        assert api.get(WORLD).json()["time_s"] >= time_s
        assert in_state(api, f"/v1/missions/{mission}", "completed", "failed")["state"] == "completed"
        (simulating,) = holders(second.process.pid, data / "worlds" / "hall.lock")
        assert api.delete(WORLD).status_code == 204
        assert simulating not in {one.pid for one in tree_of(second.process.pid)}
        # The other world goes on, and is written beside its last snapshot now and then.
        assert {path.name for path in (data / "worlds").iterdir()} - {"sample_store.new"} == KEPT
        assert [one["id"] for one in api.get("/v1/worlds").json()["items"]] == ["sample_store"]
