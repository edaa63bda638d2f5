"""Moves new actions forward among kept ones where the sequence stays valid and its schedule improves.

Extraction makes actions parallel where possible, but keeps the order of the sequence where two robots use one place.
So that order matters: a block of new actions (those for one goal, those of one robot) is tried at every position
among the kept actions.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from math import inf

from planner.errors import OrderNotKept
from planner.explanation.purpose import purposes
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.extraction import extract, fault_of
from planner.plan_nets.plan_net import ROUNDING_S, PlanNet
from planner.plan_nets.schedule import windows
from planner.repair.remaining import Remaining, in_order

REPLAYS = 600
"""Maximum number of positions tried."""
SCHEDULES = 100
"""Maximum number of valid positions that are scheduled."""

Cost = tuple[float, float]


def insert_new_actions(
    kept: Sequence[GroundAction],
    fresh: PlanNet,
    remaining: Remaining,
    *,
    starts_by_s: Mapping[int, float] | None = None,
) -> tuple[GroundAction, ...]:
    """The kept actions with those of a plan-net for what comes after them, in a good order.

    :param kept: those under way first.
    :param starts_by_s: position among the kept → latest start; orders that miss one are rejected.
    """
    actions = (*kept, *in_order(fresh))
    return _Reinsertion(actions, len(kept), remaining, starts_by_s or {}).run(
        _blocks(fresh, len(kept), remaining)
    )


def _blocks(fresh: PlanNet, first: int, remaining: Remaining) -> list[list[int]]:
    """The positions of the new actions for each goal, then of each robot."""
    by_goal: dict[tuple[Fact, ...], list[int]] = defaultdict(list)
    by_robot: dict[tuple[str, ...], list[int]] = defaultdict(list)
    purpose = purposes(fresh, remaining.knowledge_base)
    for position, action in enumerate(in_order(fresh), start=first):
        by_goal[purpose[action.id].goals].append(position)
        by_robot[action.agents].append(position)
    return list(chain(by_goal.values(), by_robot.values()))


class _Reinsertion:
    """Positions in the kept actions followed by the new ones, in changing orders."""

    def __init__(
        self,
        actions: Sequence[GroundAction],
        count: int,
        remaining: Remaining,
        starts_by_s: Mapping[int, float],
    ) -> None:
        """:param count: of the kept actions."""
        self._actions = actions
        self._count = count
        self._starts_by_s = starts_by_s
        self._facts = remaining.problem.facts
        self._goals = remaining.problem.goals
        self._after = remaining.problem.after
        self._held = len(remaining.under_way)
        self._position = {id(action): position for position, action in enumerate(actions)}
        self._replays = REPLAYS
        self._schedules = SCHEDULES

    def run(self, blocks: Sequence[Sequence[int]]) -> tuple[GroundAction, ...]:
        order = list(range(len(self._actions)))
        best = self._cost(order)
        for block in blocks:
            if best is None:
                break  # not a plan as it is; the caller reports why
            for trial in self._trials(order, block):
                cost = self._cost(trial)
                if cost is not None and cost < best:
                    best = cost
                    order = trial
        return tuple(self._actions[position] for position in order)

    def _trials(self, order: Sequence[int], block: Sequence[int]) -> Iterator[list[int]]:
        """The block moved before each kept action that precedes it and is not under way."""
        rest = [position for position in order if position not in set(block)]
        latest = order.index(block[0])
        for place in range(self._held, min(latest, len(rest))):
            if rest[place] < self._count:
                yield [*rest[:place], *block, *rest[place:]]

    def _cost(self, order: Sequence[int]) -> Cost | None:
        """The makespan and the sum of all ends, infinite if goals come true in another order than they are to; None if
        it is no plan or delays what must not be."""
        sequence = [self._actions[position] for position in order]
        self._replays -= 1
        if self._replays < 0 or fault_of(sequence, self._facts, self._goals) is not None:
            return None
        self._schedules -= 1
        if self._schedules < 0:
            return None
        try:
            partial = extract(sequence, self._facts, self._goals, after=self._after)
        except OrderNotKept:
            return inf, inf
        spans = [action.duration_s for action in partial.actions]
        starts = windows(spans, partial.orderings, {}).earliest
        of_kept = {self._position[id(a)]: start for a, start in zip(partial.actions, starts, strict=True)}
        for position, latest_s in self._starts_by_s.items():
            if position not in of_kept or of_kept[position] > latest_s + ROUNDING_S:
                return None
        ends = [start + span for start, span in zip(starts, spans, strict=True)]
        return round(max(ends, default=0.0), 3), round(sum(ends), 3)
