"""Numbered nodes and the edges between them."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from planner.bounds.moves import Lifted, terms_of
from planner.bounds.paths import Ints
from planner.bounds.world import Binding, Pools
from planner.fact import Fact

Values = tuple[Fact | None, ...]
Part = tuple[Ints, Ints, Ints]
"""An agent's part in some edges: configurations before and after, milliseconds."""


@dataclass(slots=True)
class Nodes:
    """Numbers of configurations and states, in order of appearance."""

    numbers: dict[tuple[object, ...], int] = field(default_factory=dict)
    having: dict[tuple[object, ...], list[int]] = field(default_factory=lambda: defaultdict(list))
    """By (owner, fact) the nodes that contain it."""

    def number(self, owner: str, values: Values) -> int:
        key = owner, values
        found = self.numbers.get(key)
        if found is None:
            found = self.numbers[key] = len(self.numbers)
            for value in values:
                if value is not None:
                    self.having[owner, value].append(found)
        return found

    def filled(self, owner: str, values: Lifted, binding: Binding, pools: Pools) -> Ints:
        """The numbers of lifted values, an axis for each pool, of length 1 where they do not depend on it."""
        terms = terms_of(*values)
        used = [name for name in pools if name in terms]
        found = []
        full = dict(binding)
        for chosen in product(*(pools[name] for name in used)):
            full.update(zip(used, chosen, strict=True))
            found.append(
                self.number(owner, tuple([None if one is None else one.ground(full) for one in values]))
            )
        return np.array(found, np.int64).reshape([len(p) if n in used else 1 for n, p in pools.items()])

    def __len__(self) -> int:
        return len(self.numbers)


@dataclass(frozen=True, slots=True)
class AgentEdges:
    """Edges of configurations: numbers before and after, milliseconds; shapes (edges,)."""

    before: Ints
    after: Ints
    spans: Ints


@dataclass(frozen=True, slots=True)
class ThingEdges:
    """Edges of states; shapes (edges,). `things`: number of things that the action moves.

    Of each edge's agents, shapes (agents, edges), -1 for none: configurations before and after, and for how many
    milliseconds the action occupies them.
    """

    before: Ints
    after: Ints
    spans: Ints
    things: Ints
    entries: Ints
    exits: Ints
    kept: Ints


def joined_thing_edges(blocks: Sequence[tuple[Sequence[Ints], Sequence[Part]]]) -> ThingEdges:
    """All edges concatenated; rows of edges with fewer agents than others are padded with -1."""
    widest = max((len(parts) for _, parts in blocks), default=0)
    edges = [np.stack(columns) for columns, _ in blocks] or [np.zeros((4, 0), np.int64)]
    whole = np.concatenate(edges, axis=1)
    filled = []
    for columns, parts in blocks:
        nobody = np.full(len(columns[0]), -1)
        slots = [*parts, *[(nobody, nobody, np.zeros_like(nobody))] * (widest - len(parts))]
        filled.append(
            np.stack([np.stack(slot) for slot in slots], axis=1)
            if slots
            else np.zeros((3, 0, len(nobody)), np.int64)
        )
    agents = np.concatenate(filled, axis=2) if filled else np.zeros((3, 0, 0), np.int64)
    return ThingEdges(*whole, *agents)
