"""A plan's problem as PDDL, through the API: what other planners get to read."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from planner import Fact
from planner.interchange.foreign import import_problem

Follow = Callable[..., dict[str, Any]]


@pytest.fixture
def plan(api: TestClient, follow: Follow) -> str:
    """A proposed plan's path."""
    answer = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"})
    goal = follow(f"/v1/goals/{answer.json()['id']}", "planned", "unsolvable")
    return f"/v1/plans/{goal['plan_id']}"


@pytest.mark.parametrize("form", ["temporal", "classical"])
def test_other_planners_read_the_problem_that_the_plan_solves(api: TestClient, plan: str, form: str) -> None:
    body = api.get(f"{plan}/pddl", params={"form": form}).json()
    read = import_problem(body["domain"], body["problem"], agents=["robot"]).problem
    assert (body["form"], body["is_current"]) == (form, True)
    assert read.goals == (Fact("object_position", ("sample_1", "in", "bay_7")),)
    assert Fact("object_position", ("sample_1", "in", "door_1")) in read.facts
    assert read.objects["yard_2"] == "robot"


def test_the_numeric_form_has_the_batteries_as_they_are_now(api: TestClient, plan: str) -> None:
    body = api.get(f"{plan}/pddl", params={"form": "numeric"}).json()
    assert body["form"] == "numeric"
    assert "(decrease (battery ?robots_1) " in body["domain"]
    numbers = {"numbers": [{"quantity": "battery", "args": ["yard_2"], "value": 0.43}]}
    assert api.put("/v1/worlds/sample_store/numbers", json=numbers).status_code == 200
    after = api.get(f"{plan}/pddl", params={"form": "numeric"}).json()
    assert "(= (battery yard_2) 0.43)" in after["problem"]
    assert "(= (battery yard_2) 0.43)" not in body["problem"]


def test_of_a_plan_that_the_world_has_overtaken_it_is_the_problem_as_it_is_now(
    api: TestClient, plan: str
) -> None:
    before = api.get(f"{plan}/pddl").json()
    moved = {"facts": [{"predicate": "in", "args": ["sample_1", "door_2"]}]}
    assert api.put("/v1/worlds/sample_store/facts", json=moved).status_code == 200
    after = api.get(f"{plan}/pddl").json()
    assert not after["is_current"]
    assert after["world_version"] > before["world_version"]
    assert "(object_position sample_1 in door_2)" in after["problem"]


def test_an_unknown_plan_and_an_unknown_form_are_refused(api: TestClient, plan: str) -> None:
    assert api.get("/v1/plans/nothing/pddl").status_code == 404
    assert api.get(f"{plan}/pddl", params={"form": "hddl"}).status_code == 422
