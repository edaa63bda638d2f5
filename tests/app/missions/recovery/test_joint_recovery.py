"""Two robots carry a long sample and it is broken off: carried on from where it stands, or said why not."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from robots.world import WorldFile, load_world
from tests.app.fake_robots import FakeTeam
from tests.waiting import ENDED

Follow = Callable[..., dict[str, Any]]


@pytest.fixture
def world_file() -> WorldFile:
    return load_world("relocation_lab")


def carried(api: TestClient, follow: Follow) -> dict[str, Any]:
    """The mission, once it has ended."""
    body = {"text": "move rock_sample to lander", "auto_approve": True}
    goal = f"/v1/goals/{api.post('/v1/goals', json=body).json()['id']}"
    mission_id = follow(goal, "committed", "finished")["mission_id"]
    return follow(f"/v1/missions/{mission_id}", *ENDED)


@pytest.mark.parametrize("tag", ["NAVIGATE", "DOCK", "DOCK2", "TRANSPORT", "RELEASE1", "RELEASE2"])
def test_a_relocation_that_is_broken_off_once_is_carried_on(
    tag: str, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.perceives = True
    team.faults.fails_at, team.faults.failures_left = dict.fromkeys(("fred", "ginger"), tag), 1
    ended = carried(api, follow)
    assert ended["state"] == "completed", ended["reason"]
    assert [one["outcome"] for one in ended["recovery"]["attempts"]] == ["approved"]


def test_a_relocation_that_cannot_be_carried_on_says_what_stands_against_it(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.perceives = True
    team.faults.fails_at = dict.fromkeys(("fred", "ginger"), "TRANSPORT")
    ended = carried(api, follow)
    assert ended["state"] == "failed"
    assert "the gripper does not close" in ended["reason"]
    assert "no plan was found without TRANSPORT by" in ended["reason"]
