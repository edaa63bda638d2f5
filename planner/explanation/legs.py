"""The legs of a plan-net: what its robots do for one goal, without the way there (MACTA §6).

Robots that carry out an action together do one leg together; so do those that are linked by such actions.
"""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

from planner.explanation.purpose import purposes
from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.problem.interface import PlanningProblem
from planner.problem.static_facts import StaticFacts


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanLeg:
    """What a team does for a goal; an action that serves several goals counts for the first.

    :param actions: by robot of the team, its actions in order, from the first that does more than bring it into place.
    """

    goal: Fact
    actions: Mapping[str, tuple[PlanNetAction, ...]]

    @property
    def team(self) -> tuple[str, ...]:
        return tuple(self.actions)


def legs_in(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> tuple[PlanLeg, ...]:
    """The legs in the order of their first actions. What robots do only to make way, or to be somewhere, is none."""
    statics = StaticFacts(knowledge_base, problem)
    served = purposes(plan_net, knowledge_base)
    of_goal: dict[Fact, list[PlanNetAction]] = defaultdict(list)
    for action in sorted(plan_net.actions, key=lambda one: one.earliest_start_s):
        if served[action.id].goals and statics.peripherals.isdisjoint(action.agents):
            of_goal[served[action.id].goals[0]].append(action)
    found = [
        leg
        for goal, actions in of_goal.items()
        for team in _teams(actions)
        if (leg := _leg(goal, team, actions, statics.things))
    ]
    return tuple(
        sorted(found, key=lambda leg: min(mine[0].earliest_start_s for mine in leg.actions.values()))
    )


def _teams(actions: list[PlanNetAction]) -> list[tuple[str, ...]]:
    """The robots by whom they work with."""
    teams: list[dict[str, None]] = []
    for action in actions:
        joined = [team for team in teams if not team.keys().isdisjoint(action.agents)]
        teams = [team for team in teams if team not in joined]
        teams.append(dict.fromkeys([*(robot for team in joined for robot in team), *action.agents]))
    return [tuple(team) for team in teams]


def _leg(
    goal: Fact, team: tuple[str, ...], actions: list[PlanNetAction], things: frozenset[str]
) -> PlanLeg | None:
    parts: dict[str, tuple[PlanNetAction, ...]] = {}
    for robot in team:
        mine = [action for action in actions if robot in action.agents]
        first = next((n for n, action in enumerate(mine) if not _is_setup(action, things)), None)
        if first is None:
            return None
        parts[robot] = tuple(mine[first:])
    return PlanLeg(goal=goal, actions=parts)


def _is_setup(action: PlanNetAction, things: frozenset[str]) -> bool:
    """True if the action only brings its one robot into place."""
    return len(action.agents) == 1 and all(
        action.agents[0] in fact.args and things.isdisjoint(fact.args) for fact in action.intended_effects
    )
