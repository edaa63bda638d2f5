"""Selects small worlds for the search: the objects that the goals, present facts and static facts connect.

Level 0 holds the goals' objects, what the present facts say of them, and the shortest static connections
between them; each further level allows connections a little longer, more members a kind and more spare places.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import combinations

from planner.engines.hierarchical.fragments.world_index import Node, Shape, WorldIndex
from planner.fact import Fact

LEVELS = 3
SLACK = (0, 2, 4)
"""Maximum number of steps by which a connection exceeds the shortest, by level."""
MEMBERS = (1, 2, 2)
"""Number of agents of a kind, by level."""
SPARES = (2, 2, 4)
"""Number of equivalent objects, by level."""
KINDS = (4, 8, 16)
"""Number of kinds besides those on the goals' connections, by level."""


def small_world(
    index: WorldIndex, goals: Sequence[Fact], level: int, left_out: Collection[int] = ()
) -> frozenset[str]:
    """The objects of the level; no agents of the kinds left out, unless a goal names them."""
    return _Relevance(index, goals, level, left_out).objects()


def goal_neighbourhood(index: WorldIndex, goals: Sequence[Fact], hops: int) -> dict[str, int]:
    """The goals' objects and those that present facts tie to them, each with its steps from the goals."""
    reached = {arg: 0 for goal in goals for arg in goal.args if arg in index.objects}
    fringe = list(reached)
    for hop in range(1, hops + 1):
        near = [name for seed in fringe for name in index.linked_by_fluents(seed) if name not in reached]
        fringe = list(dict.fromkeys(near))
        reached |= dict.fromkeys(fringe, hop)
    return reached


class _Relevance:
    def __init__(
        self, index: WorldIndex, goals: Sequence[Fact], level: int, left_out: Collection[int]
    ) -> None:
        self.index = index
        self.level = level
        self.left_out = left_out
        named = {arg for goal in goals for arg in goal.args}
        self.core = [
            name
            for name in goal_neighbourhood(index, goals, 2 + (level > 0))
            if name in named or index.kind_of.get(name) not in left_out
        ]
        self.named = named

    def objects(self) -> frozenset[str]:
        index = self.index
        chosen = dict.fromkeys((*self.core, *index.on_ways))
        terminals = [name for name in self.core if index.neighbours(index.node(name))]
        ends = [index.node(name) for name in terminals]
        over = self._between(ends, SLACK[self.level])
        kinds = self._thinned_kinds(over)
        kinds += self._others(terminals, kinds)
        agents = [agent for kind in kinds for agent in self._members(kind)]
        agents += [name for name in self.core if name in index.agents]
        agents += self._in_the_way(node for node, longer in over.items() if not longer)
        homes = [
            place for agent in agents for place in index.linked_by_fluents(agent) if place not in index.agents
        ]
        ways = self._between(self._starts(homes) + self._starts(self.named), SLACK[self.level])
        spare = [node for node in dict.fromkeys((*over, *ways)) if isinstance(node, str)]
        within = frozenset(index.kind_of[agent] for agent in agents)
        chosen |= dict.fromkeys((*agents, *homes, *self._thinned(spare, chosen, within), *self._floating()))
        if self.level:
            straight = [node for node in over if isinstance(node, str) and (self.level > 1 or not over[node])]
            chosen |= dict.fromkeys(
                other
                for name in (*(n for n in straight if n in chosen), *agents, *homes)
                for other in index.linked_by_fluents(name)
                if index.kind_of.get(other) not in self.left_out
            )
        return frozenset(chosen).union(*map(index.linked_by_static_facts, chosen))

    def _starts(self, names: Iterable[str]) -> list[Node]:
        """The nodes of the first few names that the static graph connects."""
        index = self.index
        return [index.node(name) for name in dict.fromkeys(names) if index.neighbours(index.node(name))][:4]

    def _thinned_kinds(self, over: Mapping[Node, int]) -> list[int]:
        """The kinds on the shortest connections, and of each sort a few of those on longer ones."""
        counts: Counter[tuple[str, ...]] = Counter()
        kept = []
        for node, length in over.items():
            if isinstance(node, int):
                counts[self.index.profiles[node]] += length > 0
                if not length or counts[self.index.profiles[node]] <= SPARES[self.level]:
                    kept.append(node)
        return kept

    def _between(self, terminals: Sequence[Node], slack: int) -> dict[Node, int]:
        """The nodes on connections that are not much longer than the shortest, with how much longer, the least
        first."""
        index = self.index
        found: dict[Node, int] = {}
        for one, other in combinations(dict.fromkeys(terminals), 2):
            length = index.distance(one, other)
            if length is None:
                continue
            beyond = index.distances(other)
            for node, steps in index.distances(one).items():
                if steps <= length + slack and node in beyond:
                    over = steps + beyond[node] - length
                    if over <= slack and not (isinstance(node, int) and node in self.left_out):
                        found[node] = min(over, found.get(node, over))
        return {node: found[node] for node in sorted(found, key=lambda node: (found[node], str(node)))}

    def _others(self, terminals: Iterable[str], known: Collection[Node]) -> list[int]:
        """Kinds adjacent to the goals' objects, and kinds that the static graph does not connect."""
        index = self.index
        near = [
            node
            for name in terminals
            for node in sorted(index.neighbours(index.node(name)), key=str)
            if isinstance(node, int)
        ]
        near += [kind for kind in index.members if not index.neighbours(kind)]
        fresh = [kind for kind in dict.fromkeys(near) if kind not in known and kind not in self.left_out]
        return fresh[: KINDS[self.level]]

    def _members(self, kind: int) -> list[str]:
        """A number of agents of a kind besides those that goals name, those related to the goals first."""
        group = self.index.members[kind]
        core = [name for name in self.core if name in group]
        others = [name for name in group if name not in core]
        named = sum(name in self.named for name in core)
        return (core + others)[: max(len(core), named + MEMBERS[self.level])]

    def _thinned(
        self, names: Iterable[str], chosen: Collection[str], kinds: frozenset[Node]
    ) -> Iterator[str]:
        """A few of each set of objects that are equivalent for the chosen kinds of agents."""
        counts: Counter[tuple[str, frozenset[Node], Shape]] = Counter()
        index = self.index
        for name in names:
            if name in chosen or name in index.agents:
                continue
            near = frozenset(
                node for node in index.neighbours(name) if isinstance(node, str) or node in kinds
            )
            key = index.objects[name], near, index.shape(name)
            counts[key] += 1
            if counts[key] <= SPARES[self.level]:
                yield name

    def _in_the_way(self, connection: Iterable[Node]) -> list[str]:
        """The agents at places of the shortest connections: they may have to make way."""
        index = self.index
        return [
            name
            for node in connection
            if isinstance(node, str)
            for name in index.linked_by_fluents(node)
            if name in index.agents and index.kind_of[name] not in self.left_out
        ]

    def _floating(self) -> Iterator[str]:
        """Objects that no static fact or function places: tools and the like, a few of each sort, and where
        they are."""
        index = self.index
        own = {index.objects[name] for name in self.named if name in index.objects}
        groups: Counter[tuple[str, Shape]] = Counter()
        for name in sorted(index.objects):
            if index.neighbours(index.node(name)) or name in index.agents or index.objects[name] in own:
                continue
            key = index.objects[name], index.shape(name)
            groups[key] += 1
            if groups[key] <= MEMBERS[self.level]:
                yield name
                yield from (other for other in index.linked_by_fluents(name) if other not in index.agents)
