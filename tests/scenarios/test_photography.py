"""The example package on an unpatched `macta serve`: a sentence with its verb is planned, approved and carried out."""

import os
from pathlib import Path
from typing import Any

import httpx2
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
        facts = api.get("/v1/worlds/studio/facts").json()["items"]
        pictures = [fact for fact in facts if fact["predicate"] == "photographed"]
        assert [fact["args"] for fact in pictures] == [["bay_4"]]
        restated = api.post("/v1/goals", json=stated).raise_for_status().json()
        assert plan_of(api, restated)["actions"] == [], "it is true already"
        retracted = {"predicate": "photographed", "args": ["bay_4"], "value": False}
        api.put("/v1/worlds/studio/facts", json={"facts": [retracted]}).raise_for_status()
        restated = api.post("/v1/goals", json=stated).raise_for_status().json()
        assert [action["tag"] for action in plan_of(api, restated)["actions"]] == ["PHOTOGRAPH"]
