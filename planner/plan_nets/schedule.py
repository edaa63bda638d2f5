"""When the actions of a partial order may start: a simple temporal network (Dechter, Meiri & Pearl 1991).

Each action's start is a time point. Its constraints: not before the plan's start or its own earliest; after the end of
every action ordered before it; its end not after the plan's or its own deadline. The network is acyclic, so its minimal
form, every time point's earliest and latest value, takes one sweep forward and one backward.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from planner.plan_nets.precedence import topological

_ROUNDING_S = 0.01

Pairs = Iterable[tuple[int, int]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Windows:
    """Earliest and latest starts by action, seconds from the plan's start, to the millisecond."""

    earliest: tuple[float, ...]
    latest: tuple[float, ...]


def windows(
    durations_s: Sequence[float],
    pairs: Pairs,
    ends_by_s: Mapping[int, float],
    starts_from_s: Mapping[int, float] | None = None,
) -> Windows:
    """The windows of actions under (before, after) pairs.

    The latest starts keep the makespan as it is, and every deadline; an action that cannot keep its own is bound
    to its earliest end instead.

    :param ends_by_s: deadlines of actions' ends.
    :param starts_from_s: when actions may start at the earliest, whatever comes before them.
    :raises CyclicOrder: if the pairs contradict each other.
    """
    following = _following(len(durations_s), pairs)
    order = topological(following)
    starts = [0.0] * len(order)
    for node, start_s in (starts_from_s or {}).items():
        starts[node] = max(0.0, start_s)
    for node in order:
        for other in following[node]:
            starts[other] = max(starts[other], starts[node] + durations_s[node])
    ends = [start + span for start, span in zip(starts, durations_s, strict=True)]
    makespan_s = max(ends, default=0.0)
    latest = [0.0] * len(order)
    for node in reversed(order):
        own = max(ends[node], ends_by_s.get(node, makespan_s))
        latest[node] = min([makespan_s, own, *(latest[other] for other in following[node])])
        latest[node] -= durations_s[node]
    return Windows(
        earliest=tuple(round(start, 3) for start in starts),
        latest=tuple(round(max(one, other), 3) for one, other in zip(starts, latest, strict=True)),
    )


def critical_path(durations_s: Sequence[float], starts_s: Sequence[float], pairs: Pairs) -> list[int]:
    """A longest chain, in order: each begins when the one before it ends, and the last ends last.

    The first begins at the plan's start, or when it may at the earliest.

    :param starts_s: the earliest starts under the pairs.
    """
    ends = [start + span for start, span in zip(starts_s, durations_s, strict=True)]
    binding: dict[int, int] = {}
    for before, after in sorted(pairs):
        is_awaited = ends[before] >= starts_s[after] - _ROUNDING_S
        if is_awaited and (after not in binding or ends[before] > ends[binding[after]]):
            binding[after] = before
    chain: list[int] = []
    node = max(range(len(ends)), key=lambda n: ends[n], default=None)
    while node is not None:
        chain.append(node)
        node = binding.get(node)
    return chain[::-1]


def _following(count: int, pairs: Pairs) -> list[set[int]]:
    following: list[set[int]] = [set() for _ in range(count)]
    for before, after in pairs:
        following[before].add(after)
    return following
