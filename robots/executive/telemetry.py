"""A robot's telemetry."""

from collections.abc import Iterable
from math import isfinite

from robots.executive.executive import Executive
from robots.executive.packet_run import PacketRun
from robots.perception.percepts import LOCATING, Percepts
from robots.physical.body import Sensor
from robots.physical.energy import SensingMeter
from robots.physical.sightings import Sightings
from robots.wire import Telemetry


def telemetry(
    percepts: Percepts,
    executive: Executive,
    meter: SensingMeter,
    running: Iterable[str],
    *,
    driven_by: str | None,
    touched: bool | None,
) -> Telemetry:
    """The robot's own belief, its current activity, and the energy that its sensing uses.

    :param touched: since the last telemetry; None: the bumper has not read.
    """
    run = executive.current
    ranges_m = percepts.data.values.get(Sensor.ULTRASONIC)
    return Telemetry(
        at_s=percepts.time_s,
        x_m=percepts.pose.x_m,
        y_m=percepts.pose.y_m,
        heading_rad=percepts.pose.heading_rad,
        ranges_m=() if ranges_m is None else tuple(r if isfinite(r) else None for r in ranges_m.tolist()),
        holding=percepts.last_held,
        battery=percepts.battery,
        charging=percepts.charging,
        script_id=executive.script_id,
        script_state=executive.state,
        packet_id=run.packet.id if run else None,
        packet_tag=run.packet.tag if run else None,
        packet_state=executive.packet_state,
        tags=_tags(percepts),
        patterns=executive.responses.shown(),
        resultants=executive.responses.resultants(),
        sensors=tuple(sorted(running)),
        sensing_j=meter.used_j,
        sensing_saved_j=meter.saved_j,
        degraded=tuple(defect.words for defect in percepts.degraded),
        driven_by=driven_by,
        goal_m=_goal_m(percepts, run),
        touched=touched,
    )


def _goal_m(percepts: Percepts, run: PacketRun | None) -> float | None:
    goal = run.content.goal if run is not None else None
    at = percepts.locate(goal) if goal is not None and percepts.data.holds(LOCATING) else None
    return None if at is None else abs(at)


def _tags(percepts: Percepts) -> dict[str, tuple[float, float]]:
    """The places of samples in view, world frame, including a held long one: its tag is not in the jaws."""
    if not percepts.data.holds(LOCATING):
        return {}
    held = percepts.holding
    names = percepts.tags
    if held is not None and held in percepts.profile.lengths_m and percepts.sees(held):
        names = (*names, held)
    if not names:
        return {}
    pose = percepts.pose
    seen = percepts.sightings
    rows = [seen.rows[name] for name in names]
    at = Sightings(names, seen.read[rows]).in_world(pose.x_m, pose.y_m, pose.heading_rad)
    return {name: (one.real, one.imag) for name, one in zip(names, at.tolist(), strict=True)}
