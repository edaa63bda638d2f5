"""The legs of a plan-net: what its robots do for one goal, without the way there (MACTA §6).

Robots that carry out an action together do one leg together; so do those that are linked by such actions.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.knowledge.phrases import enumeration
from planner.plan_nets.plan_net import GOAL, INITIAL, CausalLink, PlanNet, PlanNetAction
from planner.problem.interface import PlanningProblem
from planner.problem.static_facts import StaticFacts


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanLeg:
    """What a team does for a goal.

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
    goals = goals_by_action(plan_net, statics.things)
    of_goal: dict[Fact, list[PlanNetAction]] = defaultdict(list)
    for action in sorted(plan_net.actions, key=lambda one: one.earliest_start_s):
        if action.id in goals and statics.peripherals.isdisjoint(action.agents):
            of_goal[goals[action.id]].append(action)
    found = [
        leg
        for goal, actions in of_goal.items()
        for team in _teams(actions)
        if (leg := _leg(goal, team, actions, statics.things))
    ]
    return tuple(
        sorted(found, key=lambda leg: min(mine[0].earliest_start_s for mine in leg.actions.values()))
    )


def barred_actions(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> Mapping[str, str]:
    """The actions that may not serve their goal, each with why, in words: by a robot that may not be recruited for it
    (`PlanningProblem.recruits`), or at a place that is to be avoided for it (`avoids`).

    Robots that only make way for others who work for a goal do not serve it.
    """
    return {action: words for action, _, words in _barred(plan_net, problem, knowledge_base)}


def barred_goals(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> Mapping[Fact, str]:
    """The goals that actions serve which may not (`barred_actions`), each with why."""
    return {goal: words for _, goal, words in _barred(plan_net, problem, knowledge_base)}


def _barred(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> Iterator[tuple[str, Fact, str]]:
    """The actions that may not serve their goal, with the goal and why."""
    if not problem.recruits and not problem.avoids:
        return
    statics = StaticFacts(knowledge_base, problem)
    goals = goals_by_action(plan_net, statics.things)
    workers: dict[Fact, set[str]] = defaultdict(set)
    for action in plan_net.actions:
        if action.id not in goals or _is_setup(action, statics.things):
            continue
        things = statics.things.intersection(goals[action.id].args)
        if not things or not things.isdisjoint(action.arguments.values()):
            workers[goals[action.id]].update(action.agents)
    for action in plan_net.actions:
        goal = goals.get(action.id)
        if goal is None or workers[goal].isdisjoint(action.agents):
            continue
        allowed = problem.recruits.get(goal)
        others = () if allowed is None else set(action.agents) - allowed - statics.peripherals
        named = problem.avoids.get(goal, frozenset()).intersection(action.arguments.values())
        places = {place for place in named if not _only_leaves(action, place, statics.things)}
        if others:
            yield action.id, goal, f"{enumeration(sorted(others))} may not be recruited for {goal}"
        elif places:
            yield action.id, goal, f"{enumeration(sorted(places))} is not to be used for {goal}"


def _only_leaves(action: PlanNetAction, place: str, things: frozenset[str]) -> bool:
    """True if robots are at the place before the action, as for another goal, and neither they nor a thing after it."""
    movable = things.union(action.agents)

    def is_there(fact: Fact) -> bool:
        return place in fact.args and not movable.isdisjoint(fact.args)

    return any(map(is_there, action.deletes)) and not any(map(is_there, action.effects))


def goals_by_action(plan_net: PlanNet, things: frozenset[str]) -> Mapping[str, Fact]:
    """The goal that each action is done for: the one about what it handles.

    Of others it is the goal where their causal links lead, first those about what is handled. Not every goal that comes
    after an action in some way is what it is done for: a robot's gripper is empty again after each.

    :param things: what is moved or worked on.
    """
    about = {thing: goal for goal in reversed(plan_net.goals) for thing in things.intersection(goal.args)}
    going: dict[str, list[CausalLink]] = defaultdict(list)
    for link in plan_net.causal_links:
        if link.producer != INITIAL:
            going[link.producer].append(link)
    starts_s = {action.id: action.earliest_start_s for action in plan_net.actions}
    found: dict[str, Fact] = {}
    # NOTE: actions are in the order of a linearisation, so consumers come after producers.
    for action in reversed(plan_net.actions):
        handled = [about[name] for name in action.arguments.values() if name in about]
        links = [link for link in going[action.id] if link.consumer == GOAL or link.consumer in found]
        if handled:
            found[action.id] = handled[0]
        elif links:
            first = min(
                links, key=lambda link: (things.isdisjoint(link.fact.args), *_soonest(link, starts_s))
            )
            found[action.id] = first.fact if first.consumer == GOAL else found[first.consumer]
    return found


def _soonest(link: CausalLink, starts_s: Mapping[str, float]) -> tuple[bool, float, CausalLink]:
    """Orders links by when their consumers begin, those that achieve a goal first."""
    return link.consumer != GOAL, starts_s.get(link.consumer, 0.0), link


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
