"""What must come before what: the transitive closure of orderings between numbered actions, as bitsets.

A set of actions is an int whose bit i stands for action i: one machine operation for 64 pairs.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

from planner.errors import CyclicOrder


@dataclass(frozen=True, slots=True, kw_only=True)
class Precedence:
    """`before[i]` and `after[i]` are the bitsets of all that must come before and after i, i left out."""

    successors: tuple[tuple[int, ...], ...]
    """What each is directly ordered before, in topological order."""
    before: tuple[int, ...]
    after: tuple[int, ...]

    @classmethod
    def of(cls, count: int, pairs: Iterable[tuple[int, int]]) -> "Precedence":
        """The closure of (before, after) pairs over the numbers below `count`.

        :raises CyclicOrder: naming those on cycles or behind them.
        """
        following: list[set[int]] = [set() for _ in range(count)]
        for one, other in pairs:
            following[one].add(other)
        order = topological(following)
        rank = {node: place for place, node in enumerate(order)}
        successors = tuple(tuple(sorted(others, key=rank.__getitem__)) for others in following)
        before = [0] * count
        after = [0] * count
        for node in order:
            for other in successors[node]:
                before[other] |= before[node] | 1 << node
        for node in reversed(order):
            for other in successors[node]:
                after[node] |= after[other] | 1 << other
        return cls(successors=successors, before=tuple(before), after=tuple(after))

    def reduction(self) -> Iterator[tuple[int, int]]:
        """The fewest pairs with the same closure (transitive reduction), by their first."""
        for node, others in enumerate(self.successors):
            covered = 0
            for other in others:  # in topological order, so whatever leads to `other` has been met
                if not covered >> other & 1:
                    yield node, other
                    covered |= self.after[other]


def members(bitset: int) -> Iterator[int]:
    """The numbers in the set, ascending."""
    while bitset:
        lowest = bitset & -bitset
        yield lowest.bit_length() - 1
        bitset ^= lowest


def in_sequence(count: int, pairs: Iterable[tuple[int, int]]) -> list[int]:
    """The numbers below `count` in an order that the (before, after) pairs allow, always the least that may come next.

    :raises CyclicOrder: if they contradict each other, naming those on cycles or behind them.
    """
    following: list[set[int]] = [set() for _ in range(count)]
    for one, other in pairs:
        following[one].add(other)
    waiting_for = _counts(following)
    free = [node for node, left in enumerate(waiting_for) if not left]
    order: list[int] = []
    while free:
        order.append(heappop(free))
        for other in following[order[-1]]:
            waiting_for[other] -= 1
            if not waiting_for[other]:
                heappush(free, other)
    if len(order) < count:
        raise CyclicOrder([node for node, left in enumerate(waiting_for) if left])
    return order


def topological(following: Sequence[set[int]]) -> list[int]:
    """An order in which each number comes before those that follow it.

    :raises CyclicOrder: naming those on cycles or behind them.
    """
    waiting_for = _counts(following)
    order = [node for node, count in enumerate(waiting_for) if not count]
    for node in order:
        for other in following[node]:
            waiting_for[other] -= 1
            if not waiting_for[other]:
                order.append(other)
    if len(order) < len(following):
        raise CyclicOrder([node for node, count in enumerate(waiting_for) if count])
    return order


def _counts(following: Sequence[set[int]]) -> list[int]:
    """How many each number follows."""
    counts = [0] * len(following)
    for others in following:
        for other in others:
            counts[other] += 1
    return counts
