"""What the scripts allow: robots run their own actions in order and keep in step only by what they sense.

The plan-net's orderings between robots are not told to them. A robot starts its next action as soon as those
of its pre-conditions that another robot brings about, and that can be sensed, are true (DESIGN: the next
robot's sensor pre-condition does it). Every interleaving of starts and ends must therefore work. Deletes
happen at the start, effects at the end.

Events that have to do with nothing any other robot still does are taken at once; only the others are
interleaved.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.plan_net import INITIAL, PlanNet, PlanNetAction

STATE_LIMIT = 200_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Violation:
    """An order of events the scripts allow and that goes wrong. `fact` and `agents` say what about and
    who."""

    reason: str
    fact: Fact | None = None
    agents: frozenset[str] = frozenset()


Position = tuple[int, ...]
"""Per robot: twice the number of its actions that have ended, plus one while an action runs."""


def first_violation(
    plan_net: PlanNet, facts: frozenset[Fact], objects: Mapping[str, str], knowledge_base: KnowledgeBase
) -> Violation | None:
    """Explore every order of events the scripts allow; the first that goes wrong, or None."""
    return _Explorer(plan_net, facts, objects, knowledge_base).explore()


class _Explorer:
    def __init__(
        self,
        plan_net: PlanNet,
        facts: frozenset[Fact],
        objects: Mapping[str, str],
        knowledge_base: KnowledgeBase,
    ) -> None:
        self._plan_net, self._facts = plan_net, facts
        self._robots = plan_net.robots
        self._scripts = tuple(plan_net.of_robot(robot) for robot in self._robots)
        self._producers = {(link.consumer, link.fact): link.producer for link in plan_net.causal_links}
        self._actions = {action.id: action for action in plan_net.actions}
        self._awaits = {a.id: frozenset(self._foreign(a)) for a in plan_net.actions}
        self._sensed = {
            fact: knowledge_base.is_sensed(fact, objects)
            for facts_ in self._awaits.values()
            for fact in facts_
        }
        self._footprints = {
            a.id: (frozenset((*a.preconditions, *a.deletes, *a.effects)), frozenset((*a.deletes, *a.effects)))
            for a in plan_net.actions
        }
        self._remaining: dict[tuple[int, int], tuple[frozenset[Fact], frozenset[Fact]]] = {}

    def _foreign(self, action: PlanNetAction) -> Iterator[Fact]:
        """The conditions another robot's action brings about."""
        for fact in action.preconditions:
            producer = self._producers.get((action.id, fact), INITIAL)
            if producer != INITIAL and not set(self._actions[producer].agents) & set(action.agents):
                yield fact

    def explore(self) -> Violation | None:
        for action_id, awaited in self._awaits.items():
            for fact in sorted(awaited):
                if not self._sensed[fact]:
                    action = self._actions[action_id]
                    reason = (
                        f"{action.agents[0]} cannot sense {fact}, which it must await before {action.tag}"
                    )
                    return Violation(reason=reason, fact=fact, agents=frozenset(action.agents))
        start = (0,) * len(self._robots)
        seen = {(start, self._facts)}
        stack: list[tuple[Position, frozenset[Fact]]] = [(start, self._facts)]
        while stack:
            position, state = stack.pop()
            following, violation = self._step(position, state)
            if violation is not None:
                return violation
            for successor in following:
                if successor not in seen:
                    seen.add(successor)
                    stack.append(successor)
            if len(seen) > STATE_LIMIT:
                return Violation(reason="the robots' orders of events are too many to check")
        return None

    def _step(
        self, position: Position, state: frozenset[Fact]
    ) -> tuple[list[tuple[Position, frozenset[Fact]]], Violation | None]:
        following: list[tuple[Position, frozenset[Fact]]] = []
        for action, starts in self._enabled(position, state):
            if starts and (violation := self._start_fault(action, position, state)) is not None:
                return [], violation
            changed = state - set(action.deletes) if starts else state | set(action.effects)
            moved = tuple(
                p + (robot in action.agents) for p, robot in zip(position, self._robots, strict=True)
            )
            if self._is_private(action, position):
                return [(moved, changed)], None
            following.append((moved, changed))
        if not following:
            return [], self._end_fault(position, state)
        return following, None

    def _enabled(self, position: Position, state: frozenset[Fact]) -> Iterator[tuple[PlanNetAction, bool]]:
        """The actions that can end (False) or start (True) now."""
        for robot, name in enumerate(self._robots):
            action = self._current(robot, position)
            if action is None or action.agents[0] != name:
                continue
            places = [self._robots.index(agent) for agent in action.agents]
            if any(self._current(place, position) is not action for place in places):
                continue
            if position[places[0]] % 2:
                yield action, False
            elif self._awaits[action.id] <= state:
                yield action, True

    def _current(self, robot: int, position: Position) -> PlanNetAction | None:
        script = self._scripts[robot]
        return script[position[robot] // 2] if position[robot] // 2 < len(script) else None

    def _start_fault(
        self, action: PlanNetAction, position: Position, state: frozenset[Fact]
    ) -> Violation | None:
        for fact in action.preconditions:
            if fact not in state:
                reason = f"{', '.join(action.agents)} may start {action.tag} while {fact} does not hold"
                return Violation(reason=reason, fact=fact, agents=self._about(fact, action))
        for robot in range(len(self._robots)):
            other = self._current(robot, position)
            if other is None or other is action or not position[robot] % 2:
                continue
            for fact in action.deletes:
                if fact in other.preconditions and fact not in other.deletes:
                    who = ", ".join(action.agents)
                    reason = f"{who} may start {action.tag} while {other.agents[0]} needs {fact}"
                    return Violation(reason=reason, fact=fact, agents=self._about(fact, action))
        return None

    def _end_fault(self, position: Position, state: frozenset[Fact]) -> Violation | None:
        for robot, name in enumerate(self._robots):
            action = self._current(robot, position)
            if action is not None:
                missing = sorted(self._awaits[action.id] - state)
                fact = missing[0] if missing else None
                reason = f"{name} may wait for ever for {fact or 'its partners'} before {action.tag}"
                return Violation(reason=reason, fact=fact, agents=self._about(fact, action))
        for goal in self._plan_net.goals:
            if goal not in state:
                return Violation(
                    reason=f"the robots may end without {goal}", fact=goal, agents=self._about(goal, None)
                )
        return None

    def _about(self, fact: Fact | None, action: PlanNetAction | None) -> frozenset[str]:
        """The robots that have to do with the fact."""
        users = [
            a
            for a in self._plan_net.actions
            if fact in a.preconditions or fact in a.effects or fact in a.deletes
        ]
        return frozenset(agent for a in [*users, *([action] if action else [])] for agent in a.agents)

    def _is_private(self, action: PlanNetAction, position: Position) -> bool:
        """True if nothing the other robots still do touches what this action touches."""
        touched, changed = self._footprints[action.id]
        for robot, name in enumerate(self._robots):
            if name not in action.agents:
                theirs, theirs_changed = self._rest(robot, position[robot] // 2)
                if not changed.isdisjoint(theirs) or not theirs_changed.isdisjoint(touched):
                    return False
        return True

    def _rest(self, robot: int, index: int) -> tuple[frozenset[Fact], frozenset[Fact]]:
        """What a robot's actions from `index` on touch, and what they change."""
        if (robot, index) not in self._remaining:
            parts = [self._footprints[action.id] for action in self._scripts[robot][index:]]
            self._remaining[robot, index] = (
                frozenset().union(*(part[0] for part in parts)),
                frozenset().union(*(part[1] for part in parts)),
            )
        return self._remaining[robot, index]
