"""The JSON of plans: cached, except for the decision."""

import json
from typing import Any

from app.api.bodies import plan_body
from app.api.plan_json import PlanJson
from app.store import PlanRow


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


def test_the_plans_used_longest_ago_are_forgotten_beyond_the_capacity() -> None:
    size = len(PlanJson().of(plan(), {}))
    cache = PlanJson(capacity_bytes=2 * size)
    for name in ("plan-1", "plan-2", "plan-1", "plan-3", "plan-4"):
        cache.of(plan(name), cache.known())
    assert "plan-4" in cache.known()
    assert "plan-2" not in cache.known()
    assert sum(map(len, cache.known().values())) <= 2 * size
