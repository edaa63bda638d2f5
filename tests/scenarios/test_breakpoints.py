"""A simulated world stands at a breakpoint of a robot's rules, with its clock, and goes on from there."""

from pathlib import Path
from typing import Any

from fastapi.testclient import TestClient

from app.planning.pool.pool import PlanningWorker
from tests.scenarios.services import AUTHORISED, over_pipe
from tests.waiting import read_until

RULES = """AGENT guard;
BELIEF(startup) => COMMIT(SEQ(DELAY(10), adoptBelief(alarm(door))));
BELIEF(alarm(?where)) => COMMIT(adoptBelief(gone(?where)));
"""
ROBOT = "/v1/robots/yard_1"


def believed(agents: list[dict[str, Any]]) -> set[str]:
    return {belief["term"] for agent in agents for belief in agent["beliefs"]}


def test_a_world_stands_at_a_rule_and_goes_on(tmp_path: Path, worker: PlanningWorker) -> None:
    with (
        over_pipe(tmp_path, worker, speed=2.0) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
    ):
        clock = service.clocks["sample_store"]
        api.put(f"{ROBOT}/rules", json={"files": {"guard": RULES}})
        assert api.put(f"{ROBOT}/breakpoints", json={"rules": ["guard:3"]}).status_code == 200
        known = read_until(api, f"{ROBOT}/breakpoints", lambda one: bool(one["halts"]))
        stood_s = clock.now_s()
        (halt,) = known["halts"]
        (firing,) = halt["firings"]
        assert (firing["rule"], firing["bindings"]) == ("guard:3", {"where": "door"})
        assert "gone(door)" not in believed(halt["agents"])
        (halt,) = api.post(f"{ROBOT}/breakpoints:step").json()["halts"]
        assert "gone(door)" in believed(halt["agents"])
        assert 0 < clock.now_s() - stood_s < 0.1
        assert api.post(f"{ROBOT}/breakpoints:continue").json()["halts"] == []
        mind = read_until(api, f"{ROBOT}/mind", lambda one: "gone(door)" in believed(one["agents"]))
        assert mind["at_s"] > halt["at_s"]
