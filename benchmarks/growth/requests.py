"""The requests whose costs are compared: every GET of the API, and what an operator does with a goal."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import httpx2

from benchmarks.growth.record import Size

GIVE_UP_S = 300.0
LOOK_S = 0.02
EVENTS = 50
"""Events that a stream replays."""
STATELESS = ("/v1/view", "/viewer", "/healthz", "/v1/telemetry", "/v1/events")
"""GET routes that are measured in another way, or do not read the record."""
LISTS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("/v1/goals", {}),
    ("/v1/goals", {"world": "{world}"}),
    ("/v1/goals", {"state": "planned", "limit": 10}),
    ("/v1/goals", {"state": "withdrawn", "limit": 10}),
    ("/v1/goals", {"world": "{world}", "state": "finished", "limit": 10}),
    ("/v1/goals", {"world": "{world}", "state": "waiting"}),
    ("/v1/goals", {"after": "{goal_page}"}),
    ("/v1/plans", {}),
    ("/v1/plans", {"state": "proposed", "limit": 10}),
    ("/v1/plans", {"state": "rejected", "limit": 10}),
    ("/v1/plans", {"state": "expired"}),
    ("/v1/plans", {"goal_id": "{goal_id}"}),
    ("/v1/plans", {"after": "{plan_page}", "limit": 20}),
    ("/v1/missions", {}),
    ("/v1/missions", {"state": "running"}),
    ("/v1/missions", {"state": "failed", "limit": 10}),
    ("/v1/missions", {"world": "{world}", "state": "failed", "limit": 10}),
    ("/v1/missions", {"after": "{mission_page}", "limit": 20}),
)
RECORDED = ("/v1/missions/{mission_id}/re",)
"""Prefixes of routes that read a recording: only the mission that was really carried out has one."""
ABSENT = ("{result_id}", "{dialogue_id}")
"""Ids of what the record has none of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """A served record: how to reach it, and the ids in it that the requests name."""

    api: httpx2.Client
    names: dict[str, str]
    carried_out: str
    """The mission that was really carried out."""

    @classmethod
    def of(cls, api: httpx2.Client, size: Size, mission: str) -> "Record":
        amid, page = size.missions // 2, size.goals // 3
        plan_page, mission_page = size.missions // 3, size.missions // 3
        plan = api.get(f"/v1/plans/plan-{amid:012x}").raise_for_status().json()
        oldest = {
            kind: api.get(f"/v1/{kind}s/{kind}-{number:012x}").raise_for_status().json()["created_at"]
            for kind, number in (("goal", page), ("plan", plan_page), ("mission", mission_page))
        }
        return cls(
            api=api,
            carried_out=mission,
            names={
                "world": plan["world"],
                "world_id": plan["world"],
                "goal_id": plan["goal_id"],
                "plan_id": plan["id"],
                "mission_id": f"mission-{amid:012x}",
                "action_id": plan["actions"][0]["id"],
                "name": plan["robots"][0],
                "open_plan": f"plan-{size.missions + 1:012x}",
                "goal_page": f"{oldest['goal']}~goal-{page:012x}",
                "plan_page": f"{oldest['plan']}~plan-{plan_page:012x}",
                "mission_page": f"{oldest['mission']}~mission-{mission_page:012x}",
            },
        )

    def filled(self, template: str) -> str:
        names = self.names
        if template.startswith(RECORDED):
            names = names | {"mission_id": self.carried_out}
        return template.format(**names)


Request = Callable[[Record], int]
"""Makes a request; returns how many items or bytes it answered."""


def reads(api: httpx2.Client) -> Iterator[tuple[str, Request]]:
    """Every GET of the API's reference, the lists with pages and filters, and the beginnings of the streams."""
    paths = api.get("/openapi.json").raise_for_status().json()["paths"]
    lists = {path for path, _ in LISTS}
    for path, parameters in LISTS:
        yield _told(path, parameters), _list(path, parameters)
    for path, methods in sorted(paths.items()):
        if "get" not in methods or path in lists or path.startswith(STATELESS):
            continue
        if not path.endswith(ABSENT):
            yield path, _get(path)
    yield "/v1/plans/{plan_id} (proposed)", _get("/v1/plans/{open_plan}")
    yield "/v1/events, the state", _stream("/v1/events", lambda _: {}, 1)
    yield f"/v1/events, after all but {EVENTS}", _stream("/v1/events", _near_the_end, EVENTS)
    yield "/v1/events, after the first", _stream("/v1/events", lambda _: {"after": 1}, EVENTS)


def _told(path: str, parameters: dict[str, Any]) -> str:
    return (
        path
        + ("?" if parameters else "")
        + "&".join(f"{k}={v}".replace("{", "").replace("}", "") for k, v in parameters.items())
    )


def _list(path: str, parameters: dict[str, Any]) -> Request:
    def ask(record: Record) -> int:
        given = {name: record.filled(str(value)) for name, value in parameters.items()}
        return len(record.api.get(path, params=given).raise_for_status().json()["items"])

    return ask


def _get(path: str) -> Request:
    """Also where the answer is a conflict: a tender, say, of a plan that was planned without bids."""

    def ask(record: Record) -> int:
        answer = record.api.get(record.filled(path))
        return len(answer.content if answer.status_code == 409 else answer.raise_for_status().content)

    return ask


def _near_the_end(record: Record) -> dict[str, Any]:
    with record.api.stream("GET", "/v1/events", params={}) as answer:
        newest = next(int(line.split()[1]) for line in answer.iter_lines() if line.startswith("id:"))
    return {"after": newest - EVENTS}


def _stream(path: str, parameters: Callable[[Record], dict[str, Any]], items: int) -> Request:
    """Follow a stream until it has sent as many events with an id."""
    known: dict[int, dict[str, Any]] = {}

    def ask(record: Record) -> int:
        given = known.setdefault(id(record), parameters(record))
        with record.api.stream("GET", path, params=given) as answer:
            seen = 0
            for line in answer.raise_for_status().iter_lines():
                seen += line.startswith("id:")
                if seen == items:
                    return seen
        raise RuntimeError(f"{path} ended after {seen} events")

    return ask


def submit(record: Record, text: str) -> str:
    """State a goal; its id."""
    answer = record.api.post("/v1/goals", json={"world": record.names["world"], "text": text})
    return str(answer.raise_for_status().json()["id"])


def approve(record: Record, goal: str) -> str:
    """Approve the goal's plan; the mission's id."""
    plan = record.api.get(f"/v1/goals/{goal}").json()["plan_id"]
    return str(record.api.post(f"/v1/plans/{plan}:approve").raise_for_status().json()["mission_id"])


def wait(record: Record, path: str, *states: str) -> None:
    """Wait until a goal or mission is in one of the states.

    :raises TimeoutError: if it is not in time.
    """
    give_up_s = time.monotonic() + GIVE_UP_S
    while (state := record.api.get(path).raise_for_status().json()["state"]) not in states:
        if time.monotonic() > give_up_s:
            raise TimeoutError(f"{path} is still {state}")
        time.sleep(LOOK_S)
