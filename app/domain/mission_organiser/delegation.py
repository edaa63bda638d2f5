"""Which legs of a robot's script another robot may do in its stead, and who: written into the script if it is granted.

A leg begins with a drive of a robot that holds nothing and ends before its next such drive, or with its script. What
the plan-net proves still holds if another robot does it (our choice of conditions):

- it is of that robot alone, and waits for no clearance, which only the robot of the script would be given;
- it does more than drive, and no goal and no other robot depends on what it makes true of the robot itself;
- what its actions require of the robot and do not bring about themselves holds for the other robot by the present
  facts, but for where it stands and that its jaws are empty, which it sees itself; and that one senses as much.

Both robots have homes of their own, where no plan takes others: the one drives there before it calls the others, the
other when it has done the leg, so that no place that the plan-net counts as clear is in fact taken by one of them.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence

from app.domain.mission_organiser.synchronisation import clearances
from app.domain.world_model.beliefs import EMPTY, GRIPPER, OBJECT_POSITION, ROBOT_ATTRIBUTE, ROBOT_POSITION
from planner import GOAL, Fact, PlanNet, PlanNetAction, Senses
from robots.wire import DelegableLeg

CALL_S = 90.0
"""What it takes to make way, to call the others and to drive home again, beside the leg itself (our choice)."""
TIME_FACTOR = 2.0
"""How much longer a leg may take another robot, which comes from elsewhere (our choice)."""

Leg = Sequence[PlanNetAction]


def delegable_legs(
    plan_net: PlanNet,
    robot: str,
    tags: Mapping[str, str],
    *,
    facts: Collection[Fact],
    repertoires: Mapping[str, Collection[str]],
    delegating: Collection[str],
    senses: Senses,
) -> tuple[DelegableLeg, ...]:
    """The legs of the robot's script that others may do, each with at least one who may.

    :param tags: action id → the tag of the robot's packet for it.
    :param facts: of the world at present.
    :param delegating: the robots that pass on legs and take them, and have a home.
    """
    if robot not in delegating:
        return ()
    legs = []
    for leg in _legs(plan_net, robot, facts):
        if not _can_be_passed_on(plan_net, leg, robot):
            continue
        needed = {tags[action.id] for action in leg}
        takers = tuple(
            other
            for other in sorted(delegating)
            if other != robot
            and needed <= set(repertoires.get(other, ()))
            and _holds_for(other, leg, robot, facts)
            and _senses_as_much(other, robot, senses)
        )
        if takers:
            ids = tuple(action.id for action in leg)
            legs.append(DelegableLeg(id=f"leg_{ids[0]}", packets=ids, robots=takers))
    return tuple(legs)


def delegation_s(plan_net: PlanNet, legs: Collection[DelegableLeg]) -> float:
    """By how much the longest of the legs may end later because another robot does it; 0 without any."""
    works_s = (sum(plan_net.action(one).duration_s for one in leg.packets) for leg in legs)
    return max((CALL_S + TIME_FACTOR * work_s for work_s in works_s), default=0.0)


def _legs(plan_net: PlanNet, robot: str, facts: Collection[Fact]) -> Iterator[Leg]:
    """The robot's actions, cut before each drive that it begins with empty jaws; the last ends with empty jaws."""
    held = {fact.args[0] for fact in facts if _is_held(fact, robot)}
    leg: list[PlanNetAction] | None = None
    for action in plan_net.of_robot(robot):
        if not held and _is_drive(action, robot):
            if leg is not None:
                yield leg
            leg = []
        if leg is not None:
            leg.append(action)
        held -= {fact.args[0] for fact in action.deletes if _is_held(fact, robot)}
        held |= {fact.args[0] for fact in action.effects if _is_held(fact, robot)}
    if leg is not None and not held:
        yield leg


def _is_held(fact: Fact, robot: str) -> bool:
    return fact.predicate == OBJECT_POSITION and fact.args[2] == robot


def _is_drive(action: PlanNetAction, robot: str) -> bool:
    """True if the action takes the robot from one place to another, and nothing else with it."""
    begins = _positions(action.deletes, robot)
    ends = _positions(action.effects, robot)
    moves = [fact for fact in action.effects if fact.predicate == OBJECT_POSITION]
    return bool(begins and ends) and begins != ends and not moves


def _positions(facts: Collection[Fact], robot: str) -> set[str]:
    return {fact.args[2] for fact in facts if fact.predicate == ROBOT_POSITION and fact.args[0] == robot}


def _can_be_passed_on(plan_net: PlanNet, leg: Leg, robot: str) -> bool:
    """Whether another robot could do it, whoever that is.

    Our choice: not if an action of it has phases, which are not known as drives and waits of the robot alone, nor if
    one waits for a time, which the service tells.
    """
    if any(action.phase or action.not_before_s > 0 for action in leg):
        return False
    ids = {action.id for action in leg}
    agents = {action.id: action.agents for action in plan_net.actions}
    cleared = clearances(plan_net)
    if any(action.agents != (robot,) for action in leg) or all(_is_drive(action, robot) for action in leg):
        return False
    if any(agents[one] != (robot,) for action in leg for one in cleared.get(action.id, ())):
        return False
    return all(
        link.fact.predicate == ROBOT_POSITION or link.fact in leg[0].preconditions
        if link.consumer != GOAL and agents[link.consumer] == (robot,)
        else robot not in link.fact.args
        for link in plan_net.causal_links
        if link.producer in ids and link.consumer not in ids and robot in link.fact.args
    )


def _holds_for(other: str, leg: Leg, robot: str, facts: Collection[Fact]) -> bool:
    """Whether what the leg requires of its robot is true of another now."""
    made = set[Fact]()
    for action in leg:
        for fact in action.preconditions:
            if robot not in fact.args or fact in made:
                continue
            is_position = action is leg[0] and fact.predicate == ROBOT_POSITION
            is_empty = fact == Fact(ROBOT_ATTRIBUTE, (robot, GRIPPER, EMPTY))
            theirs = Fact(fact.predicate, tuple(other if arg == robot else arg for arg in fact.args))
            if not (is_position or is_empty or theirs in facts):
                return False
        made = (made - set(action.deletes)) | set(action.effects)
    return True


def _senses_as_much(other: str, robot: str, senses: Senses) -> bool:
    return other not in senses or (robot in senses and senses[robot] <= senses[other])
