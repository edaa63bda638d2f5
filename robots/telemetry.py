"""What a robot tells of itself ten times a second."""

from math import isfinite

from robots.executive import Executive
from robots.percepts import Percepts
from robots.wire import Telemetry


def telemetry(percepts: Percepts, executive: Executive) -> Telemetry:
    """Its own belief: estimated pose, whiskers, where it sees samples, what it does."""
    run = executive.current
    return Telemetry(
        at_s=percepts.time_s,
        x_m=percepts.pose.x_m,
        y_m=percepts.pose.y_m,
        heading_rad=percepts.pose.heading_rad,
        ranges_m=tuple(float(r) if isfinite(r) else None for r in percepts.readings.ranges_m),
        holding=percepts.holding,
        battery=percepts.readings.battery,
        charging=percepts.readings.charging,
        script_id=executive.script_id,
        script_state=executive.state,
        packet_id=run.packet.id if run else None,
        packet_tag=run.packet.tag if run else None,
        packet_state=executive.packet_state,
        tags={tag: _place(percepts, tag) for tag in percepts.tags},
        patterns=executive.responses.shown(),
    )


def _place(percepts: Percepts, tag: str) -> tuple[float, float]:
    at = percepts.to_world(percepts.locate(tag) or 0j)
    return at.real, at.imag
