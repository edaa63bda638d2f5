"""A network of binary joins that derives the consequences of rules, cheapest derivation first.

Rows flow through nodes: a node for each predicate, for each selection of one (constants, types, columns) and
for each join of two nodes. A join keeps only the columns that are needed further on, so the relations stay
small where grounding would be large. Nodes are shared between rules.

Facts may be supposed. What rests on the fewest supposed facts, then on the fewest actions, is derived first
(Knuth's generalisation of Dijkstra's algorithm), so that each row is derived once. Rows that rest on supposed
facts join by the union of these, which is the least for most but not for all problems.
"""

import heapq
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import prod
from operator import itemgetter

from planner.fact import Fact
from planner.knowledge.literal import Literal
from planner.relaxation.rules import Rule

Row = tuple[str, ...]
Place = tuple[int, Row]
"""A row of a node."""
NOTHING: frozenset[Fact] = frozenset()


@dataclass(slots=True)
class _Selection:
    """Rows of a predicate that fit a literal: `allowed` values at positions, `equal` pairs of positions."""

    target: int
    allowed: tuple[tuple[int, frozenset[str]], ...]
    equal: tuple[tuple[int, int], ...]
    columns: Callable[[Row], Row]


@dataclass(slots=True)
class _Join:
    """Rows of two nodes with the same key; columns count through the left row, then the right."""

    target: int
    sources: tuple[int, int]
    keys: tuple[Callable[[Row], Row], Callable[[Row], Row]]
    columns: Callable[[Row], Row]
    unequal: tuple[tuple[int, int], ...]
    rows: tuple[dict[Row, list[Row]], dict[Row, list[Row]]] = field(default_factory=lambda: ({}, {}))


@dataclass(slots=True)
class _Head:
    """A rule's head: each argument a column of the body's row, or a constant."""

    target: int
    arguments: tuple[int | str, ...]


@dataclass(slots=True)
class _Derivation:
    """What a row was derived from: the supposed facts it rests on, an estimate of the actions, its rows."""

    supposed: frozenset[Fact]
    actions: int
    parents: tuple[Place, ...]


class Network:
    """Rules compiled; `give` facts, `run`, then ask what is reached and what it rests on.

    :param members: for each type the names of its objects and constants.
    :param types: for each predicate the types of its arguments.
    :param kept: for each predicate the positions that matter; facts of others are ignored.
    """

    def __init__(
        self,
        rules: Iterable[Rule],
        *,
        members: Mapping[str, frozenset[str]],
        types: Mapping[str, tuple[str, ...]],
        kept: Mapping[str, tuple[int, ...]],
    ) -> None:
        self._members = members
        self._types = types
        self._kept = kept
        self._nodes: dict[Hashable, int] = {}
        self._consumers: list[list[_Selection | tuple[_Join, int] | _Head]] = []
        self._reached: dict[Place, _Derivation] = {}
        self._facts: dict[Place, Fact] = {}
        self._queue: list[tuple[int, int, int, Place, _Derivation]] = []
        self._known: set[Hashable] = set()
        self._serial = 0
        for rule in rules:
            if rule.head.predicate in kept:
                self._compile(rule)

    def give(self, fact: Fact, *, supposed: bool = False) -> None:
        """Let the fact hold from the start, as known or as supposed."""
        place = self._place(fact)
        if place is not None:
            self._facts.setdefault(place, fact)
            self._push(place, _Derivation(frozenset({fact}) if supposed else NOTHING, 0, ()))

    def run(self, until: Iterable[Fact] = ()) -> None:
        """Derive everything, or stop as soon as all of `until` are reached."""
        wanted = {place for fact in until if (place := self._place(fact)) is not None}
        waiting = wanted - self._reached.keys()
        while self._queue and (waiting or not wanted):
            *_, place, derivation = heapq.heappop(self._queue)
            if place not in self._reached:
                self._reached[place] = derivation
                waiting.discard(place)
                self._pass_on(place, derivation)

    def supposed(self, fact: Fact) -> frozenset[Fact] | None:
        """The supposed facts that the fact rests on; None if it is not reached."""
        derivation = self._reached.get(self._place(fact) or (-1, ()))
        return derivation.supposed if derivation else None

    def leaves(self, fact: Fact) -> frozenset[Fact]:
        """All given facts that the fact's derivation rests on."""
        leaves = set()
        seen = set()
        stack = [place for place in [self._place(fact)] if place in self._reached]
        while stack:
            place = stack.pop()
            if place is not None and place not in seen:
                seen.add(place)
                parents = self._reached[place].parents
                stack += parents
                if not parents:
                    leaves.add(self._facts[place])
        return frozenset(leaves)

    def _place(self, fact: Fact) -> Place | None:
        kept = self._kept.get(fact.predicate)
        if kept is None:
            return None
        return self._node(fact.predicate), tuple(fact.args[i] for i in kept)

    def _push(self, place: Place, derivation: _Derivation) -> None:
        if place not in self._reached:
            self._serial += 1
            rank = len(derivation.supposed), derivation.actions, self._serial
            heapq.heappush(self._queue, (*rank, place, derivation))

    def _pass_on(self, place: Place, derivation: _Derivation) -> None:
        node, row = place
        supposed = derivation.supposed
        actions = derivation.actions
        for consumer in self._consumers[node]:
            if isinstance(consumer, tuple):
                self._join(place, derivation, *consumer)
            elif isinstance(consumer, _Head):
                built = tuple(row[a] if isinstance(a, int) else a for a in consumer.arguments)
                self._push((consumer.target, built), _Derivation(supposed, actions + 1, (place,)))
            elif all(row[i] in allowed for i, allowed in consumer.allowed) and all(
                row[i] == row[j] for i, j in consumer.equal
            ):
                fits = consumer.target, consumer.columns(row)
                self._push(fits, _Derivation(supposed, actions, (place,)))

    def _join(self, place: Place, derivation: _Derivation, join: _Join, side: int) -> None:
        row = place[1]
        key = join.keys[side](row)
        join.rows[side].setdefault(key, []).append(row)
        for other in join.rows[1 - side].get(key, ()):
            both = other + row if side else row + other
            if join.unequal and not all(both[i] != both[j] for i, j in join.unequal):
                continue
            built = join.target, join.columns(both)
            if built not in self._reached:
                partner = join.sources[1 - side], other
                there = self._reached[partner]
                supposed = derivation.supposed | there.supposed
                actions = derivation.actions + there.actions
                self._push(built, _Derivation(supposed, actions, (place, partner)))

    def _compile(self, rule: Rule) -> None:
        """Chain the body's literals by joins, each time the one that adds the fewest combinations."""
        head = [rule.head.terms[i] for i in self._kept[rule.head.predicate]]
        waiting = list(rule.literals)
        node = -1
        columns: tuple[str, ...] = ()
        while waiting:
            literal = min(waiting, key=lambda literal: self._spread(rule, literal, columns))
            waiting.remove(literal)
            later = {term for other in waiting for term in other.terms}.union(head)
            if node < 0:
                node, columns = self._select(rule, literal, later)
            else:
                right, other = self._select(rule, literal, later.union(columns))
                node, columns = self._joined(rule, (node, right), (columns, other), later)
        target = self._node(rule.head.predicate)
        arguments = tuple(columns.index(term) if term in columns else term for term in head)
        self._consume(node, ("head", target, arguments), _Head(target, arguments))

    def _spread(self, rule: Rule, literal: Literal, columns: Sequence[str]) -> int:
        """How many values the variables that the literal would add could have together."""
        fresh = {term for term in literal.terms if term in rule.types and term not in columns}
        return prod(max(1, len(self._members.get(rule.types[term], ()))) for term in fresh)

    def _select(self, rule: Rule, literal: Literal, later: Collection[str]) -> tuple[int, tuple[str, ...]]:
        """The node of the rows that fit the literal, and the variables its columns stand for."""
        kept = self._kept[literal.predicate]
        terms = [literal.terms[i] for i in kept]
        kinds = [self._types[literal.predicate][i] for i in kept]
        allowed: list[tuple[int, frozenset[str]]] = []
        for i, (term, kind) in enumerate(zip(terms, kinds, strict=True)):
            if term not in rule.types:
                allowed.append((i, frozenset({term})))
            elif rule.types[term] != kind:
                allowed.append((i, self._members.get(rule.types[term], frozenset())))
        equal = tuple((terms.index(term), i) for i, term in enumerate(terms) if terms.index(term) != i)
        columns = tuple(dict.fromkeys(t for t in terms if t in rule.types and t in later))
        places = tuple(terms.index(term) for term in columns)
        source = self._node(literal.predicate)
        if not allowed and not equal and places == tuple(range(len(terms))):
            return source, columns
        shape = ("select", source, tuple(allowed), equal, places)
        selection = _Selection(self._node(shape), tuple(allowed), equal, _columns(places))
        self._consume(source, shape, selection)
        return selection.target, columns

    def _joined(
        self, rule: Rule, nodes: tuple[int, int], columns: tuple[tuple[str, ...], ...], later: Collection[str]
    ) -> tuple[int, tuple[str, ...]]:
        """The node of the two nodes' joined rows, only with the variables needed later."""
        left, right = columns
        key = [term for term in left if term in right]
        both = left + right
        kept = tuple(dict.fromkeys(term for term in both if term in later))
        keys = tuple(map(left.index, key)), tuple(map(right.index, key))
        columns_kept = tuple(map(both.index, kept))
        unequal = tuple((both.index(a), both.index(b)) for a, b in rule.distinct if a in both and b in both)
        shape = ("join", nodes, keys, columns_kept, unequal)
        join = _Join(
            self._node(shape), nodes, (_columns(keys[0]), _columns(keys[1])), _columns(columns_kept), unequal
        )
        self._consume(nodes[0], (shape, 0), (join, 0))
        self._consume(nodes[1], (shape, 1), (join, 1))
        return join.target, kept

    def _node(self, shape: Hashable) -> int:
        if shape not in self._nodes:
            self._nodes[shape] = len(self._consumers)
            self._consumers.append([])
        return self._nodes[shape]

    def _consume(
        self, node: int, shape: Hashable, consumer: "_Selection | tuple[_Join, int] | _Head"
    ) -> None:
        """Let the consumer have the node's rows, once for each shape."""
        if (node, shape) not in self._known:
            self._known.add((node, shape))
            self._consumers[node].append(consumer)


def _columns(positions: tuple[int, ...]) -> Callable[[Row], Row]:
    """A function that selects these positions of a row."""
    if len(positions) > 1:
        return itemgetter(*positions)
    if positions:
        (only,) = positions
        return lambda row: (row[only],)
    return lambda row: ()
