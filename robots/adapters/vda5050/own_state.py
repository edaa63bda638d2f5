"""What a vehicle's state says of the robot that it is: facts, and telemetry. Pure."""

from math import dist

from robots.adapters.vda5050.frame import Pose
from robots.adapters.vda5050.messages import State
from robots.adapters.vda5050.settings import Settings
from robots.wire import FaultLevel, RobotFault, SymbolicFact, Telemetry

NEAR_M = 0.5
"""A vehicle this close to the pose before a place is near it (our choice)."""


def facts_of(
    robot: str, pose: Pose | None, holding: str | None, settings: Settings
) -> tuple[SymbolicFact, ...]:
    """What the robot knows of itself: its gripper, and the place that it is near, if any."""
    facts = [_fact("robot_attribute", robot, "gripper", "full" if holding else "empty")]
    if holding:
        facts.append(_fact("in", holding, robot))
    if pose is not None and (place := place_near(pose, settings)) is not None:
        facts.append(_fact("near", robot, place))
    return tuple(facts)


def place_near(pose: Pose, settings: Settings) -> str | None:
    """The nearest place that the pose is before, or docked at; None if there is none within `NEAR_M`."""
    away = {
        name: min(
            dist(pose[:2], place.pose(near=pose[:2])[:2]),
            dist(pose[:2], place.pose(dock=True, near=pose[:2])[:2]),
        )
        for name, place in settings.places.items()
    }
    nearest = min(away, key=lambda name: away[name], default=None)
    return nearest if nearest is not None and away[nearest] <= NEAR_M else None


def telemetry_of(
    state: State, pose: Pose, *, at_s: float, holding: str | None, goal: Pose | None
) -> Telemetry:
    """:param goal: of the current packet; None without one."""
    return Telemetry(
        at_s=at_s,
        x_m=pose[0],
        y_m=pose[1],
        heading_rad=pose[2],
        holding=holding,
        battery=min(1.0, max(0.0, state.power_supply.state_of_charge / 100.0)),
        charging=state.power_supply.charging,
        degraded=tuple(_troubles(state)),
        goal_m=None if goal is None else dist(pose[:2], goal[:2]),
    )


MAX_FAULTS = 32


def faults_of(state: State) -> tuple[RobotFault, ...]:
    """The vehicle's errors in its own words, the gravest first, and its emergency stop."""
    stop = state.safety_state.active_emergency_stop
    faults = [
        RobotFault(
            level=FaultLevel(error.error_level.lower()),
            type=error.error_type[:128],
            text=(error.error_description or error.error_hint or "")[:1024],
        )
        for error in state.errors
    ]
    if stop != "NONE":
        faults.append(RobotFault(level=FaultLevel.FATAL, type="emergency stop", text=stop[:1024]))
    order = list(FaultLevel)
    return tuple(sorted(faults, key=lambda one: -order.index(one.level))[:MAX_FAULTS])


def _troubles(state: State) -> list[str]:
    troubles = [f"{error.error_level.lower()}: {error.words}" for error in state.errors]
    if state.safety_state.active_emergency_stop != "NONE":
        troubles.append("emergency stop")
    if state.safety_state.field_violation:
        troubles.append("protective field violated")
    if not state.operating_mode.takes_orders:
        troubles.append(f"operating mode {state.operating_mode}")
    return troubles


def _fact(predicate: str, *args: str) -> SymbolicFact:
    return SymbolicFact(predicate=predicate, args=args)
