"""Shortest paths and assignments over arrays. Compiled (numba)."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.compiled import kernel

Ints = NDArray[np.int64]
FAR = 1 << 50
"""Milliseconds to where nothing leads."""


class Graph(NamedTuple):
    """Edges by the node they leave: those of node n are `first[n]` to `first[n + 1]`, each to `heads`.

    `costs`: of each, milliseconds, not negative. `releases`: when it can be taken at the earliest. `order`: its number
    among the edges that the graph is made of; the other arrays are sorted, as a search reads each node's edges in turn.
    """

    first: Ints
    order: Ints
    heads: Ints
    costs: Ints
    releases: Ints

    @classmethod
    def of(cls, tails: Ints, heads: Ints, nodes: int) -> "Graph":
        """The graph of edges that cost nothing and can be taken at once."""
        first = np.zeros(nodes + 1, np.int64)
        np.cumsum(np.bincount(tails, minlength=nodes), out=first[1:])
        order = np.argsort(tails, kind="stable")
        free = np.zeros(len(order), np.int64)
        return cls(first, order, heads[order], free, free)

    def timed(self, costs: Ints, releases: Ints | None = None) -> "Graph":
        """The graph with these costs, and releases if given, of the edges that it was made of."""
        released = self.releases if releases is None else releases[self.order]
        return self._replace(costs=costs[self.order], releases=released)


def shortest(graph: Graph, starts: Ints, goals: Ints | None = None) -> tuple[Ints, Ints]:
    """Each node's least time from the starts and the edge by which it is reached (-1: none), milliseconds.

    :param goals: the search ends at the first of these nodes; the times of nodes further off are then too high.
    """
    wanted = np.zeros(len(graph.first) - 1, np.bool_)
    if goals is not None:
        wanted[goals] = True
    found: Any = _shortest(*graph, starts, wanted)
    return found  # type: ignore[no-any-return]


@kernel
def _shortest(first, order, heads, costs, releases, starts, wanted):  # type: ignore[no-untyped-def]
    """Dijkstra's algorithm with a list of the nodes that are reached and not settled.

    Nodes have so many edges that a heap would mostly hold times that were improved since.
    """
    nodes = len(first) - 1
    times = np.full(nodes, FAR, np.int64)
    edges = np.full(nodes, -1, np.int64)
    reached = np.empty(nodes, np.int64)
    count = 0
    for start in starts:
        if times[start] == FAR:
            times[start] = 0
            reached[count] = start
            count += 1
    while count > 0:
        nearest = 0
        for place in range(1, count):
            if times[reached[place]] < times[reached[nearest]]:
                nearest = place
        node = reached[nearest]
        time = times[node]
        if wanted[node]:
            break
        count -= 1
        reached[nearest] = reached[count]
        for place in range(first[node], first[node + 1]):
            there = max(time, releases[place]) + costs[place]
            head = heads[place]
            if there < times[head]:
                if times[head] == FAR:
                    reached[count] = head
                    count += 1
                times[head] = there
                edges[head] = order[place]
    return times, edges


def warm_up() -> None:
    """Compile, or load what was compiled before: seconds, the first time ever."""
    nothing = np.zeros(0, np.int64)
    shortest(Graph.of(nothing, nothing, 1), np.zeros(1, np.int64))
    duals(np.zeros((1, 1), np.int64))


def duals(costs: Ints) -> tuple[Ints, Ints]:
    """Prices of rows and columns, row + column <= cost everywhere, that add up to the cheapest assignment's cost.

    :param costs: shape (n, n).
    """
    found: Any = _duals(costs)
    return found  # type: ignore[no-any-return]


@kernel
def _duals(costs):  # type: ignore[no-untyped-def]
    """The Hungarian method, row by row (Kuhn 1955; Jonker & Volgenant 1987)."""
    size = len(costs)
    rows = np.zeros(size + 1, np.int64)
    columns = np.zeros(size + 1, np.int64)
    row_of = np.zeros(size + 1, np.int64)
    for row in range(1, size + 1):
        row_of[0] = row
        column = 0
        slack = np.full(size + 1, 4 * FAR, np.int64)
        came_from = np.zeros(size + 1, np.int64)
        used = np.zeros(size + 1, np.bool_)
        while True:
            used[column] = True
            here = row_of[column]
            delta = 4 * FAR
            following = 0
            for other in range(1, size + 1):
                if not used[other]:
                    over = costs[here - 1, other - 1] - rows[here] - columns[other]
                    if over < slack[other]:
                        slack[other] = over
                        came_from[other] = column
                    if slack[other] < delta:
                        delta = slack[other]
                        following = other
            for other in range(size + 1):
                if used[other]:
                    rows[row_of[other]] += delta
                    columns[other] -= delta
                else:
                    slack[other] -= delta
            column = following
            if row_of[column] == 0:
                break
        while column != 0:
            row_of[column] = row_of[came_from[column]]
            column = came_from[column]
    return rows[1:], columns[1:]
