"""A robot that reports to have released what it does not hold, or to have arrived where another stands."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from app.agents.agent_models import Reception
from app.domain.contradictions import HELD_S
from robots.wire import Message, Telemetry
from tests.app.missions.mission_services import WORLD
from tests.app.missions.test_plausibility import STORE, Mission

RELEASE, ARRIVAL = 3, 2
"""The indices of packets: yard_1 puts sample_1 down at interchange_2; it arrives there."""


@pytest.fixture
def mission(tmp_path: Path) -> Iterator[Mission]:
    made = Mission(tmp_path)
    made.clock.advance(500.0)
    yield made
    made.services.close()


def believe(mission: Mission, fact: str, source: str = "operator") -> None:
    with mission.services.database.write() as session:
        mission.services.core.facts.change(
            session,
            WORLD,
            add=[STORE.fact(fact)],
            source=source,
            at_s=mission.clock.now_s(),
            corrects=True,
        )


def shows(mission: Mission, robot: str, place: str, *, holding: str | None = None) -> None:
    x_m, y_m = STORE.world.location(place).at
    told = Telemetry(at_s=mission.clock.now_s(), x_m=x_m, y_m=y_m, heading_rad=0.0, holding=holding)
    mission.services.board.heard(robot, told)


def hear(mission: Mission, message: Message) -> Reception:
    return mission.services.reports.record(message, WORLD)


def carries(mission: Mission, robot: str, count: int) -> None:
    """The robot reports the ends of its first packets."""
    for index in range(count):
        mission.clock.advance(20.0)
        mission.say(robot, mission.packet(robot, index))


def shown(mission: Mission) -> tuple[str, str]:
    """The two sides of the one contradiction, which the mission gives as its reason."""
    (one,) = mission.services.mission(mission.id).contradictions
    state, reason = mission.stands
    assert (state, one["detail"] in reason) == ("recovering", True)
    later, earlier = (
        one["detail"].removesuffix("; only one of them can be so").split(": ")[-1].split(", but ")
    )
    return later, earlier


def sample_is_placed(mission: Mission) -> bool:
    return any(fact.args[0] == "sample_1" for fact in mission.facts if fact.predicate == "object_position")


@pytest.mark.parametrize("source", ["operator", "report of yard_2"])
def test_what_a_place_has_by_newer_news_is_not_released_elsewhere(mission: Mission, source: str) -> None:
    carries(mission, "yard_1", RELEASE)
    mission.clock.advance(10.0)
    believe(mission, "in(sample_1, door_2)", source)
    mission.clock.advance(10.0)
    claim = mission.message("yard_1", mission.packet("yard_1", RELEASE))
    assert hear(mission, claim) is Reception.HELD_BACK
    later, earlier = shown(mission)
    assert later == "yard_1 reports to have ended a5 RELEASE2 at 1580.0 s"
    assert earlier == f"the record has in(sample_1, door_2) at 1570.0 s ({source})"
    assert not sample_is_placed(mission)
    assert hear(mission, claim) is Reception.RECORDED, "it is repeated, and both sides are known"
    assert not sample_is_placed(mission)


@pytest.mark.parametrize("since_s", [-50.0, 30.0])
def test_what_another_has_held_meanwhile_is_not_released(mission: Mission, since_s: float) -> None:
    """Whether the other holds it since before the grip or after it."""
    mission.clock.advance(max(0.0, -since_s))
    if since_s < 0:
        shows(mission, "yard_2", "door_1", holding="sample_1")
    carries(mission, "yard_1", RELEASE)
    shows(mission, "yard_2", "door_1", holding="sample_1")
    mission.clock.advance(10.0)
    assert mission.say("yard_1", mission.packet("yard_1", RELEASE)) is Reception.HELD_BACK
    assert shown(mission)[1].startswith("yard_2 holds sample_1 by its telemetry")
    assert not sample_is_placed(mission)


@pytest.mark.parametrize("lead_s", [0.0, 1.0])
def test_what_is_gripped_after_the_release_contradicts_nothing(mission: Mission, lead_s: float) -> None:
    """Also if the other's clock is ahead, or news came of when the sample was not gripped yet."""
    believe(mission, "in(sample_1, door_1)", "report of yard_2")
    carries(mission, "yard_1", RELEASE)
    mission.clock.advance(20.0)
    shows(mission, "store_2", "interchange_2", holding="sample_1")
    mission.clock.advance(lead_s)
    claim = mission.message("yard_1", mission.packet("yard_1", RELEASE))
    mission.clock.advance(5.0)
    shows(mission, "store_2", "interchange_2", holding="sample_1")
    assert hear(mission, claim) is Reception.RECORDED
    assert mission.services.mission(mission.id).contradictions == []


def test_a_robot_does_not_arrive_where_another_still_stands(mission: Mission) -> None:
    carries(mission, "yard_1", ARRIVAL)
    believe(mission, "near(yard_2, interchange_2)", "report of yard_2")
    mission.clock.advance(10.0)
    claim = mission.message("yard_1", mission.packet("yard_1", ARRIVAL))
    mission.clock.advance(3.0)
    shows(mission, "yard_2", "interchange_2")
    assert hear(mission, claim) is Reception.HELD_BACK
    later, earlier = shown(mission)
    assert later == "yard_1 reports to have ended a4 TRANSPORT at 1550.0 s"
    assert earlier == "yard_2 stands at interchange_2 by its telemetry at 1553.0 s"


def test_the_record_of_a_robot_that_is_not_at_work_counts_once_no_news_may_be_under_way(
    mission: Mission,
) -> None:
    carries(mission, "yard_1", ARRIVAL)
    believe(mission, "near(yard_2, interchange_2)")
    mission.clock.advance(10.0)
    claim = mission.message("yard_1", mission.packet("yard_1", ARRIVAL))
    assert hear(mission, claim) is Reception.HELD_BACK
    assert mission.stands == (
        "unknown",
        "yard_1 reports to have ended a4 TRANSPORT at 1550.0 s, "
        "but the record has near(yard_2, interchange_2) at 1540.0 s (operator)",
    )
    assert mission.services.mission(mission.id).contradictions == []
    mission.clock.advance(HELD_S)
    assert hear(mission, claim) is Reception.HELD_BACK
    assert shown(mission)[1] == "the record has near(yard_2, interchange_2) at 1540.0 s (operator)"
    assert hear(mission, claim) is Reception.RECORDED


def test_a_robot_of_another_area_does_not_stand_in_the_way(mission: Mission) -> None:
    carries(mission, "yard_1", ARRIVAL)
    believe(mission, "near(store_1, interchange_2)")
    mission.clock.advance(10.0)
    assert mission.say("yard_1", mission.packet("yard_1", ARRIVAL)) is Reception.RECORDED


def test_news_or_a_newer_pose_that_has_the_other_elsewhere_lets_a_robot_arrive(mission: Mission) -> None:
    carries(mission, "yard_1", ARRIVAL)
    believe(mission, "near(yard_2, interchange_2)")
    mission.clock.advance(10.0)
    claim = mission.message("yard_1", mission.packet("yard_1", ARRIVAL))
    assert hear(mission, claim) is Reception.HELD_BACK
    shows(mission, "yard_2", "door_2")
    assert hear(mission, claim) is Reception.RECORDED
    assert mission.services.mission(mission.id).contradictions == []
