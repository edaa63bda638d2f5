"""How robots keep the plan-net's orderings: by facts that they await with their sensors, and by clearances.

A robot perceives the effects of another one's action (MACTA §3, "the
pre-condition for the next is encountered"; §5, no need for robots to communicate directly). Where that does not
suffice, or the robot does not sense it, it waits for clearance: a message that another action has ended, of the service
or, among robots that speak with each other, of the robots that have ended it. A time that an action is not to start
before is kept in the same way: the service clears it when the time has come.
"""

from collections import defaultdict
from collections.abc import Mapping

from planner import Keeping, PlanNet

_TIME = "time:"


def clearance_at(at_s: float) -> str:
    """What stands among the actions that a packet waits for if it waits for a time of the world's clock."""
    return f"{_TIME}{at_s:.3f}"


def time_of(awaited: str) -> float | None:
    """The time that a packet waits for; None if it waits for an action."""
    return float(awaited.removeprefix(_TIME)) if awaited.startswith(_TIME) else None


def message_count(plan_net: PlanNet) -> int:
    """The most messages of the service that robots wait for one after the other: the script, and clearances."""
    return 1 + len(clearances(plan_net)) + sum(action.not_before_s > 0 for action in plan_net.actions)


def clearances(plan_net: PlanNet) -> Mapping[str, tuple[str, ...]]:
    """For each action, those whose end must be reported to its robots by clearance before they start."""
    found: dict[str, list[str]] = defaultdict(list)
    for ordering in plan_net.orderings:
        # An ordering without a stated means is also kept by clearance.
        if ordering.kept_by not in (Keeping.ROBOT, Keeping.SENSING):
            found[ordering.after].append(ordering.before)
    return {action: tuple(before) for action, before in found.items()}
