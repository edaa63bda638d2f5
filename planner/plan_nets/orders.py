"""An order among single goals: one comes true only after others are achieved.

What achieves a goal, and all else that brings it about, starts once the goals before it are achieved for good. Unlike
stages (`planner.plan_nets.stages`) that says nothing of other goals, nor of what only prepares an achievement: robots
drive up and fetch things meanwhile.

A goal that holds from the start and is left so neither waits nor is waited for, nor is one that the plan does not have;
actions under way do not wait.
"""

from collections.abc import Iterable, Mapping, Sequence

from planner.errors import CyclicOrder
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.causality import FROM_START, Link
from planner.plan_nets.precedence import Precedence, topological

Orders = Mapping[Fact, frozenset[Fact]]
"""By goal, the goals after which it is to come true."""


def orders_among(goals: Iterable[Fact], after: Orders) -> dict[Fact, frozenset[Fact]]:
    """The orders in which both goals are among these."""
    known = frozenset(goals)
    return {goal: earlier & known for goal, earlier in after.items() if goal in known and earlier & known}


def order_pairs(
    actions: Sequence[GroundAction], links: Sequence[Link], after: Orders
) -> dict[tuple[int, int], tuple[Fact, Fact]]:
    """The pairs of positions whose actions are to follow each other, with the goals that these bring about.

    The first of a pair may stand behind the second one, or be the same.
    """
    achievers = {link.fact: link.producer for link in links if link.consumer == len(actions)}
    found: dict[tuple[int, int], tuple[Fact, Fact]] = {}
    for goal, earlier in after.items():
        if achievers.get(goal, FROM_START) == FROM_START:
            continue
        achieving = [
            at for at, action in enumerate(actions) if goal in action.effects and not action.under_way
        ]
        for before in sorted(earlier):
            first = achievers.get(before, FROM_START)
            if first != FROM_START:
                found |= {(first, at): (before, goal) for at in achieving}
    return found


def unkept(precedence: Precedence, asked: Mapping[tuple[int, int], tuple[Fact, Fact]]) -> str:
    """Which goals do not come true in the order asked for, in words.

    :param precedence: of the actions, without what is asked.
    """
    against = [
        goals for (first, at), goals in asked.items() if first == at or precedence.before[first] >> at & 1
    ]
    said = [f"{goal} comes true before {before}" for before, goal in against or asked.values()]
    return f"in this plan {', '.join(dict.fromkeys(said))}, after which it is to come true"


def fewest_stages(goals: Sequence[Fact], after: Orders) -> dict[Fact, int]:
    """The fewest stages in which each goal belongs to a later one than those it comes after; the first is left out.

    :raises CyclicOrder: if the orders contradict each other.
    """
    following = _following(goals, after)
    stages = [0] * len(goals)
    for node in topological(following):
        for other in following[node]:
            stages[other] = max(stages[other], stages[node] + 1)
    return {goal: stage for goal, stage in zip(goals, stages, strict=True) if stage}


def cycle_in(after: Orders) -> tuple[Fact, ...]:
    """Goals of which each is to come after the next one, and the last after the first; none if there are none such."""
    goals = sorted({goal for one, earlier in after.items() for goal in (one, *earlier)})
    try:
        topological(_following(goals, after))
    except CyclicOrder as error:
        # Each of these comes after another one of them.
        among = {goals[node] for node in error.nodes}
        path = [min(among)]
        while (before := min(after[path[-1]] & among)) not in path:
            path.append(before)
        return tuple(path[path.index(before) :])
    return ()


def _following(goals: Sequence[Fact], after: Orders) -> list[set[int]]:
    """For each of the goals the places of those that come after it."""
    number = {goal: place for place, goal in enumerate(goals)}
    following: list[set[int]] = [set() for _ in goals]
    for goal, earlier in orders_among(goals, after).items():
        for before in earlier:
            following[number[before]].add(number[goal])
    return following
