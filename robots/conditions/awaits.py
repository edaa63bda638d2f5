"""What a robot must sense before it takes over from another: symbolic facts as sensor conditions.

Robots are coupled by sensing wherever that suffices (MACTA §5: "no need for the robots to directly
communicate"). The measures are our choice.
"""

from robots.conditions import (
    AtHandle,
    Beside,
    Clear,
    Condition,
    Empty,
    Holding,
    HoldsAlone,
    JointNear,
    LiesAt,
    Near,
    Vacant,
)
from robots.errors import RepertoireError
from robots.physical.profile import STAND_OFF_M, RobotProfile
from robots.wire import SymbolicFact

HELD_BY_M = 0.5


def condition_for(fact: SymbolicFact, profile: RobotProfile) -> Condition:  # noqa: PLR0911
    """The sensor condition that tells this robot a fact has become true.

    :raises RepertoireError: if no sensor of this robot can tell.
    """
    match fact.predicate, fact.args:
        case "in", (thing, place) if place in profile.places:
            return LiesAt(object=thing, place=place)
        case "in", (thing, robot) if robot == profile.name:
            return Holding(object=thing)
        case "in", (thing, robot) if robot in profile.others and thing in profile.lengths_m:
            return AtHandle(object=thing, robot=robot)
        case "brought", (thing, place) if thing in profile.lengths_m and place in profile.places:
            # NOTE: wider than where TRANSPORT ends, for the partner and noise have moved the object since.
            return JointNear(object=thing, place=place, within_m=0.3, facing_rad=0.3)
        case "holds_alone", (robot, thing) if robot == profile.name:
            return HoldsAlone(object=thing)
        case "in", (thing, robot) if robot in profile.others:
            return Beside(target=thing, other=robot, m=HELD_BY_M)
        case "vacant", (place,) if place in profile.places:
            return Vacant(place=place)
        case "clear", (place, *_) if place in profile.places:
            return Clear(place=place)
        case "near", (robot, place) if robot == profile.name and place in profile.places:
            return Near(place=place, within_m=0.2, facing_rad=3.2)
        case "near" | "at", (robot, place) if robot in profile.others and place in profile.places:
            return Beside(target=robot, other=place, m=STAND_OFF_M + 0.2)
        case "robot_attribute", (robot, "gripper", "empty") if robot == profile.name:
            return Empty()
    raise RepertoireError(f"{profile.name} has no sensor that tells {fact}")
