"""The world model's truth: who said what, what was believed before, what is not known, and two who write at once."""

import threading
from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.fake_robots import FakeTeam

FACTS = "/v1/worlds/sample_store/facts"
UNKNOWN = "/v1/worlds/sample_store/unknown"
Follow = Callable[..., dict[str, Any]]


def correct(api: TestClient, predicate: str, *args: str, value: bool = True, etag: str | None = None) -> Any:
    body = {"facts": [{"predicate": predicate, "args": args, "value": value}]}
    return api.put(FACTS, json=body, headers={"if-match": etag} if etag else {})


def fact(api: TestClient, predicate: str, *args: str) -> dict[str, Any]:
    items = api.get(FACTS).json()["items"]
    found: dict[str, Any] = next(f for f in items if (f["predicate"], tuple(f["args"])) == (predicate, args))
    return found


def test_a_fact_shows_what_was_believed_before_it_was_contradicted(api: TestClient, service: Service) -> None:
    assert correct(api, "in", "sample_1", "bay_7").status_code == 200
    known = fact(api, "in", "sample_1", "bay_7")
    (before,) = known["instead_of"]
    assert (before["predicate"], before["args"]) == ("in", ["sample_1", "door_1"])
    assert (before["source"], before["at_s"]) == ("world file sample_store", 0.0)
    (event,) = [row for row in service.events.since(0) if row.type == "world.contradicted"]
    assert event.data["source"] == "operator administrator"
    assert event.data["believed"] == [before]
    assert fact(api, "in", "sample_2", "bay_2")["instead_of"] == []


def test_a_sample_that_is_not_where_it_was_believed_is_listed_as_not_known_until_it_is_found(
    api: TestClient,
) -> None:
    assert api.get(UNKNOWN).json()["items"] == []
    assert correct(api, "in", "sample_1", "door_1", value=False).status_code == 200
    (item,) = api.get(UNKNOWN).json()["items"]
    assert (item["name"], item["kind"]) == ("sample_1", "sample")
    assert "operator administrator" in item["reason"]
    assert item["last_believed"]["args"] == ["sample_1", "door_1"]
    assert item["last_believed"]["source"] == "world file sample_store"
    assert correct(api, "in", "sample_1", "bay_7").status_code == 200
    assert api.get(UNKNOWN).json()["items"] == []


def places(beliefs: list[dict[str, Any]]) -> list[str]:
    return [belief["args"][1] for belief in beliefs]


def test_after_a_second_wrong_correction_the_earlier_right_place_is_offered(api: TestClient) -> None:
    correct(api, "in", "sample_1", "bay_7")
    correct(api, "in", "sample_1", "bay_9")
    assert places(fact(api, "in", "sample_1", "bay_9")["instead_of"]) == ["bay_7", "door_1"]
    correct(api, "in", "sample_1", "bay_9", value=False)
    (item,) = api.get(UNKNOWN).json()["items"]
    assert item["last_believed"]["args"] == ["sample_1", "bay_9"]
    assert places(item["earlier_believed"]) == ["bay_7", "door_1"]
    assert item["earlier_believed"][1]["source"] == "world file sample_store"
    correct(api, "in", "sample_1", "bay_12")
    assert places(fact(api, "in", "sample_1", "bay_12")["instead_of"]) == ["bay_9", "bay_7", "door_1"]
    correct(api, "in", "sample_1", "door_1")
    assert places(fact(api, "in", "sample_1", "door_1")["instead_of"]) == ["bay_12", "bay_9", "bay_7"]


def test_what_was_believed_of_another_sample_is_not_offered(api: TestClient) -> None:
    correct(api, "in", "sample_1", "bay_7")
    correct(api, "in", "sample_2", "bay_7")
    before = fact(api, "in", "sample_2", "bay_7")["instead_of"]
    assert sorted(belief["args"] for belief in before) == [["sample_1", "bay_7"], ["sample_2", "bay_2"]]


def test_a_sample_that_a_robot_dropped_is_not_known_and_the_mission_says_so(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.perceives, team.faults.drops = True, {"yard_1", "yard_2"}
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    mission_id = follow(f"/v1/goals/{goal['id']}", "committed", "finished")["mission_id"]
    ended = follow(f"/v1/missions/{mission_id}", "failed", "partially_completed", "completed")
    assert ended["state"] == "failed"
    assert "it is not known where sample_1 is" in ended["reason"]
    (item,) = api.get(UNKNOWN).json()["items"]
    assert item["name"] == "sample_1"
    assert item["last_believed"]["args"][1].startswith("yard_")


@pytest.mark.parametrize("guarded", [True, False])
def test_of_two_who_write_at_once_from_one_version_exactly_one_is_heard(
    api: TestClient, guarded: bool
) -> None:
    etag = api.get(FACTS).headers["etag"]
    places = [f"bay_{number}" for number in (5, 7, 8, 9, 10, 11)]
    start = threading.Barrier(len(places))
    answers: dict[str, int] = {}

    def write(place: str) -> None:
        start.wait()
        answers[place] = correct(api, "in", "sample_1", place, etag=etag if guarded else None).status_code

    threads = [threading.Thread(target=write, args=(place,)) for place in places]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    lies = [f["args"][1] for f in api.get(FACTS).json()["items"] if f["args"][:1] == ["sample_1"]]
    assert len(lies) == 1
    if guarded:
        assert sorted(answers.values()) == [200] + [412] * (len(places) - 1)
        assert answers[lies[0]] == 200
    else:
        assert set(answers.values()) == {200}


def test_facts_of_a_world_are_counted_once_a_change(api: TestClient) -> None:
    before = api.get(FACTS).json()["version"]
    correct(api, "in", "sample_1", "bay_7")
    correct(api, "in", "sample_1", "bay_7")
    assert api.get(FACTS).json()["version"] == before + 1
