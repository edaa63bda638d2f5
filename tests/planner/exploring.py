"""Every order of events that robots may bring about who carry out a plan-net alone: an oracle for small ones.

A robot starts its part of its next action when it senses all it awaits and is cleared for what the plan-net
says is kept by clearance. An action deletes when its first robot starts, has its effects when its last one
ends, and needs its conditions all the while.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from planner import Fact, Keeping, KnowledgeBase, PlanNet, PlanNetAction
from planner.plan_nets.synchronisation import awaits_of

Progress = tuple[int, ...]
"""Per robot: twice the number of its parts that have ended, plus one while a part runs."""


@dataclass(frozen=True, slots=True)
class State:
    progress: Progress
    facts: frozenset[Fact]


def first_fault(
    plan_net: PlanNet, facts: frozenset[Fact], objects: Mapping[str, str], knowledge_base: KnowledgeBase
) -> str | None:
    """What goes wrong in some order of events, or None if nothing does in any."""
    explorer = _Explorer(plan_net, awaits_of(plan_net, objects, knowledge_base))
    start = State((0,) * len(plan_net.robots), facts)
    seen = {start}
    stack = [start]
    while stack:
        state = stack.pop()
        following = []
        for step in explorer.steps(state):
            if isinstance(step, str):
                return step
            following.append(step)
        if not following and (fault := explorer.fault_at_the_end(state)) is not None:
            return fault
        stack += [step for step in following if step not in seen]
        seen.update(following)
    return None


class _Explorer:
    def __init__(self, plan_net: PlanNet, awaits: Mapping[tuple[str, str], tuple[Fact, ...]]) -> None:
        self._plan_net = plan_net
        self._awaits = awaits
        self._scripts = {robot: plan_net.of_robot(robot) for robot in plan_net.robots}
        self._before = {
            action.id: [o for o in plan_net.orderings if o.after == action.id] for action in plan_net.actions
        }

    def steps(self, state: State) -> Iterator[State | str]:
        for place, (robot, script) in enumerate(self._scripts.items()):
            done, runs = divmod(state.progress[place], 2)
            if done == len(script):
                continue
            action = script[done]
            moved = tuple(count + (at == place) for at, count in enumerate(state.progress))
            if runs:
                ends = self._has_ended(action, moved)
                yield State(moved, state.facts | set(action.effects) if ends else state.facts)
            elif self._may_start(action, robot, state):
                yield self._start_fault(action, state) or State(moved, self._started(action, state))

    def fault_at_the_end(self, state: State) -> str | None:
        for place, (robot, script) in enumerate(self._scripts.items()):
            if state.progress[place] < 2 * len(script):
                return f"{robot} waits for ever before {script[state.progress[place] // 2].id}"
        return next(
            (f"the robots end without {goal}" for goal in self._plan_net.goals if goal not in state.facts),
            None,
        )

    def _may_start(self, action: PlanNetAction, robot: str, state: State) -> bool:
        cleared = [o.before for o in self._before[action.id] if o.kept_by is Keeping.CLEARANCE]
        return state.facts.issuperset(self._awaits.get((action.id, robot), ())) and all(
            self._has_ended(self._plan_net.action(before), state.progress) for before in cleared
        )

    def _start_fault(self, action: PlanNetAction, state: State) -> str | None:
        for ordering in self._before[action.id]:
            if not self._has_ended(self._plan_net.action(ordering.before), state.progress):
                return f"{action.id} may start before {ordering.before} has ended"
        if self._has_begun(action, state.progress):
            return None
        for fact in action.preconditions:
            if fact not in state.facts:
                return f"{action.id} may start while {fact} does not hold"
        for other in self._plan_net.actions:
            runs = self._has_begun(other, state.progress) and not self._has_ended(other, state.progress)
            needs = set(other.preconditions) - set(other.deletes)
            if runs and other is not action and not needs.isdisjoint(action.deletes):
                return f"{action.id} may start while {other.id} needs what it deletes"
        return None

    def _started(self, action: PlanNetAction, state: State) -> frozenset[Fact]:
        return state.facts if self._has_begun(action, state.progress) else state.facts - set(action.deletes)

    def _has_begun(self, action: PlanNetAction, progress: Progress) -> bool:
        return any(progress[place] > 2 * index for place, index in self._parts(action))

    def _has_ended(self, action: PlanNetAction, progress: Progress) -> bool:
        return all(progress[place] >= 2 * index + 2 for place, index in self._parts(action))

    def _parts(self, action: PlanNetAction) -> Iterator[tuple[int, int]]:
        """For each of its robots: the robot's place and the action's in the robot's script."""
        for place, (robot, script) in enumerate(self._scripts.items()):
            if robot in action.agents:
                yield place, script.index(action)
