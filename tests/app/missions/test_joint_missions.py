"""Two robots relocate a long sample: the goal's way through the service, and what it then believes."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from robots.world import WorldFile, load_world
from tests.app.fake_robots import FakeTeam

Follow = Callable[..., dict[str, Any]]
SENTENCE = "move rock_sample to lander"


@pytest.fixture
def world_file() -> WorldFile:
    return load_world("relocation_lab")


def approved(api: TestClient, follow: Follow) -> str:
    """The mission's path, once its plan is approved."""
    goal = f"/v1/goals/{api.post('/v1/goals', json={'text': SENTENCE, 'recovery': 'never'}).json()['id']}"
    plan_id = follow(goal, "planned")["plan_id"]
    return f"/v1/missions/{api.post(f'/v1/plans/{plan_id}:approve', json={}).json()['mission_id']}"


def believed(api: TestClient) -> set[str]:
    facts = api.get("/v1/worlds/relocation_lab/facts").json()["items"]
    return {f"{fact['predicate']}({', '.join(fact['args'])})" for fact in facts}


def test_a_relocation_is_planned_carried_out_by_two_and_believed(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    follow(approved(api, follow), "completed")
    facts = believed(api)
    assert "in(rock_sample, lander)" in facts
    assert {f"robot_attribute({robot}, gripper, empty)" for robot in ("fred", "ginger")} <= facts
    assert not any(fact.startswith(("holds_alone", "brought", "tracked", "clear(lander")) for fact in facts)
    assert sum(fact.endswith(", lander)") and fact.startswith("near(") for fact in facts) == 1


def test_while_both_hold_it_the_sample_is_believed_to_be_in_both(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.fails_at = dict.fromkeys(("fred", "ginger"), "RELEASE1")
    follow(approved(api, follow), "failed")
    assert {"in(rock_sample, fred)", "in(rock_sample, ginger)"} <= believed(api)


def test_what_a_robot_did_after_a_joint_action_outlasts_its_partners_late_report(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.late_s = {("ginger", "TRANSPORT"): 8.0}
    follow(approved(api, follow), "completed")
    assert "near(fred, fred_spot)" in believed(api)
