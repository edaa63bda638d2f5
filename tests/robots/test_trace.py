"""What every pattern contributed is kept tick by tick, and told in telemetry."""

import pytest

from robots.body import Pose
from robots.synthesis import Utilitor, superpose
from robots.trace import Trace
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
    assert short.latest == long.latest
    assert short.of("NAVIGATE-yard") == list(short)


def test_an_instant_says_in_a_line_what_led_to_what() -> None:
    _, trace = driven(1)
    assert trace.latest is not None
    line = str(trace.latest)
    assert "NAVIGATE-yard" in line
    assert "rotate/steer" in line
    assert "m/s" in line


def test_telemetry_tells_the_resultants_beside_the_patterns() -> None:
    service, _ = driven(2)
    last = service.telemetry[-1]
    assert set(last.resultants) == {"translate", "rotate"}
    assert {name.split("/")[0] for name in last.patterns} == set(last.resultants)
