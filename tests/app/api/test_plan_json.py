"""The JSON of plans: cached, except for the decision."""

import json
from typing import Any

from app.api.bodies import plan_body
from app.api.plan_json import PlanJson
from app.store import PlanRow
from planner.plan_nets.forecast import PROBABILITIES


def plan(name: str = "plan-1", **changes: Any) -> PlanRow:
    body = {
        "id": name,
        "goals": [{"predicate": "in", "args": ["sample_1", "bay_7"]}],
        "actions": [],
        "causal_links": [],
        "orderings": [],
        "robots": ["yard_1"],
        "recruitment": {},
        "objects": {"sample_1": "sample"},
        "makespan_s": 12.5,
    }
    known = {
        "state": "proposed",
        "reason": "",
        "label": "",
        "comparison": "",
        "created_at": "2026-01-01T00:00:00.000Z",
    }
    return PlanRow(id=name, body=body, **(known | changes))


def test_a_plans_json_is_that_of_its_model() -> None:
    cache = PlanJson()
    row = plan()
    for _ in range(2):
        shown = json.loads(cache.of(row, cache.known(), ["bay_7 is occupied"]))
        expected = plan_body(row).model_copy(update={"overtaken": ("bay_7 is occupied",)})
        assert shown == expected.model_dump(mode="json")


def test_a_decision_is_shown_for_a_plan_that_is_known() -> None:
    cache = PlanJson()
    cache.of(plan(), cache.known())
    decided = plan(state="rejected", comment="too late", decided_by="ann")
    decided.body = {}  # not read again
    shown = json.loads(cache.of(decided, cache.known()))
    assert (shown["state"], shown["comment"], shown["decided_by"]) == ("rejected", "too late", "ann")
    assert shown["makespan_s"] == 12.5


def test_the_chances_of_a_plan_that_waits_sink_while_it_does() -> None:
    cache = PlanJson()
    goal = {"predicate": "in", "args": ["sample_1", "bay_7"]}
    times_s = tuple(float(second) for second in range(10, 10 + len(PROBABILITIES)))
    likely = {
        "goals": [
            {
                "goal": goal,
                "p10_s": 1,
                "p50_s": 2,
                "p90_s": 3,
                "deadline_s": 40.0,
                "on_time": 1.0,
                "quantiles_s": times_s,
            }
        ],
        "on_time": 1.0,
        "lateness_quantiles_s": [second - 40.0 for second in times_s],
        "made_at_s": 100.0,
    }
    row = plan()
    row.body |= {"forecast": likely}
    for start_s, chance in ((None, 1.0), (90.0, 1.0), (130.0, 0.0)):
        for _ in range(2):
            shown = json.loads(cache.of(row, cache.known(), start=lambda _, start_s=start_s: start_s))[
                "forecast"
            ]
            assert (shown["on_time"], shown["goals"][0]["on_time"]) == (chance, chance)
    shown = json.loads(cache.of(row, cache.known(), start=lambda _: 117.0))["forecast"]
    assert 0.3 < shown["on_time"] < 0.7
    assert (shown["delay_s"], shown["goals"][0]["p50_s"]) == (17.0, 2.0)


def test_the_plans_used_longest_ago_are_forgotten_beyond_the_capacity() -> None:
    size = len(PlanJson().of(plan(), {}))
    cache = PlanJson(capacity_bytes=2 * size)
    for name in ("plan-1", "plan-2", "plan-1", "plan-3", "plan-4"):
        cache.of(plan(name), cache.known())
    assert "plan-4" in cache.known()
    assert "plan-2" not in cache.known()
    assert sum(known.size_bytes for known in cache.known().values()) <= 2 * size
