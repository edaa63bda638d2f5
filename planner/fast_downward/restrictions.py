"""Which restrictions to try when the plan found is not safe in every order its scripts allow."""

from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from itertools import count

from planner.execution import Violation
from planner.plan_net import PlanNet
from planner.statics import Restriction, Statics


class Restrictions:
    """None at first; then, learnt from each violation, one more place kept from one of the two robots that
    clash there; every third time, one of them left out altogether."""

    def __init__(self, statics: Statics) -> None:
        self._statics = statics
        self._soon: deque[Restriction] = deque([Restriction()])
        self._late: deque[Restriction] = deque()
        self._seen = {Restriction()}

    def __iter__(self) -> Iterator[Restriction]:
        for turn in count():
            if self._late and (not self._soon or turn % 3 == 2):
                yield self._late.popleft()
            elif self._soon:
                yield self._soon.popleft()
            else:
                return

    def learn(self, restriction: Restriction, violation: Violation, plan_net: PlanNet) -> None:
        """Add what could avoid the violation, the busier robot kept away first; deeper before wider."""
        if violation.fact is None:
            return
        children: list[Restriction] = []
        for place in violation.fact.args:
            pair = self._statics.peers(violation.agents, place)
            if pair is None:
                continue
            busier = sorted(pair, key=lambda robot: -len(plan_net.of_robot(robot)))
            for robot in busier:
                children.append(replace(restriction, kept_from=restriction.kept_from | {(robot, place)}))
                self._add_late(
                    replace(restriction, without=restriction.without | {robot}, kept_from=frozenset())
                )
        fresh = [child for child in children if child not in self._seen]
        self._seen.update(fresh)
        self._soon.extendleft(reversed(fresh))

    def _add_late(self, restriction: Restriction) -> None:
        if restriction not in self._seen:
            self._seen.add(restriction)
            self._late.append(restriction)
