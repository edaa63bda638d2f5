"""A sample deposited at a doorway (MACTA §5): a robot sees it, it becomes known, and it is stored."""

from pathlib import Path

from fastapi.testclient import TestClient

from app.planning.pool.pool import PlanningWorker
from robots.world import WorldFile, load_world
from tests.scenarios.services import AUTHORISED, over_pipe
from tests.waiting import in_state, read_until

WORLD = "/v1/worlds/sample_store"


def stated(api: TestClient, text: str) -> str:
    body = {"text": text, "auto_approve": True, "effort_s": 0}
    return f"/v1/goals/{api.post('/v1/goals', json=body).raise_for_status().json()['id']}"


def test_a_sample_deposited_at_a_doorway_is_known_once_a_robot_sees_it_and_is_then_stored(
    worker: PlanningWorker, tmp_path: Path
) -> None:
    store = load_world("sample_store").model_dump()
    delivery = {"name": "sample_9", "at": "door_2", "after_s": 3.0}
    file = WorldFile.model_validate({**store, "deliveries": [delivery]})
    with (
        over_pipe(tmp_path, worker, speed=None, world=file) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
    ):
        read_until(api, WORLD, lambda world: world["time_s"] > 6)
        facts = service.worlds.facts("sample_store")[0]
        assert not any("sample_9" in args for (_, args), _ in facts)  # it lies there, and nobody has seen it
        first = stated(api, "move sample_1 to bay_1 with yard_2 and store_1")
        seen = read_until(api, f"{WORLD}/changes", lambda changes: changes["items"])["items"][0]
        assert seen["actor"] in {"yard_1", "yard_2"}
        (source,) = (
            row.source
            for relation, row in service.worlds.facts("sample_store")[0]
            if relation == ("in", ("sample_9", "door_2"))
        )
        assert source == f"report of {seen['actor']}"
        in_state(api, first, "finished", within_s=120)
        ended = in_state(api, stated(api, "store sample_9 in bay_12"), "finished", "unsolvable", within_s=120)
        assert ended["outcome"] == "completed", ended["reason"]
        world = api.get(WORLD).json()
        assert world["edition"] == 1
        assert "sample_9" in {sample["name"] for sample in world["layout"]["samples"]}
