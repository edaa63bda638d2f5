"""What a sentence would be taken for, while it is typed."""

from typing import Any

from fastapi.testclient import TestClient


def check(shared_api: TestClient, text: str) -> dict[str, Any]:
    answer = shared_api.post("/v1/goals:check", json={"text": text})
    assert answer.status_code == 200, answer.text
    body: dict[str, Any] = answer.json()
    return body


def test_a_sentence_that_lacks_something_is_asked_for_it_and_goes_on(shared_api: TestClient) -> None:
    checked = check(shared_api, "move sample_1 to")
    assert checked["goals"] == []
    assert checked["issue"]["code"] == "place-needed"
    assert "move sample_1 to bay_7" in checked["completions"]


def test_a_sentence_that_is_understood_is_what_would_be_planned(shared_api: TestClient) -> None:
    checked = check(shared_api, "move sample_1 to bay_7")
    assert checked == {
        "goals": [{"predicate": "in", "args": ["sample_1", "bay_7"]}],
        "constraints": {
            "robots": [],
            "without": [],
            "avoid": [],
            "keep_empty": [],
            "keep": [],
            "after": [],
            "at_least": {},
            "stages": [],
            "worth": [],
            "preferences": [],
        },
        "deadline_s": None,
        "due": None,
        "readings": [],
        "holds": [],
        "preferences": [],
        "issue": None,
        "completions": [],
    }


def test_what_stands_against_a_goal_is_what_stating_it_would_end_in(shared_api: TestClient) -> None:
    stated = shared_api.post("/v1/goals", json={"text": "move sample_1 to bay_2"})
    issue = check(shared_api, "move sample_1 to bay_2")["issue"]
    assert stated.status_code == 409
    assert (issue["detail"], issue["choices"]) == (stated.json()["detail"], stated.json()["choices"])


def test_nothing_is_recorded_of_a_sentence_that_is_checked(shared_api: TestClient) -> None:
    check(shared_api, "move sample_1 to bay_7")
    assert shared_api.get("/v1/goals").json()["items"] == []
