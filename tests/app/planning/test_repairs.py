"""A plan that the world has overtaken is repaired: the new one says what it differs in."""

from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient

Follow = Callable[..., dict[str, Any]]
GOALS = {"text": "move sample_1 to bay_7 and sample_2 to bay_4"}


def planned(api: TestClient, follow: Follow) -> dict[str, Any]:
    answer = api.post("/v1/goals", json=GOALS)
    assert answer.status_code == 202, answer.text
    goal = follow(f"/v1/goals/{answer.json()['id']}", "planned")
    plan: dict[str, Any] = api.get(f"/v1/plans/{goal['plan_id']}").json()
    return plan


def move(api: TestClient, sample: str, place: str) -> None:
    body = {"facts": [{"predicate": "in", "args": [sample, place]}]}
    assert api.put("/v1/worlds/sample_store/facts", json=body).status_code == 200


def with_sample(plan: dict[str, Any], sample: str) -> set[str]:
    return {action["id"] for action in plan["actions"] if action["arguments"].get("object") == sample}


def test_a_plan_made_for_the_first_time_repairs_none(api: TestClient, follow: Follow) -> None:
    assert planned(api, follow)["repairs"] is None


def test_an_overtaken_plan_is_repaired_and_the_rest_of_it_kept(api: TestClient, follow: Follow) -> None:
    old = planned(api, follow)
    assert api.get(f"/v1/plans/{old['id']}").json()["overtaken"] == []
    move(api, "sample_1", "interchange_2")
    overtaken = api.get(f"/v1/plans/{old['id']}").json()["overtaken"]
    assert overtaken[0].startswith(
        "in(sample_1, door_1) is no longer true: now in(sample_1, interchange_2), operator"
    )
    refused = api.post(f"/v1/plans/{old['id']}:approve")
    assert refused.status_code == 409
    assert refused.json()["type"] == "urn:macta:problem:plan-stale"
    goal = follow(f"/v1/goals/{old['goal_id']}", "planned")
    new = api.get(f"/v1/plans/{goal['plan_id']}").json()
    assert new["id"] != old["id"]
    assert new["overtaken"] == []
    assert (
        api.get(f"/v1/plans/{old['id']}")
        .json()["reason"]
        .startswith("in(sample_1, door_1) is no longer true: ")
    )
    repairs = new["repairs"]
    assert repairs["plan_id"] == old["id"]
    assert repairs["course"] in ("mended", "anew")
    difference = repairs["difference"]
    assert with_sample(old, "sample_2") <= set(difference["kept"])
    by_id = {action["id"]: action for action in (*new["actions"],)}
    before = {action["id"]: action for action in old["actions"]}
    for one, other in difference["kept"].items():
        assert before[one]["arguments"] == by_id[other]["arguments"]
    assert {*difference["kept"], *difference["reassigned"], *difference["dropped"]} == set(before)
    assert difference["words"][0].startswith(f"{len(difference['kept'])} of {len(before)} actions kept")
    assert api.post(f"/v1/plans/{new['id']}:approve").status_code == 202
    assert follow(f"/v1/goals/{old['goal_id']}", "finished")["outcome"] == "completed"


def test_an_overtaken_plan_that_cannot_be_repaired_says_why(api: TestClient, follow: Follow) -> None:
    old = planned(api, follow)
    lame = {"facts": [{"predicate": "can", "args": ["yard_1", "DOCK"], "value": False}]}
    lame["facts"].append({"predicate": "can", "args": ["yard_2", "DOCK"], "value": False})
    answer = api.put("/v1/worlds/sample_store/facts", json=lame)
    assert answer.status_code == 200, answer.text
    assert api.post(f"/v1/plans/{old['id']}:approve").status_code == 409
    goal = follow(f"/v1/goals/{old['goal_id']}", "unsolvable")
    assert goal["reason"]
