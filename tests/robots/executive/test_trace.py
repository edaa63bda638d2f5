"""What every pattern contributed is kept tick by tick, and told in telemetry."""

import pytest

from robots.executive.trace import KEPT, Trace
from robots.physical.body import Pose
from robots.reactive.synthesis import Utilitor, superpose
from robots.wire import TRACED_S, Performative, TracedPattern, TraceQuery, TraceReport
from tests.robots.stories import Service, packet, room, run_for, script


def driven(seconds: float) -> tuple[Service, Trace]:
    world = room()
    service = Service(world, world.add("yard_1", Pose(x_m=1, y_m=1.5, heading_rad=0)), "yard_1")
    service.order(script("yard_1", packet("NAVIGATE", ref2="yard")))
    run_for(world, [service], seconds)
    return service, world.agents["yard_1"].trace


def test_every_ticks_utilitors_superpose_to_its_resultants_and_motion() -> None:
    _, trace = driven(3)
    acted = [instant for instant in trace if instant.responses.of]
    assert len(acted) > 50
    for instant in acted:
        for dof, resultant in instant.responses.resultant.items():
            related = [Utilitor(one.r, one.u) for pattern, one in instant.responses.of if pattern.dof is dof]
            assert superpose(related) == resultant
        speed = 0.5 * instant.responses.resultants()["translate"][0]
        assert instant.motion.linear_m_s == pytest.approx(speed)


def test_the_trace_keeps_the_newest_ticks_only() -> None:
    _, long = driven(3)
    short = Trace(kept=10)
    for instant in long:
        short.record(instant)
    assert list(short) == list(long)[-10:]


def test_telemetry_has_the_resultants_beside_the_patterns() -> None:
    service, _ = driven(2)
    last = service.telemetry[-1]
    assert set(last.resultants) == {"translate", "rotate"}
    assert {name.split("/")[0] for name in last.patterns} == set(last.resultants)


def told(service: Service) -> TraceReport:
    return next(m.body for m in reversed(service.heard) if isinstance(m.body, TraceReport))


def test_the_trace_of_the_last_seconds_is_sent_on_request() -> None:
    world = room()
    service = Service(world, world.add("yard_1", Pose(x_m=1, y_m=1.5, heading_rad=0)), "yard_1")
    service.order(script("yard_1", packet("NAVIGATE", ref2="yard")))
    run_for(world, [service], 3)
    query = service.send(TraceQuery(seconds=1.0), Performative.QUERY)
    run_for(world, [service], 0.1)
    answer = next(m for m in service.heard if m.in_reply_to == query.id)
    (stretch,) = told(service).stretches
    assert answer.performative is Performative.INFORM
    assert (stretch.packet_id, set(stretch.dofs)) == ("NAVIGATE-yard", {"translate", "rotate"})
    assert TracedPattern(name="translate/spare_battery", level="self") in stretch.patterns
    assert 19 <= len(stretch.ticks) <= 21
    for tick in stretch.ticks:
        assert len(tick.patterns) == len(stretch.patterns)
        ahead = dict(zip(stretch.dofs, tick.resultants, strict=True))["translate"][0]
        assert tick.linear_m_s == pytest.approx(0.5 * ahead, abs=1e-3)


def test_the_packets_conditions_are_reported_as_the_robot_perceives_them() -> None:
    world = room()
    service = Service(world, world.add("yard_1", Pose(x_m=1, y_m=1.5, heading_rad=0)), "yard_1")
    service.order(script("yard_1", packet("NAVIGATE", ref2="yard")))
    run_for(world, [service], 3)
    service.send(TraceQuery(seconds=1.0), Performative.QUERY)
    run_for(world, [service], 0.1)
    before, after = told(service).conditions
    assert (before.when, before.holds, before.words) == ("before", True, "holds nothing, jaws open")
    assert (after.when, after.holds) == ("after", False)
    off_m = float(after.words.removeprefix("is ").split(" m off the approach point of yard")[0])
    said_m = service.telemetry[-1].goal_m
    assert said_m is not None
    assert said_m == pytest.approx(off_m + 0.8, abs=0.3), "the beacon is a stand-off behind the point"
    run_for(world, [service], 20)
    service.send(TraceQuery(seconds=1.0), Performative.QUERY)
    run_for(world, [service], 0.1)
    assert told(service).conditions == ()
    assert service.telemetry[-1].goal_m is None


def test_other_patterns_begin_another_stretch() -> None:
    world = room()
    service = Service(world, world.add("yard_1", Pose(x_m=4.2, y_m=1.2, heading_rad=0)), "yard_1")
    service.order(script("yard_1", packet("NAVIGATE", ref2="yard"), packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 5)
    service.send(TraceQuery(seconds=60.0), Performative.QUERY)
    run_for(world, [service], 0.1)
    packets = [stretch.packet_id for stretch in told(service).stretches]
    assert packets == sorted(packets, reverse=True)
    assert set(packets) == {"NAVIGATE-yard", "NAVIGATE-door"}


def test_the_longest_trace_is_of_bounded_size() -> None:
    _, trace = driven(20)
    full = Trace()
    instants = list(trace)
    for index in range(KEPT):
        full.record(instants[index % len(instants)])
    sent = full.report(instants[-1].at_s, TRACED_S).model_dump_json()
    assert len(sent) < 600_000
