"""A network of binary joins that derives the consequences of rules.

Rows flow through nodes: a node for each predicate, for each selection of one (constants, types, columns) and
for each join of two nodes. A join keeps only the columns that are needed further on, so the relations stay
small where grounding would be large. Nodes are shared between rules.

`Closure` derives what facts reach. `Derivations` also tells what that rests on; its facts may be supposed. What rests
on the fewest supposed facts, then on the fewest actions, is derived first (Knuth's generalisation of Dijkstra's
algorithm), so that each row is derived once. Rows that rest on supposed facts join by the union of these, which is the
least for most but not for all problems.
"""

import heapq
from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from operator import itemgetter

from planner.fact import Fact
from planner.knowledge.literal import Literal
from planner.relaxation.rules import Rule

Row = tuple[str, ...]
Table = dict[Row, list[Row]]
"""A node's rows by their values in the columns of a join's key."""
Place = tuple[int, Row]
"""A row of a node."""
NOTHING: frozenset[Fact] = frozenset()
NO_GUARDS: Mapping[str, int] = {}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Limit:
    """How many rows are enough that have the same values in these columns."""

    columns: tuple[int, ...]
    rows: int


@dataclass(slots=True)
class _Selection:
    """Rows of a predicate that fit a literal: `allowed` values at positions, `equal` and `unequal` pairs of them."""

    target: int
    allowed: tuple[tuple[int, frozenset[str]], ...]
    equal: tuple[tuple[int, int], ...]
    unequal: tuple[tuple[int, int], ...]
    columns: Callable[[Row], Row]

    def place(self, row: Row) -> Place | None:
        """Where the row goes; None if it does not fit."""
        for built in self.rows([row]):
            return self.target, built
        return None

    def rows(self, rows: Iterable[Row]) -> Iterable[Row]:
        """What the target gets from these rows."""
        for i, allowed in self.allowed:
            rows = [row for row in rows if row[i] in allowed]
        for i, j in self.equal:
            rows = [row for row in rows if row[i] == row[j]]
        return map(self.columns, _differing(rows, self.unequal))


@dataclass(slots=True)
class _Join:
    """Rows of two nodes with the same key; columns count through the left row, then the right.

    :param index: among the network's joins.
    """

    index: int
    target: int
    sources: tuple[int, int]
    keys: tuple[Callable[[Row], Row], Callable[[Row], Row]]
    columns: Callable[[Row], Row]
    unequal: tuple[tuple[int, int], ...]

    def rows(self, side: int, rows: Sequence[Row], tables: Sequence[Table]) -> Iterable[Row]:
        """What the target gets from new rows of one side, which are added to that side's table."""
        mine, theirs = tables[side], tables[1 - side]
        keyed = [(self.keys[side](row), row) for row in rows]
        for key, row in keyed:
            mine.setdefault(key, []).append(row)
        if side:
            both = (other + row for key, row in keyed for other in theirs.get(key, ()))
        else:
            both = (row + other for key, row in keyed for other in theirs.get(key, ()))
        return map(self.columns, _differing(both, self.unequal))

    def allows(self, both: Row) -> bool:
        return not self.unequal or all(both[i] != both[j] for i, j in self.unequal)


@dataclass(slots=True)
class _Head:
    """A rule's head: each argument a column of the body's row, or a constant."""

    target: int
    arguments: tuple[int | str, ...]

    def place(self, row: Row) -> Place:
        """The fact that the row brings about."""
        (built,) = self.rows([row])
        return self.target, built

    def rows(self, rows: Iterable[Row]) -> Iterable[Row]:
        """The arguments of the facts that the rows bring about."""
        return (tuple(row[a] if isinstance(a, int) else a for a in self.arguments) for row in rows)


@dataclass(slots=True)
class _Derivation:
    """What a row was derived from: the supposed facts it rests on, an estimate of the actions, its rows."""

    supposed: frozenset[Fact]
    actions: int
    parents: tuple[Place, ...]


class Network:
    """Rules compiled. Nothing in it changes when facts flow through, so that problems with the same objects share it.

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
        self.consumers: list[list[_Selection | tuple[_Join, int] | _Head]] = []
        """By node, what takes its rows; a join with the side on which it takes them."""
        self.limits: dict[int, tuple[Callable[[Row], Row], int]] = {}
        """By node, how many rows are enough that have the same values in these columns."""
        self.join_count = 0
        self._known: set[Hashable] = set()
        for rule in rules:
            if rule.head.predicate in kept:
                self._compile(rule)
        self._of_predicates = {
            predicate: (self._node(predicate), _columns(positions)) for predicate, positions in kept.items()
        }

    def place(self, fact: Fact) -> Place | None:
        """Where the fact enters; None if nothing needs it."""
        entry = self._of_predicates.get(fact.predicate)
        return None if entry is None else (entry[0], entry[1](fact.args))

    def _compile(self, rule: Rule) -> None:
        """Chain the body's literals by joins, each time the one that adds the fewest combinations.

        What the head names comes last: the other variables are left out of the rows as early as can be.
        """
        head = [rule.head.terms[i] for i in self._kept[rule.head.predicate]]
        waiting = list(rule.literals)
        node = -1
        columns: tuple[str, ...] = ()
        while waiting:
            literal = min(waiting, key=lambda literal: self._rank(rule, literal, columns, head))
            waiting.remove(literal)
            later = {term for other in waiting for term in other.terms}.union(head)
            guards = _guards(rule, {*columns, *literal.terms}, later)
            if node < 0:
                node, columns = self._select(rule, literal, later.union(guards), guards)
            else:
                compared = {one for pair in rule.distinct if not {*columns}.isdisjoint(pair) for one in pair}
                right, other = self._select(rule, literal, later.union(columns, guards, compared))
                node, columns = self._joined(
                    rule, (node, right), (columns, other), later.union(guards), guards
                )
        target = self._node(rule.head.predicate)
        arguments = tuple(columns.index(term) if term in columns else term for term in head)
        self._consume(node, ("head", target, arguments), _Head(target, arguments))

    def _rank(
        self, rule: Rule, literal: Literal, columns: Sequence[str], head: Sequence[str]
    ) -> tuple[bool, int, int]:
        """Whether the literal has nothing in common with the rows, how many of the head's variables it would add, and
        how many values all that it would add could have together."""
        fresh = {term for term in literal.terms if term in rule.types and term not in columns}
        is_apart = bool(columns) and fresh.issuperset(term for term in literal.terms if term in rule.types)
        values = prod(max(1, len(self._members.get(rule.types[term], ()))) for term in fresh)
        return is_apart, len(fresh.intersection(head)), values

    def _select(
        self, rule: Rule, literal: Literal, later: Collection[str], guards: Mapping[str, int] = NO_GUARDS
    ) -> tuple[int, tuple[str, ...]]:
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
        unequal = _unequal(rule, terms)
        columns = tuple(dict.fromkeys(t for t in terms if t in rule.types and t in later))
        places = tuple(terms.index(term) for term in columns)
        source = self._node(literal.predicate)
        limit = _limited(columns, guards)
        is_whole = places == tuple(range(len(terms)))
        if is_whole and not (allowed or equal or unequal) and limit is None:
            return source, columns
        shape = ("select", source, tuple(allowed), equal, unequal, places, limit)
        selection = _Selection(self._node(shape, limit), tuple(allowed), equal, unequal, _columns(places))
        self._consume(source, shape, selection)
        return selection.target, columns

    def _joined(
        self,
        rule: Rule,
        nodes: tuple[int, int],
        columns: tuple[tuple[str, ...], ...],
        later: Collection[str],
        guards: Mapping[str, int],
    ) -> tuple[int, tuple[str, ...]]:
        """The node of the two nodes' joined rows, only with the variables needed later."""
        left, right = columns
        key = [term for term in left if term in right]
        both = left + right
        kept = tuple(dict.fromkeys(term for term in both if term in later))
        keys = tuple(map(left.index, key)), tuple(map(right.index, key))
        columns_kept = tuple(map(both.index, kept))
        unequal = _unequal(rule, both)
        limit = _limited(kept, guards)
        shape = ("join", nodes, keys, columns_kept, unequal, limit)
        if shape in self._nodes:
            return self._nodes[shape], kept
        join = _Join(
            index=self.join_count,
            target=self._node(shape, limit),
            sources=nodes,
            keys=(_columns(keys[0]), _columns(keys[1])),
            columns=_columns(columns_kept),
            unequal=unequal,
        )
        self.join_count += 1
        self._consume(nodes[0], (shape, 0), (join, 0))
        self._consume(nodes[1], (shape, 1), (join, 1))
        return join.target, kept

    def _node(self, shape: Hashable, limit: _Limit | None = None) -> int:
        if shape not in self._nodes:
            self._nodes[shape] = len(self.consumers)
            self.consumers.append([])
            if limit is not None:
                self.limits[self._nodes[shape]] = _columns(limit.columns), limit.rows
        return self._nodes[shape]

    def _consume(
        self, node: int, shape: Hashable, consumer: "_Selection | tuple[_Join, int] | _Head"
    ) -> None:
        """Let the consumer have the node's rows, once for each shape."""
        if (node, shape) not in self._known:
            self._known.add((node, shape))
            self.consumers[node].append(consumer)


def _unequal(rule: Rule, terms: Sequence[str]) -> tuple[tuple[int, int], ...]:
    """The pairs of positions whose variables are to differ."""
    return tuple((terms.index(a), terms.index(b)) for a, b in rule.distinct if a in terms and b in terms)


def _guards(rule: Rule, known: Collection[str], later: Collection[str]) -> Mapping[str, int]:
    """The known variables that are needed later only to differ from others, each with the number of these."""
    return Counter(
        one
        for pair in rule.distinct
        for one, other in (pair, pair[::-1])
        if one in known and one not in later and other in later and other not in known
    )


def _limited(columns: Sequence[str], guards: Mapping[str, int]) -> _Limit | None:
    """How many rows are enough that differ in a guard alone, if there is one: one of them differs from all others."""
    found = [i for i, term in enumerate(columns) if term in guards]
    if len(found) != 1:
        return None
    others = tuple(i for i in range(len(columns)) if i not in found)
    return _Limit(columns=others, rows=1 + guards[columns[found[0]]])


class Closure:
    """What facts reach through a network.

    :param until: it is known to hold all that the facts reach, or these at least.
    """

    def __init__(self, network: Network, facts: Iterable[Fact], until: Iterable[Fact]) -> None:
        self._network = network
        self._reached: list[set[Row]] = [set() for _ in network.consumers]
        self._new: list[list[Row]] = [[] for _ in network.consumers]
        self._counts: dict[Place, int] = {}
        for fact in facts:
            if (place := network.place(fact)) is not None:
                self._reach(place[0], [place[1]])
        self._run({place for fact in until if (place := network.place(fact)) is not None})

    def holds(self, fact: Fact) -> bool:
        place = self._network.place(fact)
        return place is not None and self._is_reached(place)

    def _is_reached(self, place: Place) -> bool:
        return place[1] in self._reached[place[0]]

    def _run(self, wanted: Collection[Place]) -> None:
        tables: list[tuple[Table, Table]] = [({}, {}) for _ in range(self._network.join_count)]
        while any(self._new) and not (wanted and all(map(self._is_reached, wanted))):
            # A selection's and a join's node comes after its sources: rows pass through all of these in one round.
            for node, consumers in enumerate(self._network.consumers):
                rows, self._new[node] = self._new[node], []
                for consumer in consumers if rows else ():
                    if isinstance(consumer, tuple):
                        join, side = consumer
                        self._reach(join.target, join.rows(side, rows, tables[join.index]))
                    else:
                        self._reach(consumer.target, consumer.rows(rows))

    def _reach(self, node: int, rows: Iterable[Row]) -> None:
        """Let the node have those of the rows that are new, and that are needed."""
        known = self._reached[node]
        new = [row for row in dict.fromkeys(rows) if row not in known]
        if node in self._network.limits:
            new = [row for row in new if self._is_needed(node, row)]
        known.update(new)
        self._new[node] += new

    def _is_needed(self, node: int, row: Row) -> bool:
        """Whether fewer rows than are enough have been needed that are alike."""
        columns, enough = self._network.limits[node]
        alike = node, columns(row)
        self._counts[alike] = self._counts.get(alike, 0) + 1
        return self._counts[alike] <= enough


class Derivations:
    """What facts reach through a network, cheapest derivation first: `give` facts, `run`, then ask."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._tables: list[tuple[Table, Table]] = [({}, {}) for _ in range(network.join_count)]
        self._reached: dict[Place, _Derivation] = {}
        self._facts: dict[Place, Fact] = {}
        self._queue: list[tuple[int, int, int, Place, _Derivation]] = []
        self._serial = 0

    def give(self, fact: Fact, *, supposed: bool = False) -> None:
        """Let the fact hold from the start, as known or as supposed."""
        place = self._network.place(fact)
        if place is not None:
            self._facts.setdefault(place, fact)
            self._push(place, _Derivation(frozenset({fact}) if supposed else NOTHING, 0, ()))

    def run(self, until: Iterable[Fact] = ()) -> None:
        """Derive everything, or stop as soon as all of `until` are reached."""
        wanted = {place for fact in until if (place := self._network.place(fact)) is not None}
        waiting = wanted - self._reached.keys()
        while self._queue and (waiting or not wanted):
            *_, place, derivation = heapq.heappop(self._queue)
            if place not in self._reached:
                self._reached[place] = derivation
                waiting.discard(place)
                self._pass_on(place, derivation)

    def supposed(self, fact: Fact) -> frozenset[Fact] | None:
        """The supposed facts that the fact rests on; None if it is not reached."""
        derivation = self._reached.get(self._network.place(fact) or (-1, ()))
        return derivation.supposed if derivation else None

    def leaves(self, fact: Fact) -> frozenset[Fact]:
        """All given facts that the fact's derivation rests on."""
        leaves = set()
        seen = set()
        stack = [place for place in [self._network.place(fact)] if place in self._reached]
        while stack:
            place = stack.pop()
            if place is not None and place not in seen:
                seen.add(place)
                parents = self._reached[place].parents
                stack += parents
                if not parents:
                    leaves.add(self._facts[place])
        return frozenset(leaves)

    def _push(self, place: Place, derivation: _Derivation) -> None:
        if place not in self._reached:
            self._serial += 1
            rank = len(derivation.supposed), derivation.actions, self._serial
            heapq.heappush(self._queue, (*rank, place, derivation))

    def _pass_on(self, place: Place, derivation: _Derivation) -> None:
        node, row = place
        supposed = derivation.supposed
        actions = derivation.actions
        for consumer in self._network.consumers[node]:
            if isinstance(consumer, tuple):
                self._join(place, derivation, *consumer)
            elif (built := consumer.place(row)) is not None:
                took = actions + isinstance(consumer, _Head)
                self._push(built, _Derivation(supposed, took, (place,)))

    def _join(self, place: Place, derivation: _Derivation, join: _Join, side: int) -> None:
        row = place[1]
        key = join.keys[side](row)
        rows = self._tables[join.index]
        rows[side].setdefault(key, []).append(row)
        for other in rows[1 - side].get(key, ()):
            both = other + row if side else row + other
            if not join.allows(both):
                continue
            built = join.target, join.columns(both)
            if built not in self._reached:
                partner = join.sources[1 - side], other
                there = self._reached[partner]
                supposed = derivation.supposed | there.supposed
                actions = derivation.actions + there.actions
                self._push(built, _Derivation(supposed, actions, (place, partner)))


def _differing(rows: Iterable[Row], unequal: Iterable[tuple[int, int]]) -> Iterable[Row]:
    """Those of the rows whose values at these pairs of positions differ."""
    for i, j in unequal:
        rows = [row for row in rows if row[i] != row[j]]
    return rows


def _columns(positions: tuple[int, ...]) -> Callable[[Row], Row]:
    """A function that selects these positions of a row."""
    if len(positions) > 1:
        return itemgetter(*positions)
    if positions:
        (only,) = positions
        return lambda row: (row[only],)
    return lambda row: ()
