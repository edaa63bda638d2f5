"""What it would cost a robot to do a leg of a plan, from its own state: its bid in a contract net (SRA)."""

from cmath import rect

from robots.executive.delegation import is_awarded
from robots.executive.executive import Executive
from robots.executive.offer import DEFECT_S, Declined, Declining, Offer
from robots.perception.percepts import Percepts
from robots.physical.body import ALL_SENSORS
from robots.physical.energy import load_powers
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.physical.stand_off import STAND_OFF_M
from robots.repertoire import load_self_level
from robots.wire import BehaviourPacket, BehaviourScript, ScriptState

BATTERY = "battery"
"""The defect of the gauge itself."""


def offer(
    leg: BehaviourScript,
    *,
    profile: RobotProfile,
    executive: Executive,
    percepts: Percepts | None,
    fault: str,
    driver: str | None,
    promised_s: float,
) -> Offer | Declined:
    """The robot's bid for a leg, or why it makes none.

    :param percepts: the last ones. :param fault: why it senses nothing now; empty if it does.
    :param driver: who drives it. :param promised_s: the time of other legs that it was awarded and has no script of.
    """
    if percepts is None or fault:
        return Declined(reason=Declining.FAULT, words=fault or f"{profile.name} has sensed nothing yet")
    if driver is not None:
        return Declined(reason=Declining.DRIVEN, words=f"{driver} drives {profile.name}")
    if (unable := executive.why_unable(leg)) is not None:
        return Declined(reason=Declining.CANNOT, words=unable)
    if (wrong := _wrong_for(leg, percepts, executive)) is not None:
        return wrong
    own = executive.script
    script = None if own is None or (own.is_own and not is_awarded(own)) else own
    release_s = promised_s + (0.0 if script is None else executive.left_s)
    way_s = _way_s(leg, script, percepts)
    work_s = sum(packet.expected_duration_s for packet in leg.packets)
    powers = load_powers()
    capacity_j = profile.battery_wh * 3600
    drawn_w = powers.electronics_w + powers.sensing_w(ALL_SENSORS) + powers.driving_w(profile.speed_m_s, 0.0)
    then = percepts.battery - drawn_w * release_s / capacity_j
    after = then - drawn_w * (way_s + work_s) / capacity_j
    levels = load_self_level()
    if then < levels.needed or after < levels.critical:
        words = f"battery at {then:.0%} before the leg and {after:.0%} after it"
        return Declined(reason=Declining.BATTERY, words=words)
    charging_s = max(0.0, levels.low - after) * capacity_j / powers.charger_w
    degraded = tuple(defect.sensor for defect in percepts.degraded)
    return Offer(
        cost_s=release_s + way_s + work_s + charging_s + DEFECT_S * len(degraded),
        release_s=release_s,
        way_s=way_s,
        work_s=work_s,
        battery=after,
        degraded=degraded,
    )


def _wrong_for(leg: BehaviourScript, percepts: Percepts, executive: Executive) -> Declined | None:
    """What in the robot's present state stands against the leg."""
    named = {name for packet in leg.packets for name in packet.arguments.values()}
    for defect in percepts.degraded:
        if defect.sensor == BATTERY or defect.sensor in named:
            return Declined(reason=Declining.DEFECT, words=defect.words)
    if executive.state is ScriptState.PAUSED:
        return Declined(reason=Declining.PAUSED, words=f"script {executive.script_id} is paused")
    held = percepts.last_held
    if held is not None and held not in named and not executive.active:
        return Declined(reason=Declining.HOLDS, words=f"{percepts.me} holds {held}")
    return None


def _way_s(leg: BehaviourScript, script: BehaviourScript | None, percepts: Percepts) -> float:
    """The time from where the script leaves the robot, or it stands now, to the leg's first place."""
    profile = percepts.profile
    places = [place for packet in leg.packets for place in _places(packet, profile)]
    if not places:
        return 0.0
    left_at = [
        place for packet in (() if script is None else script.packets) for place in _places(packet, profile)
    ]
    here = (complex(percepts.pose.x_m, percepts.pose.y_m),)
    begins = _approaches(left_at[-1]) if left_at else here
    ways_m = (abs(end - begin) for begin in begins for end in _approaches(places[0]))
    return min(ways_m, default=0.0) / profile.speed_m_s


def way_to_s(place: str, percepts: Percepts) -> float | None:
    """The time straight to a place of the map at full speed; None for what is on no map."""
    known = percepts.profile.places.get(place)
    if known is None:
        return None
    here = complex(percepts.pose.x_m, percepts.pose.y_m)
    ways_m = (abs(end - here) for end in _approaches(known))
    return min(ways_m, default=0.0) / percepts.profile.speed_m_s


def _places(packet: BehaviourPacket, profile: RobotProfile) -> list[BeaconSpec]:
    """The places that a packet names, as far as the robot knows them, in the order of its parameters' names."""
    named = [profile.places.get(packet.arguments[name]) for name in sorted(packet.arguments)]
    return [place for place in named if place is not None]


def _approaches(place: BeaconSpec) -> tuple[complex, ...]:
    """Where a robot stands that is near the place, metres."""
    return tuple(place.point + rect(STAND_OFF_M, approach_rad) for approach_rad in place.approach_rad)
