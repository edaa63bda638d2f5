"""What a client does that publishes as a robot, and is let through by the broker."""

from fastapi.testclient import TestClient

from robots.wire import WorldEdition
from tests.app.fake_robots import FakeTeam
from tests.waiting import until

CHANGES = "/v1/worlds/sample_store/changes"


def test_no_robot_speaks_for_the_world(api: TestClient, team: FakeTeam) -> None:
    """It would keep a world from ever being told of its change."""
    team.report("yard_1", WorldEdition(edition=1))
    change = {"edits": [{"edit": "remove_sample", "name": "sample_4"}], "reason": "taken out by hand"}
    api.post(CHANGES, json=change).raise_for_status()
    until(lambda: team.editions == [1])
    until(lambda: api.get(CHANGES).json()["items"][0]["delivery"] == "taken_up")
