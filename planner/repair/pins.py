"""What people pin of a plan, by goal: who works for it, which places are used for it, from when on it is achieved, and
after which other goals.

`edit` plans the pinned problem beginning with the old plan (`PlanningRequest.like`), so that what the pins leave as it
is stays as it is where that pays.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf

from planner.errors import PlannerError
from planner.explanation.legs import barred_actions, barred_goals, goals_by_action
from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.knowledge.phrases import enumeration
from planner.plan_nets.orders import Orders, cycle_in
from planner.plan_nets.plan_net import GOAL, INITIAL, PlanNet, PlanNetAction
from planner.plan_nets.validation import broken_orders
from planner.problem.interface import (
    KEPT_S,
    UNOBSERVED,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
)
from planner.problem.solving import MIN_SHARE_S
from planner.problem.static_facts import StaticFacts
from planner.relaxation import is_relaxed_reachable
from planner.repair.plan_repair import Course, Repair, repair
from planner.repair.remaining import NOT_BEGUN, Remaining


class CannotPin(PlannerError):
    """Something of a plan cannot be pinned; the message says why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pin:
    """What is pinned for a goal.

    :param barred: robots that are not recruited for it.
    :param avoided: places that nothing done for it uses.
    :param not_before_s: seconds from the plan's start before which it is not achieved.
    :param after: goals after which it comes true.
    """

    goal: Fact
    barred: frozenset[str] = frozenset()
    avoided: frozenset[str] = frozenset()
    not_before_s: float = 0.0
    after: frozenset[Fact] = frozenset()


def pinned(problem: PlanningProblem, pins: Iterable[Pin], knowledge_base: KnowledgeBase) -> PlanningProblem:
    """The problem whose plans keep to the pins; pins for goals that it does not have change nothing."""
    robots = frozenset(StaticFacts(knowledge_base, problem).robots)
    recruits, avoids, not_before_s = dict(problem.recruits), dict(problem.avoids), dict(problem.not_before_s)
    after = dict(problem.after)
    for pin in pins:
        goal = pin.goal
        if goal not in problem.goals:
            continue
        if pin.barred:
            recruits[goal] = recruits.get(goal, robots) - pin.barred
        if pin.avoided:
            avoids[goal] = avoids.get(goal, frozenset()) | pin.avoided
        if pin.not_before_s > not_before_s.get(goal, 0.0):
            not_before_s[goal] = pin.not_before_s
        if earlier := pin.after.intersection(problem.goals):
            after[goal] = after.get(goal, frozenset()) | earlier
    return replace(problem, recruits=recruits, avoids=avoids, not_before_s=not_before_s, after=after)


class PlanHandles:
    """Finds what can be pinned of a plan-net: the goals that its actions serve, and who could do them instead."""

    def __init__(self, plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase) -> None:
        """:param problem: the one that the plan-net solves, with what is pinned already."""
        self._base = knowledge_base
        self._problem = problem
        self._statics = StaticFacts(knowledge_base, problem)
        self._actions = {action.id: action for action in plan_net.actions}
        self._goals = goals_by_action(plan_net, self._statics.things)
        self._achievers = {
            link.fact: link.producer for link in plan_net.causal_links if link.consumer == GOAL
        }

    def goal_of(self, action_id: str) -> Fact:
        """The goal that an action serves.

        :raises CannotPin: if there is no such action, or it serves no goal: it only makes way.
        """
        action = self._action(action_id)
        if action_id not in self._goals:
            raise CannotPin(
                f"{action_id} ({action.description}) serves no goal by itself; name an action that does"
            )
        return self._goals[action_id]

    def barred_for(self, action_id: str, robot: str) -> frozenset[str]:
        """The robots that are not to be recruited for the goal of an action so that this robot takes part in it.

        Those are whose part in the goal it could take and, if it works for the goal already, those that could take its
        part.

        :raises CannotPin: naming who can, if this robot cannot; if one of them has what the goal is about already.
        """
        goal = self.goal_of(action_id)
        action = self._actions[action_id]
        if robot in action.agents:
            return self._stand_ins(goal, robot)
        able = {agent: self._stand_ins(goal, agent) for agent in action.agents}
        for agent, stand_ins in able.items():
            if robot in stand_ins:
                barred = (stand_ins | {agent}) - {robot}
                self._refuse_holding(goal, barred)
                return barred
        who = enumeration(sorted({*action.agents}.union(*able.values())))
        raise CannotPin(
            f"{robot} cannot do what {enumeration(sorted(action.agents))} does for {_in_words(goal, self._base)} "
            f"({action.description}); {who} can"
        )

    def without(self, action_id: str, robot: str) -> frozenset[str]:
        """The robot that is not to be recruited for the goal of an action.

        :raises CannotPin: if it does nothing for that goal, nobody could take its part, or it has what the goal is
            about already.
        """
        goal = self.goal_of(action_id)
        if not self._part(goal, robot):
            raise CannotPin(
                f"{robot} does nothing for {_in_words(goal, self._base)}, the goal of {action_id}"
            )
        if not self._stand_ins(goal, robot):
            raise CannotPin(f"nobody can take the part of {robot} in {_in_words(goal, self._base)}")
        self._refuse_holding(goal, frozenset({robot}))
        return frozenset({robot})

    def _refuse_holding(self, goal: Fact, barred: frozenset[str]) -> None:
        """
        :raises CannotPin: if one of these robots carries what the goal is about: no other can go on with it.
        """
        things = self._statics.things.intersection(goal.args)
        for fact in sorted(self._problem.facts):
            if not barred.isdisjoint(fact.args) and (carried := things.intersection(fact.args)):
                robot, thing = min(barred.intersection(fact.args)), min(carried)
                raise CannotPin(
                    f"{robot} has {thing} already ({_in_words(fact, self._base)}); nobody else can go on with it"
                )

    def after(self, action_id: str, other_id: str) -> Fact:
        """The goal that another action serves, after which the goal of an action is to come true.

        :raises CannotPin: if it is the same goal.
        """
        goal, before = self.goal_of(action_id), self.goal_of(other_id)
        if goal == before:
            both = "is" if action_id == other_id else f"and {other_id} are both"
            raise CannotPin(
                f"{action_id} {both} done for {_in_words(goal, self._base)}, which cannot come after itself"
            )
        return before

    def refuse_contradictions(self, after: Orders) -> None:
        """
        :param after: by goal, the goals after which it is to come true; those pinned already and the stages count, too.
        :raises CannotPin: if goals would have to come after themselves, naming them and the actions that achieve them.
        """
        problem = self._problem
        asked = {
            goal: after.get(goal, frozenset()) | problem.after.get(goal, frozenset())
            for goal in {*after, *problem.after}
        }
        named = {goal for one, earlier in asked.items() for goal in (one, *earlier)}
        stage = {goal: problem.stages.get(goal, 0) for goal in named}
        staged = {
            goal: frozenset(one for one in named if stage[one] < stage[goal]) | asked.get(goal, frozenset())
            for goal in named
        }
        if cycle := cycle_in(staged):
            said = [
                f"{self._achieved(goal)} after {self._achieved(before)}"
                + ("" if before in asked.get(goal, frozenset()) else " by the stages of the goal")
                for goal, before in pairwise((*cycle, cycle[0]))
            ]
            raise CannotPin(f"these orders contradict each other: {'; '.join(said)}")

    def _achieved(self, goal: Fact) -> str:
        """The goal in words, with the action that achieves it."""
        achiever = self._achievers.get(goal, INITIAL)
        return _in_words(goal, self._base) + ("" if achiever == INITIAL else f" ({achiever})")

    def _action(self, action_id: str) -> PlanNetAction:
        if action_id not in self._actions:
            raise CannotPin(f"the plan has no action {action_id}; it has {', '.join(self._actions)}")
        return self._actions[action_id]

    def _part(self, goal: Fact, agent: str) -> tuple[PlanNetAction, ...]:
        """What an agent does for a goal."""
        return tuple(
            one for one in self._actions.values() if agent in one.agents and self._goals.get(one.id) == goal
        )

    def _stand_ins(self, goal: Fact, agent: str) -> frozenset[str]:
        """The robots that reach and can do all that an agent does for a goal."""
        needed = [fact for one in self._part(goal, agent) for fact in one.preconditions]
        return frozenset(
            robot
            for robot in self._statics.robots
            if robot != agent and self._statics.obstacle(robot, needed, agent) is None
        )


EDIT_EFFORT_S = 0.1
"""Time to improve an edited plan by default: an operator waits for it."""


def edit(
    engine: PlanningEngine,
    knowledge_base: KnowledgeBase,
    plan_net: PlanNet,
    problem: PlanningProblem,
    request: PlanningRequest,
    observer: Observer = UNOBSERVED,
) -> Repair:
    """The plan-net planned again for a problem that people have pinned something of, with as few changes as pays.

    :param problem: the pinned one, at the plan's start.
    :param request: its `effort_s` None: `EDIT_EFFORT_S`.
    """
    effort_s = EDIT_EFFORT_S if request.effort_s is None else request.effort_s
    request = replace(request, effort_s=effort_s)
    timer = request.timer()
    kept: Repair | None = None
    if not barred_actions(plan_net, problem, knowledge_base):  # everybody may go on as before, perhaps later
        is_kept_to = not broken_orders(plan_net, problem.after)
        kept = repair(
            engine, knowledge_base, plan_net, problem, NOT_BEGUN, request, observer, replans=is_kept_to
        )
        kept = replace(kept, course=Course.EDITED)
        if is_kept_to or timer.left_s < MIN_SHARE_S:
            return kept
    remaining = Remaining(plan_net, problem, NOT_BEGUN, knowledge_base)
    if hopeless := _without_a_way(problem, knowledge_base):
        return Repair.failed(Course.EDITED, "; ".join(hopeless.values()), remaining, 0.0)
    liking = replace(request, like=plan_net, time_limit_s=timer.left_s)
    edited = _keeping_to(engine.plan(problem, liking, observer), remaining)
    best = edited if kept is None else min(edited, kept, key=_cost)
    return replace(best, result=replace(best.result, planning_s=round(timer.elapsed_s, 4)))


def _keeping_to(found: PlanningResult, remaining: Remaining) -> Repair:
    """The engine's answer, without its plan-net if that does not keep to what is pinned."""
    problem, knowledge_base = remaining.problem, remaining.knowledge_base
    if found.plan_net is None:
        return Repair.of(Course.EDITED, found, remaining, found.planning_s)
    wrong = tuple(unkept_pins(found.plan_net, problem, knowledge_base).values())
    if wrong:
        reason = f"only a plan was found that does not keep to it: {wrong[0]}"
        return Repair.failed(Course.EDITED, reason, remaining, found.planning_s)
    return Repair.of(Course.EDITED, found, remaining, found.planning_s)


def _cost(edited: Repair) -> tuple[float, float]:
    """Seconds late, and of makespan, with what changes are worth; infinite without a plan."""
    if edited.plan_net is None:
        return inf, inf
    changes = 0 if edited.difference is None else edited.difference.changes
    return edited.plan_net.late_s, edited.plan_net.makespan_s + KEPT_S * changes


def unkept_pins(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> Mapping[Fact, str]:
    """The goals of which a plan does not keep what is pinned, each with how, in words."""
    found = dict(barred_goals(plan_net, problem, knowledge_base))
    for goal, before in broken_orders(plan_net, problem.after):
        words = f"{_in_words(goal, knowledge_base)} does not wait for {_in_words(before, knowledge_base)}"
        found.setdefault(goal, words)
    return found


def without_hopeless_pins(problem: PlanningProblem, knowledge_base: KnowledgeBase) -> PlanningProblem:
    """The problem with all robots and places for those goals that what may be used for them does not suffice for.

    Found by a relaxed search, so that a goal may be left for which there is no way all the same.
    """
    hopeless = _without_a_way(problem, knowledge_base)
    return replace(
        problem,
        recruits={goal: robots for goal, robots in problem.recruits.items() if goal not in hopeless},
        avoids={goal: places for goal, places in problem.avoids.items() if goal not in hopeless},
    )


def _without_a_way(problem: PlanningProblem, knowledge_base: KnowledgeBase) -> Mapping[Fact, str]:
    """The goals that what may be used for them does not suffice for, each in words.

    Robots that are not recruited stand somewhere, and only make way; what else is at places to avoid is left out.
    """
    agents = frozenset(knowledge_base.agents_among(problem.objects))
    statics = StaticFacts(knowledge_base, problem)
    found: dict[Fact, str] = {}
    for goal in problem.goals:
        allowed = problem.recruits.get(goal, agents) | statics.peripherals
        avoided = problem.avoids.get(goal, frozenset())
        if not avoided and allowed >= agents:
            continue
        able = statics.without(agents - allowed, driving=True)
        facts = frozenset(
            fact for fact in able.facts if avoided.isdisjoint(fact.args) or not agents.isdisjoint(fact.args)
        )
        alone = replace(able, goals=(goal,), facts=facts, recruits={}, avoids={})
        if not is_relaxed_reachable(knowledge_base, alone):
            without = enumeration(sorted({*avoided, *(agents - allowed)}))
            found[goal] = f"there is no way to {_in_words(goal, knowledge_base)} without {without}"
    return found


def _in_words(goal: Fact, knowledge_base: KnowledgeBase) -> str:
    """The goal as operators state it: in(sample_1, bay_7)."""
    predicate, args = knowledge_base.to_relation(goal)
    return str(Fact(predicate, args))
