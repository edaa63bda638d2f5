"""An operator's corrections of the facts: what contradicts itself is refused, what had to go is named."""

from typing import Any

import httpx2
import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.store import EventRow

FACTS = "/v1/worlds/sample_store/facts"
Said = tuple[str, list[str], bool]


def correct(api: TestClient, *said: Said) -> httpx2.Response:
    facts = [{"predicate": predicate, "args": args, "value": value} for predicate, args, value in said]
    return api.put(FACTS, json={"facts": facts})


def held(api: TestClient) -> set[str]:
    return {named(fact) for fact in api.get(FACTS).json()["items"]}


def named(fact: dict[str, Any]) -> str:
    return f"{fact['predicate']}({', '.join(fact['args'])})"


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("in", ["sample_1", "bay_7"], True), ("in", ["sample_1", "bay_8"], True)),
        (("in", ["sample_1", "bay_7"], True), ("in", ["sample_2", "bay_7"], True)),
        (("in", ["sample_1", "bay_7"], True), ("in", ["sample_1", "bay_7"], False)),
        (("in", ["sample_1", "bay_7"], True), ("vacant", ["bay_7"], True)),
        (("near", ["yard_1", "door_1"], True), ("at", ["yard_1", "door_1"], True)),
        (
            ("robot_attribute", ["yard_1", "gripper", "empty"], True),
            ("in", ["sample_1", "yard_1"], True),
        ),
    ],
    ids=lambda said: f"{said[0]} {' '.join(said[1])} {said[2]}",
)
def test_facts_that_contradict_each_other_are_refused_and_both_named(
    api: TestClient, one: Said, other: Said
) -> None:
    before = held(api)
    for said in ((one, other), (other, one)):
        answer = correct(api, ("near", ["yard_2", "door_2"], True), *said)
        assert (answer.status_code, answer.json()["type"]) == (422, "urn:macta:problem:contradicting-facts")
        assert all(
            f"{predicate}({', '.join(args)})" in answer.json()["detail"] for predicate, args, _ in said
        )
    assert held(api) == before


def test_samples_may_change_places_in_one_correction(api: TestClient) -> None:
    answer = correct(api, ("in", ["sample_1", "bay_2"], True), ("in", ["sample_2", "door_1"], True))
    assert answer.status_code == 200
    assert {"in(sample_1, bay_2)", "in(sample_2, door_1)"} <= held(api)


@pytest.mark.parametrize("relation", ["near", "at"])
def test_a_robot_is_not_believed_to_be_where_it_does_not_reach(api: TestClient, relation: str) -> None:
    answer = correct(api, (relation, ["yard_1", "bay_7"], True))
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:macta:problem:place-unreachable")
    choices = set(answer.json()["choices"])
    assert {"door_1", "interchange_2"} <= choices
    assert not {"bay_7", "bay_1"} & choices
    assert f"{relation}(yard_1, bay_7)" not in held(api)


@pytest.mark.parametrize(
    ("wrong", "code"),
    [
        (("in", ["sample_1", "home_yard_1"], True), "place-holds-no-samples"),
        (("near", ["yard_1", "bay_7"], True), "place-unreachable"),
    ],
)
def test_a_wrong_fact_is_refused_wherever_it_stands_among_right_ones(
    api: TestClient, wrong: Said, code: str
) -> None:
    right = [("near", ["yard_2", "door_2"], True), ("in", ["sample_2", "bay_3"], True)]
    for said in ((wrong, *right), (*right, wrong)):
        answer = correct(api, *said)
        assert (answer.status_code, answer.json()["type"]) == (422, f"urn:macta:problem:{code}")


def test_a_robot_may_stand_on_the_open_floor(api: TestClient) -> None:
    assert correct(api, ("near", ["yard_1", "yard_1_spot"], True)).status_code == 200


def test_what_cannot_hold_beside_the_news_is_named_in_the_answer_and_in_the_record(
    api: TestClient, service: Service
) -> None:
    answer = correct(api, ("in", ["sample_1", "bay_2"], True), ("in", ["sample_3", "bay_5"], False))
    gone = {"in(sample_1, door_1)", "in(sample_2, bay_2)"}
    assert {named(fact) for fact in answer.json()["dropped"]} == gone
    assert api.get(FACTS).json()["dropped"] == []
    event = next(row for row in corrections(service) if row.subject == "sample_store")
    assert {named(fact) for fact in event.data["dropped"]} == gone


def corrections(service: Service) -> list[EventRow]:
    return [row for row in service.events.since(0) if row.type == "world.corrected"]


def test_only_places_that_the_sample_can_be_carried_to_are_offered_for_one_that_is_taken(
    api: TestClient,
) -> None:
    # Without store_2 nobody carries anything to the second aisle.
    assert correct(api, ("can", ["store_2", "DOCK"], False)).status_code == 200
    answer = api.post("/v1/goals", json={"text": "move sample_1 to bay_2"})
    assert (answer.status_code, answer.json()["type"]) == (409, "urn:macta:problem:place-occupied")
    choices = answer.json()["choices"]
    assert {"bay_1", "bay_3", "door_2"} <= set(choices)
    assert not {"bay_7", "bay_12", "bay_2", "door_1"} & set(choices)


def test_a_sample_is_not_laid_where_none_may_lie(api: TestClient) -> None:
    before = held(api)
    answer = correct(api, ("in", ["sample_1", "home_yard_1"], True))
    body = answer.json()
    assert (answer.status_code, body["type"]) == (422, "urn:macta:problem:place-holds-no-samples")
    assert "home_yard_1 is a home, it holds no samples" in body["detail"]
    assert "bay_7" in body["choices"]
    assert "home_yard_1" not in body["choices"]
    assert held(api) == before
    assert correct(api, ("in", ["sample_1", "yard_1"], True)).status_code == 200
