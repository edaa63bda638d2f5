"""Assignments and shortest paths over arrays."""

from itertools import permutations

import numpy as np

from planner.bounds.paths import FAR, Graph, duals, shortest


def test_prices_add_up_to_the_cheapest_assignment_and_never_exceed_a_cost() -> None:
    chance = np.random.default_rng(0)
    for size in (1, 2, 5, 6):
        costs = chance.integers(0, 100, (size, size))
        rows, columns = duals(costs)
        cheapest = min(sum(costs[n, m] for n, m in enumerate(order)) for order in permutations(range(size)))
        assert rows.sum() + columns.sum() == cheapest
        assert (rows[:, None] + columns[None, :] <= costs).all()


def test_an_edge_is_not_taken_before_its_release() -> None:
    graph = Graph.of(np.array([0, 1, 0]), np.array([1, 2, 2]), 4)
    costs = np.array([2, 3, 4])
    releases = np.array([0, 10, 20])
    times, edges = shortest(graph.timed(costs, releases), np.array([0]))
    assert times.tolist() == [0, 2, 13, FAR]
    assert edges.tolist() == [-1, 0, 1, -1]
