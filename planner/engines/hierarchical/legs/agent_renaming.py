"""The same action by other agents of the class."""

from collections.abc import Mapping
from dataclasses import replace

from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.knowledge.operator import TEAM_SEPARATOR


def renamed(action: GroundAction, names: Mapping[str, str]) -> GroundAction:
    """The action with agents exchanged; what is not in `names` stays."""
    if all(old == new for old, new in names.items()):
        return action

    def of(facts: tuple[Fact, ...]) -> tuple[Fact, ...]:
        return tuple(Fact(f.predicate, tuple(names.get(arg, arg) for arg in f.args)) for f in facts)

    return replace(
        action,
        arguments={
            name: TEAM_SEPARATOR.join(names.get(part, part) for part in value.split(TEAM_SEPARATOR))
            for name, value in action.arguments.items()
        },
        agents=tuple(names.get(agent, agent) for agent in action.agents),
        preconditions=of(action.preconditions),
        deletes=of(action.deletes),
        intended_effects=of(action.intended_effects),
        other_effects=of(action.other_effects),
    )
