"""What robots claim, held against time, order and place: a forged claim is doubted, an honest one never for good."""

from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from app.domain.plausibility import (
    AHEAD_S,
    LEAST_SHARE,
    OUT_OF_ORDER_S,
    PLACE_M,
    SPEED_FACTOR,
    Packets,
    Presence,
    Work,
    doubt_of_finish,
    doubt_of_place,
    doubt_of_progress,
    doubt_of_time,
)
from robots.wire import PacketState, ScriptState, Telemetry

IDS = ("a", "b", "c")
WORK = Work(
    script_id="s",
    ids=IDS,
    tags=("NAVIGATE", "DOCK", "TRANSPORT"),
    expected_s=(20.0, 4.0, 40.0),
    firsts=(0, 1, 2),
    known={},
    given_at_s=100.0,
)


def known(**packets: tuple[PacketState, float]) -> Packets:
    """Each packet's state as it was reported last, and when."""
    return {
        name: {"state": state.value, "at_s": at_s}
        | ({"finished_at_s": at_s} if state is PacketState.FINISHED else {})
        for name, (state, at_s) in packets.items()
    }


def finish(packet: str, at_s: float, packets: Packets | None = None, *, now_s: float | None = None) -> str:
    work = replace(WORK, known=packets or {})
    return doubt_of_finish(work, packet, at_s, now_s=at_s if now_s is None else now_s, lag_s=0.0)


def telemetry(at_s: float, packet: str | None = None, *, x_m: float = 0.0, script: str = "s") -> Telemetry:
    return Telemetry(
        at_s=at_s,
        x_m=x_m,
        y_m=0.0,
        heading_rad=0.0,
        script_id=script,
        script_state=ScriptState.RUNNING,
        packet_id=packet,
        packet_state=PacketState.RUNNING if packet else None,
    )


@pytest.mark.parametrize(("packet", "least_s"), [("a", 5.0), ("b", 6.0), ("c", 16.0)])
def test_what_is_to_be_done_before_takes_its_time_too(packet: str, least_s: float) -> None:
    assert finish(packet, 100.0 + least_s) == ""
    assert "s at least" in finish(packet, 100.0 + least_s - 0.1)


def test_it_says_what_was_reported_after_what_time_and_what_it_takes() -> None:
    assert (
        finish("c", 102.2) == "reports that TRANSPORT has finished after 2.2 s, which takes 16.0 s at least"
    )


def test_a_packet_takes_its_time_since_the_one_before_it_ended() -> None:
    done = known(b=(PacketState.FINISHED, 300.0))
    assert finish("c", 310.0, done) == ""
    assert "after 9.9 s" in finish("c", 309.9, done)


def test_of_an_actions_phases_only_all_together_take_their_time() -> None:
    """Where one ends and the next begins depends on where exactly the robot stood."""
    phases = replace(WORK, firsts=(0, 0, 2))
    assert doubt_of_finish(phases, "a", 100.0, now_s=100.0, lag_s=0.0) == ""
    between = replace(WORK, firsts=(0, 1, 1))
    assert "takes 5.0 s" in doubt_of_finish(between, "b", 104.9, now_s=104.9, lag_s=0.0)
    assert doubt_of_finish(between, "b", 105.0, now_s=105.0, lag_s=0.0) == ""

    def second_phase(first_ended_s: float, at_s: float) -> str:
        work = replace(phases, known=known(a=(PacketState.FINISHED, first_ended_s)))
        return doubt_of_finish(work, "b", at_s, now_s=at_s, lag_s=0.0)

    assert second_phase(110.0, 110.1) == ""
    assert "after 5.9 s, which takes 6.0 s" in second_phase(105.0, 105.9)
    ended = replace(phases, known=known(a=(PacketState.FINISHED, 110.0), b=(PacketState.FINISHED, 110.1)))
    assert doubt_of_finish(ended, "c", 120.2, now_s=120.2, lag_s=0.0) == ""
    assert "after 9.8 s" in doubt_of_finish(ended, "c", 119.9, now_s=119.9, lag_s=0.0)


def test_what_comes_before_a_packet_that_has_finished_needs_no_report_of_its_own() -> None:
    done = known(c=(PacketState.FINISHED, 300.0))
    assert finish("c", 300.0, done) == ""
    assert finish("a", 150.0, done, now_s=300.0) == ""


def test_time_that_passes_makes_an_early_claim_plausible() -> None:
    assert finish("a", 100.1, now_s=100.2)
    assert finish("a", 100.1, now_s=105.0) == ""


def test_a_claim_gains_no_more_time_by_a_clock_that_is_ahead_than_ours_may_be_behind() -> None:
    assert doubt_of_finish(WORK, "a", 105.0, now_s=101.0, lag_s=4.0) == ""
    assert doubt_of_finish(WORK, "a", 105.0, now_s=101.0, lag_s=3.9)


def test_a_script_of_before_that_was_noted_is_given_the_benefit_of_the_doubt() -> None:
    assert doubt_of_finish(replace(WORK, given_at_s=None), "c", 0.0, now_s=0.0, lag_s=0.0) == ""


@pytest.mark.parametrize("lag_s", [0.0, 50.0])
def test_a_report_is_not_of_the_future(lag_s: float) -> None:
    most_s = AHEAD_S * (1 + lag_s)
    assert doubt_of_time(10.0 + most_s, now_s=10.0, lag_s=lag_s) == ""
    assert doubt_of_time(10.1 + most_s, now_s=10.0, lag_s=lag_s)


def test_a_packet_does_not_finish_before_what_was_reported_of_the_one_before() -> None:
    running = known(a=(PacketState.RUNNING, 500.0))
    assert "before it at 500 s" in finish("b", 499.9 - OUT_OF_ORDER_S, running, now_s=500.0)
    assert finish("b", 510.0, running) == ""


def test_a_packet_does_not_finish_long_after_the_next_began() -> None:
    running = known(b=(PacketState.RUNNING, 300.0))
    assert "after it at 300 s" in finish("a", 300.1 + OUT_OF_ORDER_S, running)
    assert finish("a", 299.0, running, now_s=330.0) == ""


def test_nothing_finishes_after_a_packet_that_failed() -> None:
    assert "has failed" in finish("b", 300.0, known(a=(PacketState.FAILED, 290.0)))


@pytest.mark.parametrize("packet", IDS)
def test_a_robot_has_not_finished_what_its_later_telemetry_shows_it_at(packet: str) -> None:
    claimed = IDS.index(packet)
    for under_way, name in enumerate(IDS):
        doubt = doubt_of_progress(WORK, packet, 200.0, telemetry(200.1, name))
        assert bool(doubt) == (under_way <= claimed)
        assert doubt_of_progress(WORK, packet, 200.0, telemetry(200.0, name)) == "", "it ended just then"
    assert doubt_of_progress(WORK, packet, 200.0, telemetry(200.1, None)) == "", "it does nothing any longer"
    assert doubt_of_progress(WORK, packet, 200.0, telemetry(200.1, "a", script="own:1")) == ""


def test_a_robot_is_where_it_could_have_come_from_the_place() -> None:
    def away(x_m: float, at_s: float) -> str:
        presence = Presence(telemetry=telemetry(at_s, x_m=x_m), speed_m_s=0.5)
        return doubt_of_place("bay_7", (0.0, 0.0), 200.0, presence, within_m=PLACE_M)

    assert away(PLACE_M, 200.0) == ""
    assert away(PLACE_M + 0.1, 200.0) == "reports to be at bay_7, but its telemetry shows it 2.6 m away"
    for later_s in (-10.0, 10.0):
        most_m = PLACE_M + SPEED_FACTOR * 0.5 * 10.0
        assert away(most_m, 200.0 + later_s) == ""
        assert away(most_m + 0.1, 200.0 + later_s)


@example(
    ratios=(0.25, 0.25, 0.25), waits_s=(8.0, 10.7, 0.0), arrivals=IDS, delays_s=(0.0, 0.0, 0.0), shown=0.0
)
@given(
    ratios=st.tuples(*[st.floats(LEAST_SHARE, 4.0)] * 3),
    waits_s=st.tuples(*[st.floats(0.0, 50.0)] * 3),
    arrivals=st.permutations(IDS),
    delays_s=st.tuples(*[st.floats(0.0, 500.0)] * 3),
    shown=st.floats(0.0, 1.0),
)
def test_an_honest_run_is_never_doubted_however_late_and_in_whatever_order_it_is_heard_of(
    ratios: Sequence[float],
    waits_s: Sequence[float],
    arrivals: Sequence[str],
    delays_s: Sequence[float],
    shown: float,
) -> None:
    now_s = 100.0
    ends_s = {}
    for name, expected_s, ratio, wait_s in zip(IDS, WORK.expected_s, ratios, waits_s, strict=True):
        now_s += wait_s + ratio * expected_s
        ends_s[name] = now_s
    packets: Packets = {}
    heard_s = 0.0
    for name, delay_s in zip(arrivals, delays_s, strict=True):
        heard_s = max(heard_s, ends_s[name] + delay_s)
        assert finish(name, ends_s[name], packets, now_s=heard_s) == ""
        # Its newest telemetry is of any time until then.
        at_s = 100.0 + shown * (heard_s - 100.0)
        under_way = next((one for one in IDS if at_s < ends_s[one]), None)
        assert doubt_of_progress(WORK, name, ends_s[name], telemetry(at_s, under_way)) == ""
        packets = {**packets, **known(**{name: (PacketState.FINISHED, ends_s[name])})}
