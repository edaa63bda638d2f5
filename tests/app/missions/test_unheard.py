"""For which reports of finished scripts a mission waits at its end."""

from typing import Any

import pytest

from app.domain.contradictions import HELD_S
from app.missions.unheard import unheard_s
from app.store import ScriptRow

NOW_S = 100.0


def begun(at_s: float) -> dict[str, Any]:
    return {"state": "running", "at_s": at_s, "started_at_s": at_s}


def ended(at_s: float, **more: Any) -> dict[str, Any]:
    return {"state": "finished", "at_s": at_s, "finished_at_s": at_s} | more


def script(robot: str, packets: dict[str, tuple[str, ...]], known: dict[str, dict[str, Any]]) -> ScriptRow:
    body = {"packets": [{"id": one, "after": list(after)} for one, after in packets.items()]}
    return ScriptRow(robot=robot, state="finished", heard_at_s=95.0, body=body, packets=known)


def owed(giver: dict[str, dict[str, Any]], taker: dict[str, dict[str, Any]]) -> dict[str, float]:
    """What is owed when fred's "dock" waits for barney's "release"."""
    scripts = [
        script("barney", {"bring": (), "release": ()}, giver),
        script("fred", {"come": (), "dock": ("release",)}, taker),
    ]
    return dict(unheard_s(scripts, NOW_S))


RELEASED = {"bring": ended(70.0), "release": ended(80.0)}


def test_a_beginning_that_is_reported_or_follows_from_the_packet_before_is_not_waited_for() -> None:
    assert owed(RELEASED, {"come": ended(60.0), "dock": begun(82.0) | ended(90.0)}) == {}
    assert owed(RELEASED, {"come": begun(75.0) | ended(81.0), "dock": ended(90.0)}) == {}


@pytest.mark.parametrize("come", [begun(75.0) | ended(78.0), ended(75.0)])
def test_a_beginning_that_may_be_under_way_is_waited_for(come: dict[str, Any]) -> None:
    assert owed(RELEASED, {"come": come, "dock": ended(90.0)}) == {"fred": 95.0 + HELD_S - NOW_S}


def test_a_robot_that_reports_only_ends_is_not_waited_for() -> None:
    assert owed(RELEASED, {"come": ended(NOW_S - HELD_S), "dock": ended(90.0)}) == {}
    seldom = {"come": ended(NOW_S - HELD_S), "dock": ended(90.0, implied=True)}
    assert owed(RELEASED, seldom) == {}
    assert owed(RELEASED, {"come": begun(50.0) | ended(NOW_S - HELD_S), "dock": ended(90.0)}) != {}


def test_an_end_that_follows_from_the_script_is_waited_for_only_if_the_other_began_before() -> None:
    late = {"bring": ended(70.0), "release": ended(85.0, implied=True)}
    assert owed(late, {"come": ended(60.0), "dock": begun(86.0) | ended(90.0)}) == {}
    assert owed(late, {"come": ended(60.0), "dock": begun(80.0) | ended(90.0)}) == {
        "barney": 95.0 + HELD_S - NOW_S
    }
