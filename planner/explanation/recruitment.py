"""Why each robot of a plan was chosen, in an operator's words (MACTA §4: recruiting is part of planning)."""

from collections import defaultdict
from collections.abc import Mapping, Sequence

from planner.knowledge import GroundAction
from planner.knowledge.phrases import enumeration
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.problem.static_facts import StaticFacts

Action = GroundAction | PlanNetAction


def recruitment_of(actions: Sequence[Action], statics: StaticFacts) -> dict[str, str]:
    """A sentence for each robot: what it is to do and can, what it reaches, and who else would qualify."""
    work: dict[str, list[Action]] = defaultdict(list)
    for action in actions:
        for agent in action.agents:
            work[agent].append(action)
    return {robot: _sentence(robot, work, statics) for robot in sorted(work)}


def robots_by_work(plan_net: PlanNet) -> list[str]:
    """The plan's robots, those with the most to do first."""
    work_s: dict[str, float] = defaultdict(float)
    for action in plan_net.actions:
        for robot in action.agents:
            work_s[robot] += action.duration_s
    return sorted(work_s, key=lambda robot: (-work_s[robot], robot))


def _sentence(robot: str, work: Mapping[str, Sequence[Action]], statics: StaticFacts) -> str:
    mine = work[robot]
    tags = list(dict.fromkeys(action.tag for action in mine))
    needed = {fact for action in mine for fact in action.preconditions if fact in statics.facts}
    places = sorted({arg for fact in needed for arg in fact.args} - {robot} - set(tags))
    others = [
        other for other in statics.robots if other != robot and statics.obstacle(other, needed, robot) is None
    ]
    idle = [other for other in others if other not in work]
    busy = [other for other in others if other in work]
    rivals = [
        f"{enumeration(idle)} would qualify too, the plan found has no need of it" if idle else "",
        f"{enumeration(busy)} would qualify too but {'has' if len(busy) == 1 else 'have'} other work"
        if busy
        else "",
    ]
    serves = f" and serves {enumeration(places)}" if places else ""
    alone = "no other robot qualifies"
    return f"can {enumeration(tags, most=len(tags))}{serves}; {'; '.join(filter(None, rivals)) or alone}"
