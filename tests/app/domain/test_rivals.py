"""Which reports of an end fit to what others have told."""

from hypothesis import given
from hypothesis import strategies as st

from app.domain.contradictions import CLOCKS_S
from app.domain.rivals import (
    Ended,
    Seen,
    arrives_at,
    holder_until_release,
    place_until_release,
    released_alone,
)
from app.domain.world_model.beliefs import OBJECT_POSITION
from app.domain.world_model.timeliness import DatedFact
from planner import Fact
from robots.wire import Telemetry
from tests.app.sample_store import Store

NET = Store().store_sample_1()
DOCK, TRANSPORT, RELEASE = (
    next(one.id for one in NET.of_robot("yard_1") if one.tag == tag)
    for tag in ("DOCK", "TRANSPORT", "RELEASE2")
)
GRIP_S, RELEASE_S = 100.0, 160.0
SKEW = st.floats(-CLOCKS_S, CLOCKS_S)


def released(grip: dict[str, object] | None = None) -> Ended:
    known = {"state": "finished", "finished_at_s": GRIP_S} if grip is None else grip
    parts = {(DOCK, "yard_1"): known} if known else {}
    return Ended(net=NET, action=RELEASE, robot="yard_1", at_s=RELEASE_S, parts=parts)


def holds(since_s: float, until_s: float, thing: str = "sample_1") -> Seen:
    told = Telemetry(at_s=until_s, x_m=0.0, y_m=0.0, heading_rad=0.0, holding=thing)
    return Seen(robot="yard_2", telemetry=told, holding_since_s=since_s)


def believed(at_s: float, source: str = "operator") -> list[DatedFact]:
    fact = Fact(OBJECT_POSITION, ("sample_1", "in", "bay_1"))
    return [DatedFact(fact=fact, source=source, at_s=at_s)]


def test_a_release_takes_what_its_robot_alone_holds_and_an_arrival_needs_its_place() -> None:
    assert released_alone(NET, RELEASE, "yard_1") == {"sample_1"}
    assert released_alone(NET, DOCK, "yard_1") == frozenset()
    assert arrives_at(NET, TRANSPORT, "yard_1") == ("interchange_2", "yard")
    assert arrives_at(NET, DOCK, "yard_1") is None


@given(SKEW, SKEW, st.floats(0, 90), st.floats(0, 90), st.booleans())
def test_robots_that_hold_a_sample_one_after_the_other_never_contradict_each_other(
    skew_s: float, more_s: float, long_s: float, pause_s: float, is_first: bool
) -> None:
    """Whatever their clocks, up to the difference that is allowed, and whether the other has it before or after."""
    if is_first:
        until_s = GRIP_S - pause_s + skew_s
        seen = holds(until_s - long_s, until_s)
    else:
        since_s = RELEASE_S + pause_s + skew_s
        seen = holds(since_s, since_s + long_s)
    assert holder_until_release(released(), [seen]) is None
    at_s = GRIP_S + min(more_s, skew_s) if is_first else RELEASE_S + max(more_s, skew_s)
    assert place_until_release(released(), believed(at_s), str, own_source="report of yard_1") is None


@given(st.floats(GRIP_S + CLOCKS_S + 0.1, RELEASE_S - CLOCKS_S - 0.1), st.floats(0, 90), st.floats(0, 90))
def test_another_that_has_it_at_any_time_between_always_contradicts(
    at_s: float, before_s: float, after_s: float
) -> None:
    rival = holder_until_release(released(), [holds(at_s - before_s, at_s + after_s)])
    assert rival is not None
    assert rival.things == ("sample_1",)
    assert place_until_release(released(), believed(at_s), str, own_source="report of yard_1") is not None


def test_what_its_own_reports_or_none_tell_contradicts_nothing() -> None:
    own = believed(130.0, "report of yard_1")
    assert place_until_release(released(), own, str, own_source="report of yard_1") is None
    assert holder_until_release(released(), [holds(120.0, 140.0, "sample_2")]) is None
    for grip in ({}, {"state": "running"}, {"state": "finished", "finished_at_s": 100.0, "implied": True}):
        assert holder_until_release(released(grip), [holds(120.0, 140.0)]) is None
