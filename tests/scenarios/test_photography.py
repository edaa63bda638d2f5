"""The example package on an unpatched `macta serve`: a sentence with its verb is planned, approved and carried out."""

import os
import zlib
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest

from tests.packages import write_project
from tests.scenarios.serving import macta_serve
from tests.waiting import in_state

PROJECT = Path(__file__).parents[2] / "examples" / "photography"
STUDIO = ("--pack", "photography", "--world", "studio", "--speed", "8")


def plan_of(api: httpx2.Client, goal: dict[str, Any]) -> dict[str, Any]:
    """The plan that is proposed for a goal."""
    planned = in_state(api, f"/v1/goals/{goal['id']}", "planned", "failed")
    assert planned["state"] == "planned", planned["reason"]
    plan: dict[str, Any] = api.get(f"/v1/plans/{planned['plan_id']}").json()
    return plan


def test_a_place_is_photographed_by_what_a_package_adds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    site = write_project(tmp_path / "site", PROJECT)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(site), os.getcwd()]))
    with macta_serve(tmp_path / "data", *STUDIO) as served, served.client() as api:
        packs = {pack["name"]: pack for pack in api.get("/v1/packs").json()["items"]}
        assert packs["photography"]["actions"] == ["PHOTOGRAPH"]
        stated = {"text": "photograph bay_4"}
        goal = api.post("/v1/goals", json=stated).raise_for_status().json()
        assert goal["goal"] == [{"predicate": "photographed", "args": ["bay_4"]}]
        plan = plan_of(api, goal)
        tags = [(action["tag"], action["agents"]) for action in plan["actions"]]
        assert tags == [("NAVIGATE", ["camera"]), ("PHOTOGRAPH", ["camera"])]
        approved = api.post(f"/v1/plans/{plan['id']}:approve", json={}).raise_for_status().json()
        mission = in_state(api, f"/v1/missions/{approved['mission_id']}", "completed", "failed", "cancelled")
        assert mission["state"] == "completed", mission["reason"]
        path = f"/v1/missions/{mission['id']}/results"
        results = {one["kind"]: one for one in api.get(path).json()["items"]}
        assert {(one["of"], one["robot"]) for one in results.values()} == {("bay_4", "camera")}
        image = api.get(f"{path}/{results['image']['id']}")
        assert image.headers["content-type"] == "image/png"
        assert results["image"]["size_bytes"] == len(image.content)
        assert beacon_red(image.content) > 20, "the robot looks at the beacon of bay_4"
        assert results["reading"]["value"] > 50
        restated = api.post("/v1/goals", json=stated).raise_for_status().json()
        again = [action["tag"] for action in plan_of(api, restated)["actions"]]
        assert again == ["PHOTOGRAPH"], "it was photographed, and is to be once more"
        plan_id = in_state(api, f"/v1/goals/{restated['id']}", "planned")["plan_id"]
        approved = api.post(f"/v1/plans/{plan_id}:approve", json={}).raise_for_status().json()
        second = in_state(api, f"/v1/missions/{approved['mission_id']}", "completed", "failed", "cancelled")
        assert second["state"] == "completed", second["reason"]
        assert second["results"] == 2
        pictures = [
            fact
            for fact in api.get("/v1/worlds/studio/facts").json()["items"]
            if fact["predicate"] == "photographed"
        ]
        assert [fact["args"] for fact in pictures] == [["bay_4"]]
        assert pictures[0]["at_s"] > second["started_at_s"]


def beacon_red(png: bytes) -> int:
    """How many pixels of an image are red."""
    width = int.from_bytes(png[16:20], "big")
    size = int.from_bytes(png[33:37], "big")
    rows = np.frombuffer(zlib.decompress(png[41 : 41 + size]), np.uint8).reshape(-1, 1 + 3 * width)
    pixels = rows[:, 1:].reshape(-1, 3).astype(int)
    return int(((pixels[:, 0] > 2 * pixels[:, 1]) & (pixels[:, 0] > 2 * pixels[:, 2])).sum())
