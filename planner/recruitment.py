"""Why each robot of a plan was chosen, in an operator's words (MACTA §4: recruiting is part of planning)."""

from collections.abc import Sequence

from planner.knowledge import GroundAction
from planner.statics import Statics


def recruitment_of(actions: Sequence[GroundAction], statics: Statics) -> dict[str, str]:
    """A sentence for each robot: what it is to do and can, what it reaches, and who else would qualify."""
    robots = sorted({agent for action in actions for agent in action.agents})
    return {robot: _sentence(robot, actions, statics) for robot in robots}


def _sentence(robot: str, actions: Sequence[GroundAction], statics: Statics) -> str:
    mine = [action for action in actions if robot in action.agents]
    tags = list(dict.fromkeys(action.tag for action in mine))
    used = {
        arg for action in mine for fact in action.preconditions if fact in statics.facts for arg in fact.args
    }
    places = sorted(used - {robot} - set(tags))
    others = [
        other
        for other in statics.robots
        if other != robot and all(statics.holds_for(other, action.preconditions, robot) for action in mine)
    ]
    alone = "no other robot qualifies"
    rivals = f"{_list(others)} would qualify too, the plan found has no need of it" if others else alone
    return f"can {_list(tags)} and serves {_list(places)}; {rivals}"


def _list(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}" if names else "nothing"
