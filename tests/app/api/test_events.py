"""The event stream: the current state first, then changes in order; it resumes where a client left off."""

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import httpx2
import pytest

from app.api import streams
from app.composition import Service
from tests.app.conftest import TOKEN
from tests.app.serving import served
from tests.databases import ON_BOTH
from tests.waiting import LONG_S

pytestmark = ON_BOTH


@pytest.fixture
def address(service: Service) -> Iterator[str]:
    with served(service.api) as address:
        yield address


@contextmanager
def stream(address: str, path: str, **headers: str) -> Iterator[Iterator[dict[str, Any]]]:
    """The events of a stream, decoded."""
    headers["authorization"] = f"Bearer {TOKEN}"
    with httpx2.stream("GET", address + path, headers=headers, timeout=LONG_S) as answer:
        assert answer.status_code == 200
        assert answer.headers["content-type"].startswith("text/event-stream")
        yield (json.loads(line[5:]) for line in answer.iter_lines() if line.startswith("data:"))


def post(address: str, text: str) -> dict[str, Any]:
    headers = {"authorization": f"Bearer {TOKEN}"}
    answer: dict[str, Any] = httpx2.post(f"{address}/v1/goals", json={"text": text}, headers=headers).json()
    return answer


def until(events: Iterator[dict[str, Any]], type_: str) -> list[dict[str, Any]]:
    seen = []
    for event in events:
        seen.append(event)
        if event["type"] == type_:
            return seen
    raise AssertionError(f"the stream ended before {type_}")


def test_changes_arrive_in_order_with_their_envelope(address: str) -> None:
    goal = post(address, "move sample_1 to bay_7")
    with stream(address, "/v1/events", **{"last-event-id": "0"}) as events:
        seen = until(events, "plan.proposed")
    assert [event["seq"] for event in seen] == sorted(event["seq"] for event in seen)
    assert all(set(event) == {"seq", "time", "type", "subject", "data"} for event in seen)
    types = [event["type"] for event in seen if event["subject"] == goal["id"]]
    # A planner that is slow tells of its progress in between.
    assert [type_ for type_ in types if type_ != "goal.progress"] == ["goal.submitted", "goal.planning"]


def test_a_client_that_begins_gets_the_current_state_first(address: str) -> None:
    goal = post(address, "move sample_1 to bay_7")
    with stream(address, "/v1/events") as events:
        first = next(events)
    assert (first["type"], first["subject"]) == ("goal.state", goal["id"])
    assert first["data"]["text"] == "move sample_1 to bay_7"


def test_a_client_that_has_asked_for_the_state_begins_with_the_next_change(address: str) -> None:
    with stream(address, "/v1/events", **{"last-event-id": "0"}) as events:
        post(address, "move sample_1 to bay_7")
        until(events, "plan.proposed")
    with stream(address, "/v1/events?state=false") as events:
        goal = post(address, "move sample_2 to bay_3")
        first = next(events)
    assert (first["type"], first["subject"]) == ("goal.submitted", goal["id"])


def test_a_client_resumes_after_the_last_event_it_saw(address: str) -> None:
    post(address, "move sample_1 to bay_7")
    with stream(address, "/v1/events", **{"last-event-id": "0"}) as events:
        seen = until(events, "plan.proposed")
    middle = seen[len(seen) // 2]["seq"]
    with stream(address, "/v1/events", **{"last-event-id": str(middle)}) as events:
        again = until(events, "plan.proposed")
    assert again == [event for event in seen if event["seq"] > middle]


def test_sixty_open_streams_leave_the_api_answering(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # Longer than a client waits: a stream that held a thread of the other requests would hold it for good.
    monkeypatch.setattr(streams, "WAIT_S", 60.0)
    headers = {"authorization": f"Bearer {TOKEN}"}
    with ExitStack() as open_streams:
        for _ in range(60):
            open_streams.enter_context(stream(address, "/v1/events"))
        answer = httpx2.get(f"{address}/v1/goals", headers=headers, timeout=10)
        assert answer.json()["items"] == []
        post(address, "move sample_1 to bay_7")  # wakes them, so that they see their clients leave


def test_an_event_id_above_the_newest_begins_again(address: str) -> None:
    goal = post(address, "move sample_1 to bay_7")
    with stream(address, "/v1/events", **{"last-event-id": str(2**63 - 1)}) as events:
        first = next(events)
    assert (first["type"], first["subject"]) == ("goal.state", goal["id"])


def test_only_the_last_item_of_the_current_state_carries_the_id(address: str) -> None:
    for place in ("bay_7", "bay_8"):
        post(address, f"move sample_1 to {place}")
    headers = {"authorization": f"Bearer {TOKEN}"}
    blocks: list[dict[str, str]] = [{}]
    with httpx2.stream("GET", f"{address}/v1/events", headers=headers, timeout=LONG_S) as answer:
        for line in answer.iter_lines():
            if line:
                slot, _, value = line.partition(":")
                blocks[-1][slot] = value.strip()
            elif blocks[-1].get("id"):
                break
            else:
                blocks.append({})
    assert len(blocks) >= 2
    assert json.loads(blocks[-1]["data"])["type"].endswith(".state")
    assert blocks[-1]["id"] == str(json.loads(blocks[-1]["data"])["seq"])
