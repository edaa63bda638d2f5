"""Describes the robot's situation when a packet fails, in words for the operator."""

from cmath import phase
from collections.abc import Iterable

from robots.perception.percepts import GRIP, Percepts

NEAREST_ROBOT_M = 4.0
"""The nearest robot in view is mentioned up to this distance."""
CLOSE_M = 0.5
"""The nearest obstacle is mentioned up to this gap to the hull."""


def describe_situation(percepts: Percepts, names: Iterable[str]) -> str:
    """The robot's estimated place, defective sensors, sightings of the named things, and the nearest obstacle.

    :param names: places, objects and robots; any other name is ignored.
    """
    pose = percepts.pose
    words = [f"{percepts.me} at ({pose.x_m:.1f}, {pose.y_m:.1f})"]
    words += [f"{percepts.me}'s {defect.words}" for defect in percepts.degraded]
    if percepts.seen is not None:
        mentioned = dict.fromkeys([*names, *_nearest_robot(percepts)])
        words += [sighting for name in mentioned if (sighting := _sighting(percepts, name))]
        words += [] if percepts.seen else ["no beacon in view at all"]
    if percepts.about is not None:
        words += _in_the_way(percepts)
    return "; ".join(words)


def _nearest_robot(percepts: Percepts) -> list[str]:
    others = [one for one in percepts.sightings.values() if one.identity in percepts.profile.others]
    near = [one for one in others if one.range_m <= NEAREST_ROBOT_M]
    return [one.identity for one in sorted(near, key=lambda one: one.range_m)[:1]]


def _sighting(percepts: Percepts, name: str) -> str:
    if percepts.data.holds(GRIP) and name == percepts.holding:
        return f"holds {name}"
    sighting = percepts.sightings.get(name)
    if sighting is not None:
        return f"sees {name} {sighting.range_m:.2f} m off at {sighting.bearing_rad:+.2f} rad"
    if name in percepts.last_seen:
        last = percepts.last_seen[name]
        return f"{name} not seen for {percepts.time_s - last.at_s:.0f} s, last {last.range_m:.2f} m off"
    return f"{name} never seen" if name in percepts.profile.beacons else ""


def _in_the_way(percepts: Percepts) -> list[str]:
    near = min(percepts.obstacles, key=lambda one: one.gap_m, default=None)
    if near is None or near.gap_m > CLOSE_M:
        return []
    what = "a robot" if near.is_robot else "something"
    return [f"{what} {near.gap_m:.2f} m from its hull at {phase(near.at):+.2f} rad"]
