"""The world model's facts in the database: each with source and time; each change increments the world's version."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session

from app.domain.events import Belief, FactsChanged, FactsContradicted
from app.domain.world_model.beliefs import DERIVED, ROBOT_POSITION
from app.domain.world_model.timeliness import DatedFact, subjects_of
from app.domain.world_model.vocabulary import symbolic, symbolic_all
from app.store import FactRow, UnknownRow, WorldRow
from app.store.event_log import EventLog
from app.store.numbers import NumberStore
from app.store.records import lock_world
from app.store.tables import utc_now
from app.store.unknowns import INSTEAD_OF, PLACED, unknown_rows
from app.store.world_summary import forget_summary, summary_of
from planner import Fact, KnowledgeBase

REMEMBERED_BELIEFS = 5
"""How many contradicted beliefs a fact keeps, the newest (our choice)."""
_CHANGED = "changed facts"
"""Key of `Session.info`: the worlds whose facts the transaction has changed."""
_LOCKED = "locked facts"
"""Key of `Session.info`: the facts of the worlds that the transaction has locked, by world."""


# Made once: making a select() takes as long as executing it. One statement: the version and the facts of one instant.
_FACTS = (
    select(FactRow.predicate, FactRow.args, WorldRow.version)
    .join(WorldRow, WorldRow.id == FactRow.world)
    .where(FactRow.world == bindparam("world"))
)


class FactStore:
    """Reads and changes facts inside the caller's transaction."""

    def __init__(self, events: EventLog, knowledge_base: KnowledgeBase) -> None:
        self._events = events
        self._knowledge_base = knowledge_base
        self.numbers = NumberStore(events, knowledge_base)
        self._read: dict[str, tuple[int, frozenset[Fact]]] = {}
        """By world, the facts read last, with their version."""

    def facts(self, session: Session, world: str) -> frozenset[Fact]:
        """The world's facts, read only if its version is another than at the last call."""
        version, facts = self._read.get(world, (None, frozenset()))
        if version is not None and version == self.version(session, world):
            return facts
        rows = session.execute(_FACTS, {"world": world}).all()
        if rows and rows[0].version != self.version(session, world):
            forget_summary(session, world)  # the facts are those of a later instant
        facts = frozenset(Fact(row.predicate, tuple(row.args)) for row in rows)
        # What this transaction has changed may be rolled back, and its version then be given to other facts.
        if rows and world not in session.info.get(_CHANGED, ()):
            self._read[world] = rows[0].version, facts
        return facts

    def supporting(self, session: Session, world: str) -> frozenset[Fact]:
        """The world's facts and those that stand for comparisons of its numbers: what plans may rest on."""
        return self.facts(session, world) | self.numbers.compared(session, world)

    def counting_for(
        self, session: Session, world: str, goals: Iterable[Fact], *, since_s: float | None
    ) -> frozenset[Fact]:
        """The world's facts without those goals that are to be achieved each time and not yet achieved.

        :param since_s: such a goal counts as achieved if it has become true since then; None: it does not count.
        """
        facts = self.facts(session, world)
        before = self._knowledge_base.achieved_each_time(goals) & facts
        if before and since_s is not None:
            columns = (FactRow.predicate, FactRow.args)
            atoms = [str(fact) for fact in before]
            query = select(*columns).where(
                FactRow.world == world, FactRow.atom.in_(atoms), FactRow.at_s < since_s
            )
            before = frozenset(Fact(row.predicate, tuple(row.args)) for row in session.execute(query))
        return facts - before

    def rows(self, session: Session, world: str) -> Sequence[FactRow]:
        return session.scalars(select(FactRow).where(FactRow.world == world).order_by(FactRow.atom)).all()

    def believed(self, session: Session, world: str) -> list[DatedFact]:
        """Every fact with its source and time."""
        return [_dated(row.predicate, row.args, row.source, row.at_s) for row in self.rows(session, world)]

    def version(self, session: Session, world: str) -> int:
        """The number of changes of the world's facts."""
        return summary_of(session, world).version

    def lock(self, session: Session, world: str) -> WorldRow:
        """The world's row, locked until the end of the transaction."""
        return lock_world(session, world)

    def read_locked(self, session: Session, world: str) -> "WorldFacts":
        """Read the world's facts, once per transaction, and lock the world until its end."""
        locked: dict[str, WorldFacts] = session.info.setdefault(_LOCKED, {})
        if world not in locked:
            locked[world] = WorldFacts(
                session,
                self._events,
                self._knowledge_base,
                numbers=self.numbers,
                world=self.lock(session, world),
                rows=self.rows(session, world),
                unknown=unknown_rows(session, world),
            )
        return locked[world]

    def change(
        self,
        session: Session,
        world: str,
        *,
        add: Iterable[Fact] = (),
        remove: Iterable[Fact] = (),
        source: str,
        at_s: float,
        corrects: bool = False,
    ) -> int:
        """Change the world's facts as `WorldFacts.change` does; returns the world's new version."""
        facts = self.read_locked(session, world)
        facts.change(add=add, remove=remove, source=source, at_s=at_s, corrects=corrects)
        return facts.version

    def attest(
        self, session: Session, world: str, facts: Iterable[Fact], *, source: str, at_s: float
    ) -> None:
        """Give facts of the world a source of their own, as `WorldFacts.attest` does."""
        self.read_locked(session, world).attest(facts, source=source, at_s=at_s)


class WorldFacts:
    """All facts of one world in one transaction: read once, with the world locked, and changed together."""

    def __init__(
        self,
        session: Session,
        events: EventLog,
        knowledge_base: KnowledgeBase,
        *,
        numbers: NumberStore,
        world: WorldRow,
        rows: Iterable[FactRow],
        unknown: Iterable[UnknownRow],
    ) -> None:
        self._session = session
        self._events = events
        self._knowledge_base = knowledge_base
        self._numbers = numbers
        self._world = world
        self._rows = {row.atom: row for row in rows}
        self._facts = frozenset(Fact(row.predicate, tuple(row.args)) for row in self._rows.values())
        self._unknown = {row.name: row for row in unknown}

    @property
    def version(self) -> int:
        return self._world.version

    @property
    def facts(self) -> frozenset[Fact]:
        return self._facts

    @property
    def believed(self) -> Sequence[DatedFact]:
        """Every fact with its source and time."""
        return [_dated(row.predicate, row.args, row.source, row.at_s) for row in self._rows.values()]

    @property
    def dated(self) -> Sequence[DatedFact]:
        """Every fact with its source and time, and the last believed place of objects and robots without one."""
        last_places = [
            _dated(row.believed["predicate"], row.believed["args"], row.source, row.since_s)
            for row in self._unknown.values()
        ]
        return [*self.believed, *last_places]

    def change(
        self,
        *,
        add: Iterable[Fact] = (),
        remove: Iterable[Fact] = (),
        source: str,
        at_s: float,
        corrects: bool = False,
    ) -> bool:
        """Add and remove facts; a fact in both is added. True if anything has changed.

        A fact that tells of something done gets the new source and time if it is added again.
        :param corrects: the removed facts were wrong, rather than true until now. New facts about the same objects keep
            them, and the beliefs that they had replaced, as `instead_of`.
        """
        world = self._world.id
        added = set(add)
        gone = [self._rows[str(fact)] for fact in sorted(set(remove) - added) if str(fact) in self._rows]
        new = [fact for fact in sorted(added) if str(fact) not in self._rows]
        again = [
            fact
            for fact in sorted(self._knowledge_base.achieved_each_time(added) - set(new))
            if self._rows[str(fact)].at_s < at_s
        ]
        wrong = [old for old in gone if corrects and not _ends_as_expected(old, source)]
        before = [_belief(old) for old in wrong]
        history = [one for old in wrong for one in (_belief(old), *old.instead_of)]
        if corrects:
            history += self._last_beliefs(fact.args[0] for fact in new if fact.predicate in PLACED)
        history.sort(key=lambda belief: belief["at_s"], reverse=True)
        for old in gone:
            self._delete(old)
            del self._rows[old.atom]
        for fact in new:
            self._rows[str(fact)] = _row(world, fact, source, at_s, history)
            self._session.add(self._rows[str(fact)])
        for fact in again:
            row = self._rows[str(fact)]
            row.source = source
            row.at_s = at_s
            row.recorded_at = utc_now()
        removed = [Fact(old.predicate, tuple(old.args)) for old in gone]
        self._facts = self._facts.difference(removed).union(new)
        self._note_unknown(gone, source=source, at_s=at_s)
        has_changed = bool(gone or new or again)
        if has_changed:
            self._world.version += 1
            self._session.info.setdefault(_CHANGED, set()).add(world)
            self._events.append(
                self._session,
                FactsChanged(
                    subject=world,
                    version=self._world.version,
                    source=source,
                    added=self._relations([*new, *again]),
                    removed=self._relations(removed),
                ),
            )
            changed = frozenset((*removed, *new))
            self._numbers.count(self._session, self._world, changed, self.facts, source=source, at_s=at_s)
        if before:
            believed = tuple(map(self._belief, before))
            contradicted = FactsContradicted(subject=world, source=source, at_s=at_s, believed=believed)
            self._events.append(self._session, contradicted)
        return has_changed

    def attest(self, facts: Iterable[Fact], *, source: str, at_s: float) -> None:
        """Give believed facts another source, which says the same; those that have it already keep their time."""
        known = (self._rows.get(str(fact)) for fact in sorted(facts))
        rows = [row for row in known if row is not None and row.source != source]
        for row in rows:
            row.source = source
            row.at_s = at_s
            row.recorded_at = utc_now()
        if rows:
            self._world.version += 1
            self._session.info.setdefault(_CHANGED, set()).add(self._world.id)

    def _delete(self, row: FactRow | UnknownRow) -> None:
        """Delete a row, which an earlier change of the same transaction may have added."""
        if row in self._session.new:
            self._session.expunge(row)
        else:
            self._session.delete(row)

    def _last_beliefs(self, names: Iterable[str]) -> list[dict[str, Any]]:
        """What was last believed about objects and robots whose place is unknown, newest first."""
        rows = [self._unknown[name] for name in names if name in self._unknown]
        return [one for row in rows for one in (_unknown_belief(row), *row.believed.get(INSTEAD_OF, ()))]

    def _note_unknown(self, gone: Iterable[FactRow], *, source: str, at_s: float) -> None:
        """Keep the last belief about each object and robot that has lost its place, until it has one again."""
        placed = {row.args[0] for row in self._rows.values() if row.predicate in PLACED}
        for name in placed & self._unknown.keys():
            self._delete(self._unknown.pop(name))
        for row in gone:
            name = row.args[0]
            if row.predicate not in PLACED or name in placed:
                continue
            unknown = self._unknown.setdefault(name, UnknownRow(world=self._world.id, name=name))
            unknown.believed = {
                "predicate": row.predicate,
                "args": list(row.args),
                INSTEAD_OF: list(row.instead_of),
            }
            unknown.believed_by = row.source
            unknown.believed_at_s = row.at_s
            unknown.source = source
            unknown.since_s = at_s
            self._session.add(unknown)

    def _relations(self, facts: Iterable[Fact]) -> tuple[str, ...]:
        """The facts as text in the rel/ref form of the API."""
        return tuple(str(fact) for fact in symbolic_all(facts, self._knowledge_base))

    def _belief(self, before: Mapping[str, Any]) -> Belief:
        fact = symbolic(Fact(before["predicate"], tuple(before["args"])), self._knowledge_base)
        return Belief(predicate=fact.predicate, args=fact.args, source=before["source"], at_s=before["at_s"])


def source_of(robot: str) -> str:
    """The source of facts that a robot reported."""
    return f"report of {robot}"


def factsheet_of(robot: str) -> str:
    """The source of facts that a robot announced of itself."""
    return f"factsheet of {robot}"


def _ends_as_expected(old: FactRow, source: str) -> bool:
    """True if a removal corrects no belief: of a derived fact, or of a position whose robot reports a new one."""
    if old.predicate == ROBOT_POSITION:
        return source == source_of(old.args[0])
    return old.predicate in DERIVED


def _belief(row: FactRow) -> dict[str, Any]:
    return {"predicate": row.predicate, "args": list(row.args), "source": row.source, "at_s": row.at_s}


def _unknown_belief(row: UnknownRow) -> dict[str, Any]:
    said = {"predicate": row.believed["predicate"], "args": list(row.believed["args"])}
    return {**said, "source": row.believed_by, "at_s": row.believed_at_s}


def _dated(predicate: str, args: Sequence[str], source: str, at_s: float) -> DatedFact:
    return DatedFact(fact=Fact(predicate, tuple(args)), source=source, at_s=at_s)


def _row(world: str, fact: Fact, source: str, at_s: float, history: Sequence[dict[str, Any]]) -> FactRow:
    """A new row for the fact.

    :param history: wrong beliefs, newest first; those about the same objects are kept with the fact.
    """
    about = subjects_of(fact)
    contradicted = dict[Fact, dict[str, Any]]()
    for belief in history:
        one = Fact(belief["predicate"], tuple(belief["args"]))
        if one != fact and not about.isdisjoint(subjects_of(one)):
            contradicted.setdefault(one, belief)
    return FactRow(
        world=world,
        atom=str(fact),
        predicate=fact.predicate,
        args=list(fact.args),
        source=source,
        at_s=at_s,
        instead_of=list(contradicted.values())[:REMEMBERED_BELIEFS],
    )
