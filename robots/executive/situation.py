"""What a robot perceives of its plight when it gives a packet up, in words for the operator."""

from cmath import phase
from collections.abc import Iterable

from robots.perception.percepts import GRIP, Percepts

MEETS_M = 4.0
"""The nearest robot in view, no farther off than this, may be what it met."""
CLOSE_M = 0.5
"""What is nearer to the hull than this may be what is in the way."""


def plight(percepts: Percepts, names: Iterable[str]) -> str:
    """Where it believes to be, what it sees of the things that the packet names, what is close, what does not work.

    :param names: places, objects and robots; others are passed over.
    """
    pose = percepts.pose
    words = [f"{percepts.me} at ({pose.x_m:.1f}, {pose.y_m:.1f})"]
    words += [f"{percepts.me}'s {one}" for one in percepts.degraded]
    if percepts.seen is not None:
        told = dict.fromkeys([*names, *_nearest_robot(percepts)])
        words += [said for name in told if (said := _seen(percepts, name))]
        words += [] if percepts.seen else ["no beacon in view at all"]
    if percepts.about is not None:
        words += _in_the_way(percepts)
    return "; ".join(words)


def _nearest_robot(percepts: Percepts) -> list[str]:
    others = [one for one in percepts.sightings.values() if one.identity in percepts.profile.others]
    near = [one for one in others if one.range_m <= MEETS_M]
    return [one.identity for one in sorted(near, key=lambda one: one.range_m)[:1]]


def _seen(percepts: Percepts, name: str) -> str:
    if percepts.data.holds(GRIP) and name == percepts.holding:
        return f"holds {name}"
    sighting = percepts.sightings.get(name)
    if sighting is not None:
        return f"sees {name} {sighting.range_m:.2f} m off at {sighting.bearing_rad:+.2f} rad"
    if name in percepts.last_seen:
        at_s, range_m = percepts.last_seen[name]
        return f"{name} not seen for {percepts.time_s - at_s:.0f} s, last {range_m:.2f} m off"
    return f"{name} never seen" if name in percepts.profile.beacons else ""


def _in_the_way(percepts: Percepts) -> list[str]:
    near = min(percepts.obstacles, key=lambda one: one.gap_m, default=None)
    if near is None or near.gap_m > CLOSE_M:
        return []
    what = "a robot" if near.is_robot else "something"
    return [f"{what} {near.gap_m:.2f} m from its hull at {phase(near.at):+.2f} rad"]
