"""Carries a plan-net of single robots out as they do alone, and watches for what a plan must not let happen.

Independent of the planner's proofs: a robot does its own actions in order and waits for nothing but the facts it is to
sense and the clearances of `kept_by`. Actions take as long as chance has it.
"""

import heapq
import random
from collections import Counter
from collections.abc import Callable

from planner import Fact, Keeping, KnowledgeBase, PlanNet, PlanNetAction, PlanningProblem
from planner.plan_nets.synchronisation import awaits_of

FACTORS = (0.05, 0.5, 1.0, 2.0, 10.0)
"""How long an action may take, by its expected duration."""


class Execution:
    """One execution; `fault` is the first thing that went wrong, None if the goals were achieved.

    `achieved_s`: when each fact was brought about last.
    """

    def __init__(
        self,
        plan_net: PlanNet,
        problem: PlanningProblem,
        knowledge_base: KnowledgeBase,
        *,
        seed: int,
        takes_s: Callable[[PlanNetAction], float] | None = None,
    ) -> None:
        """:param takes_s: how long an action takes; None: one of `FACTORS` times the expected duration."""
        self.fault: str | None = None
        self.achieved_s: dict[Fact, float] = {}
        self._takes_s = takes_s or self._by_chance
        self._chance = random.Random(seed)
        self._state = set(problem.facts)
        self._needed: Counter[Fact] = Counter()
        self._ended: set[str] = set()
        self._awaits = awaits_of(plan_net, problem.objects, knowledge_base)
        self._cleared = {
            action.id: {
                o.before
                for o in plan_net.orderings
                if o.after == action.id and o.kept_by is Keeping.CLEARANCE
            }
            for action in plan_net.actions
        }
        self._waiting = {robot: list(plan_net.of_robot(robot)) for robot in plan_net.robots}
        self._running: list[tuple[float, int, PlanNetAction]] = []
        self._run(plan_net)

    def _run(self, plan_net: PlanNet) -> None:
        now_s = 0.0
        while self.fault is None:
            self._begin(now_s)
            if not self._running or self.fault is not None:
                break
            now_s, _, action = heapq.heappop(self._running)
            self._end(action, now_s)
        left = [actions[0].id for actions in self._waiting.values() if actions]
        if self.fault is None and left:
            self.fault = f"nothing goes on: {', '.join(left)} wait"
        missing = [goal for goal in plan_net.goals if goal not in self._state]
        if self.fault is None and missing:
            self.fault = f"{missing[0]} is not achieved"

    def _begin(self, now_s: float) -> None:
        """Begin what can begin, in any order."""
        busy = {robot for _, _, action in self._running for robot in action.agents}
        ready = [
            actions[0]
            for robot, actions in self._waiting.items()
            if actions and robot not in busy and self._may_begin(actions[0], robot)
        ]
        self._chance.shuffle(ready)
        for action in ready:
            (robot,) = action.agents
            if not self._may_begin(action, robot):  # what began just now has taken what it senses
                continue
            self._waiting[robot].pop(0)
            if missing := [fact for fact in action.preconditions if fact not in self._state]:
                self.fault = f"{action.id} {action} begins without {missing[0]}"
            if spoilt := [fact for fact in action.deletes if self._needed[fact] > 0]:
                self.fault = f"{action.id} {action} ends {spoilt[0]}, which another action needs"
            self._state.difference_update(action.deletes)
            self._needed.update(_held(action))
            ends_s = now_s + self._takes_s(action)
            heapq.heappush(self._running, (ends_s, self._chance.randrange(10**9), action))

    def _by_chance(self, action: PlanNetAction) -> float:
        return action.duration_s * self._chance.choice(FACTORS)

    def _may_begin(self, action: PlanNetAction, robot: str) -> bool:
        awaited = self._awaits.get((action.id, robot), ())
        return self._state.issuperset(awaited) and self._ended.issuperset(self._cleared[action.id])

    def _end(self, action: PlanNetAction, now_s: float) -> None:
        self._needed.subtract(_held(action))
        new = [fact for fact in action.effects if fact not in self._state]
        self.achieved_s.update(dict.fromkeys(new, now_s))
        self._state.update(action.effects)
        self._ended.add(action.id)


def _held(action: PlanNetAction) -> set[Fact]:
    return set(action.preconditions) - set(action.deletes)
