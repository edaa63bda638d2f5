"""The world model's facts in the database: each with source and time; each change increments the world's version.

They are kept in memory, too, by the world's run and version: a large world has thousands, and most transactions need
all.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from sqlalchemy import Table, bindparam, delete, insert, select, update
from sqlalchemy.orm import Session

from app.domain.events import Belief, FactsChanged, FactsContradicted
from app.domain.world_model.beliefs import DERIVED, ROBOT_POSITION
from app.domain.world_model.timeliness import DatedFact, subjects_of
from app.domain.world_model.vocabulary import symbolic, symbolic_all
from app.store import FactRow, UnknownRow, WorldRow, after_commit
from app.store.event_log import EventLog
from app.store.numbers import NumberStore
from app.store.records import lock_world
from app.store.tables import utc_now
from app.store.unknowns import INSTEAD_OF, PLACED, unknown_rows
from app.store.world_summary import forget_summary, summary_of
from planner import Fact, KnowledgeBase

REMEMBERED_BELIEFS = 5
"""How many contradicted beliefs a fact keeps, the newest (our choice)."""
_LOCKED = "locked facts"
"""Key of `Session.info`: the facts of the worlds that the transaction has locked, by world."""


# Made once: making a select() takes as long as executing it. One statement: the version and the facts of one instant.
_FACTS = (
    select(FactRow.predicate, FactRow.args, WorldRow.run, WorldRow.version)
    .join(WorldRow, WorldRow.id == FactRow.world)
    .where(FactRow.world == bindparam("world"))
)
_KNOWN = (
    select(FactRow.predicate, FactRow.args, FactRow.source, FactRow.at_s, FactRow.instead_of)
    .where(FactRow.world == bindparam("world"))
    .order_by(FactRow.atom)
)
# Of the table: no object of a session stands for a row of it.
_ROWS = cast(Table, FactRow.__table__)
_THESE = _ROWS.c.world == bindparam("of_world"), _ROWS.c.atom.in_(bindparam("atoms", expanding=True))
_FORGET = delete(_ROWS).where(*_THESE)
_SAY = (
    update(_ROWS)
    .where(*_THESE)
    .values(source=bindparam("new_source"), at_s=bindparam("new_at_s"), recorded_at=bindparam("now"))
)
_Belief = dict[str, Any]
"""An earlier belief as it is recorded with a fact: `predicate`, `args`, `source`, `at_s`."""


@dataclass(frozen=True, slots=True)
class _Known:
    """A believed fact.

    :param instead_of: earlier beliefs that it contradicts, newest first.
    """

    dated: DatedFact
    instead_of: Sequence[_Belief]

    @property
    def fact(self) -> Fact:
        return self.dated.fact


@dataclass(frozen=True, slots=True)
class _Kept:
    """A world's committed facts in memory.

    :param of: the world's run and version that they belong to.
    :param known: what is known of each; None if only the facts have been read.
    """

    of: tuple[str | None, int]
    facts: frozenset[Fact]
    known: Mapping[Fact, _Known] | None = None


class FactStore:
    """Reads and changes facts inside the caller's transaction."""

    def __init__(self, events: EventLog, knowledge_base: KnowledgeBase) -> None:
        self._events = events
        self._knowledge_base = knowledge_base
        self.numbers = NumberStore(events, knowledge_base)
        self._kept: dict[str, _Kept] = {}

    def facts(self, session: Session, world: str) -> frozenset[Fact]:
        """The world's facts, read only if they are not in memory."""
        locked = _locked_in(session).get(world)
        if locked is not None:
            return locked.facts
        kept = self._kept_now(session, world)
        if kept is not None:
            return kept.facts
        rows = session.execute(_FACTS, {"world": world}).all()
        facts = frozenset(Fact(row.predicate, tuple(row.args)) for row in rows)
        if rows:
            read = _Kept((rows[0].run, rows[0].version), facts)
            summary = summary_of(session, world)
            if read.of != (summary.run, summary.version):
                forget_summary(session, world)  # the facts are those of a later instant
            self._kept[world] = read
        return facts

    def _kept_now(self, session: Session, world: str) -> _Kept | None:
        """The world's facts in memory, if they are the present ones."""
        summary = summary_of(session, world)
        kept = self._kept.get(world)
        return kept if kept is not None and kept.of == (summary.run, summary.version) else None

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

    def believed(self, session: Session, world: str) -> Sequence[DatedFact]:
        """Every fact with its source and time."""
        locked = _locked_in(session).get(world)
        if locked is not None:
            return locked.believed
        kept = self._kept_now(session, world)
        known = _read(session, world) if kept is None or kept.known is None else kept.known
        return [one.dated for one in known.values()]

    def version(self, session: Session, world: str) -> int:
        """The number of changes of the world's facts."""
        return summary_of(session, world).version

    def lock(self, session: Session, world: str) -> WorldRow:
        """The world's row, locked until the end of the transaction."""
        return lock_world(session, world)

    def read_locked(self, session: Session, world: str) -> "WorldFacts":
        """Read the world's facts, once per transaction, and lock the world until its end."""
        locked = _locked_in(session)
        if world not in locked:
            row = self.lock(session, world)
            locked[world] = self._locked(session, row, self._known(session, row))
        return locked[world]

    def begin_run(self, session: Session, world: str) -> None:
        """Forget the world's facts: those of its new run follow."""
        row = self.lock(session, world)
        session.execute(delete(FactRow).where(FactRow.world == world))
        nothing = _Kept((row.run, row.version), frozenset(), {})
        _locked_in(session)[world] = self._locked(session, row, nothing)

    def _locked(self, session: Session, row: WorldRow, kept: _Kept) -> "WorldFacts":
        facts = WorldFacts(
            session,
            self._events,
            self._knowledge_base,
            numbers=self.numbers,
            world=row,
            kept=kept,
            unknown=unknown_rows(session, row.id),
        )
        after_commit(session, lambda: self._keep(row.id, facts.kept()))
        return facts

    def _keep(self, world: str, kept: _Kept) -> None:
        self._kept[world] = kept

    def _known(self, session: Session, row: WorldRow) -> _Kept:
        """The facts of a world that is locked, with their sources and times."""
        kept = self._kept.get(row.id)
        if kept is not None and kept.known is not None and kept.of == (row.run, row.version):
            return kept
        known = _read(session, row.id)
        return _Kept((row.run, row.version), frozenset(known), known)

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
        kept: _Kept,
        unknown: Iterable[UnknownRow],
    ) -> None:
        self._session = session
        self._events = events
        self._knowledge_base = knowledge_base
        self._numbers = numbers
        self._world = world
        self._known = dict(kept.known or {})
        self._unknown = {row.name: row for row in unknown}

    def kept(self) -> _Kept:
        """What is true of the world once the transaction has committed."""
        return _Kept((self._world.run, self._world.version), self.facts, self._known)

    @property
    def version(self) -> int:
        return self._world.version

    @property
    def facts(self) -> frozenset[Fact]:
        return frozenset(self._known)

    @property
    def believed(self) -> Sequence[DatedFact]:
        """Every fact with its source and time."""
        return [one.dated for one in self._known.values()]

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
        added = set(add)
        gone = [self._known[fact] for fact in sorted(set(remove) - added) if fact in self._known]
        new = [fact for fact in sorted(added) if fact not in self._known]
        again = [
            fact
            for fact in sorted(self._knowledge_base.achieved_each_time(added) - set(new))
            if self._known[fact].dated.at_s < at_s
        ]
        wrong = [old for old in gone if corrects and not _ends_as_expected(old.fact, source)]
        before = [_belief(old.dated) for old in wrong]
        history = [one for old in wrong for one in (_belief(old.dated), *old.instead_of)]
        if corrects:
            history += self._last_beliefs(fact.args[0] for fact in new if fact.predicate in PLACED)
        history.sort(key=lambda belief: belief["at_s"], reverse=True)
        removed = [old.fact for old in gone]
        self._forget(removed)
        self._believe(
            _Known(DatedFact(fact=fact, source=source, at_s=at_s), _contradicted(fact, history))
            for fact in new
        )
        self._say(again, source=source, at_s=at_s)
        self._note_unknown(gone, source=source, at_s=at_s)
        has_changed = bool(gone or new or again)
        if has_changed:
            self._world.version += 1
            self._events.append(
                self._session,
                FactsChanged(
                    subject=self._world.id,
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
            contradicted = FactsContradicted(
                subject=self._world.id, source=source, at_s=at_s, believed=believed
            )
            self._events.append(self._session, contradicted)
        return has_changed

    def attest(self, facts: Iterable[Fact], *, source: str, at_s: float) -> None:
        """Give believed facts another source, which says the same; those that have it already keep their time."""
        known = (self._known.get(fact) for fact in sorted(facts))
        others = [one.fact for one in known if one is not None and one.dated.source != source]
        if others:
            self._say(others, source=source, at_s=at_s)
            self._world.version += 1

    def _forget(self, facts: Collection[Fact]) -> None:
        """Delete facts that are known."""
        for fact in facts:
            del self._known[fact]
        if facts:
            self._session.execute(_FORGET, self._these(facts))

    def _believe(self, known: Iterable[_Known]) -> None:
        """Insert facts that are not known."""
        new = {one.fact: one for one in known}
        self._known |= new
        if new:
            rows = [{"world": self._world.id, **_row(one)} for one in new.values()]
            self._session.execute(insert(FactRow), rows)

    def _say(self, facts: Collection[Fact], *, source: str, at_s: float) -> None:
        """Give known facts another source and time."""
        for fact in facts:
            dated = replace(self._known[fact].dated, source=source, at_s=at_s)
            self._known[fact] = replace(self._known[fact], dated=dated)
        if facts:
            said = {"new_source": source, "new_at_s": at_s, "now": utc_now()}
            self._session.execute(_SAY, self._these(facts) | said)

    def _these(self, facts: Iterable[Fact]) -> dict[str, Any]:
        """What `_FORGET` and `_SAY` ask for: these facts of the world."""
        return {"of_world": self._world.id, "atoms": [str(fact) for fact in facts]}

    def _delete(self, row: UnknownRow) -> None:
        """Delete a row, which an earlier change of the same transaction may have added."""
        if row in self._session.new:
            self._session.expunge(row)
        else:
            self._session.delete(row)

    def _last_beliefs(self, names: Iterable[str]) -> list[_Belief]:
        """What was last believed about objects and robots whose place is unknown, newest first."""
        rows = [self._unknown[name] for name in names if name in self._unknown]
        return [one for row in rows for one in (_unknown_belief(row), *row.believed.get(INSTEAD_OF, ()))]

    def _note_unknown(self, gone: Iterable[_Known], *, source: str, at_s: float) -> None:
        """Keep the last belief about each object and robot that has lost its place, until it has one again."""
        placed = {fact.args[0] for fact in self._known if fact.predicate in PLACED}
        for name in placed & self._unknown.keys():
            self._delete(self._unknown.pop(name))
        for old in gone:
            name = old.fact.args[0]
            if old.fact.predicate not in PLACED or name in placed:
                continue
            unknown = self._unknown.setdefault(name, UnknownRow(world=self._world.id, name=name))
            unknown.believed = {
                "predicate": old.fact.predicate,
                "args": list(old.fact.args),
                INSTEAD_OF: list(old.instead_of),
            }
            unknown.believed_by = old.dated.source
            unknown.believed_at_s = old.dated.at_s
            unknown.source = source
            unknown.since_s = at_s
            self._session.add(unknown)

    def _relations(self, facts: Iterable[Fact]) -> tuple[str, ...]:
        """The facts as text in the rel/ref form of the API."""
        return tuple(str(fact) for fact in symbolic_all(facts, self._knowledge_base))

    def _belief(self, before: Mapping[str, Any]) -> Belief:
        fact = symbolic(Fact(before["predicate"], tuple(before["args"])), self._knowledge_base)
        return Belief(predicate=fact.predicate, args=fact.args, source=before["source"], at_s=before["at_s"])


def _locked_in(session: Session) -> dict[str, WorldFacts]:
    """The facts of the worlds that the transaction has locked and read, by world."""
    return session.info.setdefault(_LOCKED, {})  # type: ignore[no-any-return]


def _read(session: Session, world: str) -> dict[Fact, _Known]:
    """What is recorded of each fact."""
    known = {}
    for *dated, instead_of in session.execute(_KNOWN, {"world": world}):
        one = _dated(*dated)
        known[one.fact] = _Known(one, instead_of)
    return known


def source_of(robot: str) -> str:
    """The source of facts that a robot reported."""
    return f"report of {robot}"


def factsheet_of(robot: str) -> str:
    """The source of facts that a robot announced of itself."""
    return f"factsheet of {robot}"


def _ends_as_expected(old: Fact, source: str) -> bool:
    """True if a removal corrects no belief: of a derived fact, or of a position whose robot reports a new one."""
    if old.predicate == ROBOT_POSITION:
        return source == source_of(old.args[0])
    return old.predicate in DERIVED


def _belief(known: DatedFact) -> _Belief:
    fact = known.fact
    return {
        "predicate": fact.predicate,
        "args": list(fact.args),
        "source": known.source,
        "at_s": known.at_s,
    }


def _unknown_belief(row: UnknownRow) -> _Belief:
    said = {"predicate": row.believed["predicate"], "args": list(row.believed["args"])}
    return {**said, "source": row.believed_by, "at_s": row.believed_at_s}


def _dated(predicate: str, args: Sequence[str], source: str, at_s: float) -> DatedFact:
    return DatedFact(fact=Fact(predicate, tuple(args)), source=source, at_s=at_s)


def _contradicted(fact: Fact, history: Sequence[_Belief]) -> Sequence[_Belief]:
    """What a new fact contradicts.

    :param history: wrong beliefs, newest first; those about the same objects are kept with the fact.
    """
    about = subjects_of(fact)
    contradicted = dict[Fact, _Belief]()
    for belief in history:
        one = Fact(belief["predicate"], tuple(belief["args"]))
        if one != fact and not about.isdisjoint(subjects_of(one)):
            contradicted.setdefault(one, belief)
    return list(contradicted.values())[:REMEMBERED_BELIEFS]


def _row(known: _Known) -> dict[str, Any]:
    return {
        **_belief(known.dated),
        "atom": str(known.fact),
        "instead_of": list(known.instead_of),
        "recorded_at": utc_now(),
    }
