"""An operator's way out of a stuck mission in the aisle of a single robot: correct what is believed or find the robot,
then resume.
"""

from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.waiting import ENDED, read_until, until

Thing = dict[str, Any]
FACTS = "/v1/worlds/sample_store/facts"
ALONE = "store_2"
"""The only robot that reaches bay_7."""
FOR_EVER_S = 1_000_000.0


def until_stuck(api: TestClient, mission: str) -> Thing:
    return read_until(api, mission, lambda now: now["recovery"]["step"] == "stuck" or now["state"] in ENDED)


def put(api: TestClient, sample: str, place: str) -> None:
    answer = api.put(FACTS, json={"facts": [{"predicate": "in", "args": [sample, place]}]})
    assert answer.status_code == 200, answer.text


def resumed(api: TestClient, follow: Follow, mission: str) -> Thing:
    """The mission's end after it was resumed and any repair was approved."""
    assert api.post(f"{mission}:resume").status_code == 202
    now = read_until(
        api, mission, lambda now: now["recovery"]["step"] in ("deciding", "stuck") or now["state"] in ENDED
    )
    assert now["recovery"]["step"] != "stuck", now["reason"]
    if now["recovery"]["step"] == "deciding":
        assert api.post(f"/v1/plans/{now['recovery']['attempts'][-1]['plan_id']}:approve").status_code == 202
    return follow(mission, *ENDED)


def test_a_sample_that_the_only_robot_dropped_is_brought_after_a_correction(
    api: TestClient, start: Start, follow: Follow, team: FakeTeam
) -> None:
    team.faults.drops = {ALONE}
    mission, _ = start("ask")
    stuck = until_stuck(api, mission)
    assert "it is not known where sample_1 is" in stuck["reason"]
    team.faults.drops.clear()
    put(api, "sample_1", "interchange_2")
    (dropped,) = api.get(mission).json()["recovery"]["attempts"][0]["troubles"]
    assert (dropped["robot"], dropped["answered"]) == (ALONE, True)
    ended = resumed(api, follow, mission)
    assert ended["state"] == "completed", ended["reason"]
    assert [one["without"] for one in ended["recovery"]["attempts"]] == [[], []]
    assert ended["recovery"]["attempts"][1]["troubles"] == []


@pytest.mark.parametrize("by", ["contact", "operator"])
def test_what_the_only_robot_carried_when_it_was_given_up_is_brought_once_it_is_found(
    by: str, api: TestClient, start: Start, follow: Follow, team: FakeTeam
) -> None:
    team.faults.takes_s = {"TRANSPORT": FOR_EVER_S}
    mission, yard = start("ask")
    until(lambda: yard in team.robots and team.robots[yard].left_s > FOR_EVER_S / 2)
    team.robots[yard].left_s = 0.0
    read_until(api, FACTS, lambda facts: ["sample_1", ALONE] in [fact["args"] for fact in facts["items"]])
    if by == "contact":
        team.faults.silent.add(ALONE)
        follow(mission, "unknown")
    assert api.post(f"/v1/robots/{ALONE}:declare_lost").status_code == 202
    stuck = until_stuck(api, mission)
    assert f"{ALONE}: was declared lost" in stuck["reason"]
    team.faults.silent.clear()
    team.faults.takes_s.clear()
    if by == "operator":
        read_until(api, mission, lambda now: now["progress"][0]["state"] == "cancelled")
        assert api.post(f"/v1/robots/{ALONE}:declare_found").status_code == 202
    found = read_until(api, mission, lambda now: "was declared lost" not in now["reason"])
    assert f"{ALONE}: was given up as lost and has been found" in found["reason"]
    assert found["recovery"]["attempts"][0]["troubles"][0]["answered"] is True
    ended = resumed(api, follow, mission)
    assert ended["state"] == "completed", ended["reason"]
    again = ended["recovery"]["attempts"][1]
    assert (again["without"], "declared lost" in again["reason"]) == ([], False)
