"""The numeric facts of worlds: each with source and time; each change increments the world's `numbers_version`."""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session

from app.domain.errors import Invalid
from app.domain.events import NumberChange, NumbersChanged
from app.domain.world_model.beliefs import Facts
from app.domain.world_model.layout import layout_of
from app.domain.world_model.numbers import (
    Things,
    check_term,
    check_value,
    counted_numbers,
    counted_predicates,
    initial_numbers,
)
from app.store import NumberRow, WorldRow
from app.store.event_log import EventLog
from app.store.records import lock_world
from app.store.tables import utc_now
from app.store.world_summary import summary_of
from planner import Fact, KnowledgeBase, Numbers
from planner.knowledge.comparison import Term
from robots.world import WorldFile

_CHANGED = "changed numbers"
"""Key of `Session.info`: the worlds whose numbers the transaction has changed."""
_THINGS = "things"
"""Key of `Session.info`: by world, what is in it."""
_LOCKED = "locked numbers"
"""Key of `Session.info`: the rows of the worlds that the transaction has locked, by world and term."""

# Made once: making a select() takes as long as executing it.
_LAYOUT = select(WorldRow.layout).where(WorldRow.id == bindparam("world"))


class NumberStore:
    """Reads and changes numeric facts inside the caller's transaction."""

    def __init__(self, events: EventLog, knowledge_base: KnowledgeBase) -> None:
        self._events = events
        self._knowledge_base = knowledge_base
        self._counted = counted_predicates(knowledge_base)
        self._read: dict[str, tuple[int, dict[Term, float]]] = {}
        """By world, the numbers read last, with their version."""
        self._things: dict[str, tuple[tuple[str | None, int], Things]] = {}
        """By world, what was in it when it was read last, with its run and edition then."""

    def numbers(self, session: Session, world: str) -> Numbers:
        """The world's numbers, read only if their version is another than at the last call."""
        known = self._read.get(world)
        version = self.version(session, world)
        if known is not None and known[0] == version:
            return known[1]
        rows = self.rows(session, world)
        numbers = {(row.quantity, tuple(row.args)): row.value for row in rows}
        # What this transaction has changed may be rolled back, and its version then be given to other numbers.
        if world not in session.info.get(_CHANGED, ()):
            self._read[world] = version, numbers
        return numbers

    def for_planner(self, session: Session, world: str) -> Numbers:
        """The numbers as plans name what they are of: those of a location for each of its berths."""
        numbers = self.numbers(session, world)
        if not numbers:
            return {}
        return self.things(session, world).for_planner(numbers)

    def things(self, session: Session, world: str) -> Things:
        """What numbers may be told of in a world; its layout is read only if its run or edition is another."""
        found: dict[str, Things] = session.info.setdefault(_THINGS, {})
        if world not in found:
            summary = summary_of(session, world)
            key = summary.run, summary.edition
            known = self._things.get(world)
            if known is None or known[0] != key:
                known = key, Things.of_layout(session.scalars(_LAYOUT, {"world": world}).one())
                self._things[world] = known
            found[world] = known[1]
        return found[world]

    def lay_out(self, session: Session, row: WorldRow, world: WorldFile) -> None:
        """Record how a world is laid out from now on, and what is in it."""
        self._things.pop(row.id, None)
        row.layout = layout = layout_of(world)
        session.info.setdefault(_THINGS, {})[row.id] = Things.of_layout(layout)

    def compared(self, session: Session, world: str) -> frozenset[Fact]:
        """The facts that stand for comparisons of numbers in actions and that hold now."""
        if not self._knowledge_base.comparisons:
            return frozenset()
        return self._knowledge_base.compared(self.for_planner(session, world))

    def rows(self, session: Session, world: str) -> Sequence[NumberRow]:
        query = select(NumberRow).where(NumberRow.world == world).order_by(NumberRow.term)
        return session.scalars(query).all()

    def version(self, session: Session, world: str) -> int:
        """The number of changes of the world's numbers."""
        return summary_of(session, world).numbers_version

    def set(
        self,
        session: Session,
        world: str,
        numbers: Numbers,
        *,
        source: str,
        at_s: float,
        is_told: bool = False,
    ) -> bool:
        """Give numbers new values. True if any has changed; of the others, source and time stay.

        :param is_told: they are a report, which counts only where nothing newer is known; of those that it finds
            unchanged, source and time are renewed.
        """
        locked = lock_world(session, world)
        rows = self._rows(session, locked)
        if is_told:
            numbers = {
                term: value
                for term, value in numbers.items()
                if (row := rows.get(_written(term))) is None or row.at_s <= at_s
            }
        return self._put(session, locked, numbers, source=source, at_s=at_s, renews=is_told)

    def count(
        self, session: Session, world: WorldRow, changed: Facts, facts: Facts, *, source: str, at_s: float
    ) -> None:
        """Count again what the change of facts has changed.

        :param world: locked.
        :param facts: after the change.
        """
        if self._counted.isdisjoint(fact.predicate for fact in changed):
            return
        counted = counted_numbers(facts, self.things(session, world.id), self._knowledge_base)
        self._put(session, world, counted, source=source, at_s=at_s)

    def complete(self, session: Session, world: WorldFile, facts: Facts, *, source: str, at_s: float) -> None:
        """Give what the world has, but no number is known of, its first one; drop the numbers of what is gone."""
        locked = lock_world(session, world.name)
        rows = self._rows(session, locked)
        first = initial_numbers(world, self._knowledge_base)
        things = Things.of(world)
        counted = counted_numbers(facts, things, self._knowledge_base)
        missing = {term: value for term, value in first.items() if _written(term) not in rows}
        gone = [row for row in rows.values() if not self._is_of(row, things, counted)]
        self._put(session, locked, {**missing, **counted}, source=source, at_s=at_s, gone=gone)

    def _is_of(self, row: NumberRow, things: Things, counted: Mapping[Term, float]) -> bool:
        """True if the row tells of what is in the world, in the vocabulary of the knowledge base."""
        spec = self._knowledge_base.quantities.get(row.quantity)
        if spec is not None and spec.counts:
            return (row.quantity, tuple(row.args)) in counted
        try:
            check_term(row.quantity, row.args, things, self._knowledge_base)
            check_value(row.quantity, row.value, self._knowledge_base)
        except Invalid:
            return False
        return True

    def _rows(self, session: Session, world: WorldRow) -> dict[str, NumberRow]:
        locked: dict[str, dict[str, NumberRow]] = session.info.setdefault(_LOCKED, {})
        if world.id not in locked:
            query = select(NumberRow).where(NumberRow.world == world.id)
            found = session.scalars(query.execution_options(populate_existing=True))
            locked[world.id] = {row.term: row for row in found}
        return locked[world.id]

    def _put(
        self,
        session: Session,
        world: WorldRow,
        numbers: Numbers,
        *,
        source: str,
        at_s: float,
        gone: Sequence[NumberRow] = (),
        renews: bool = False,
    ) -> bool:
        """:param world: locked. :param renews: an unchanged value of a later time is a change, too."""
        rows = self._rows(session, world)
        changed: list[NumberChange] = []
        for term, value in sorted(numbers.items()):
            row = rows.get(_written(term))
            if row is None or row.value != value or (renews and row.at_s < at_s):
                before = None if row is None else row.value
                changed.append(NumberChange(quantity=term[0], args=term[1], value=value, before=before))
        if not changed and not gone:
            return False
        world.numbers_version += 1
        session.info.setdefault(_CHANGED, set()).add(world.id)
        for row in gone:
            del rows[row.term]
            session.delete(row)
        for one in changed:
            written = _written((one.quantity, one.args))
            values = {"value": one.value, "source": source, "at_s": at_s, "version": world.numbers_version}
            if written in rows:
                _assign(rows[written], values)
            else:
                rows[written] = NumberRow(
                    world=world.id, term=written, quantity=one.quantity, args=list(one.args), **values
                )
                session.add(rows[written])
        event = NumbersChanged(
            subject=world.id,
            version=world.numbers_version,
            source=source,
            at_s=at_s,
            changed=tuple(changed),
            gone=tuple(sorted(row.term for row in gone)),
        )
        self._events.append(session, event)
        return True


def _assign(row: NumberRow, values: Mapping[str, Any]) -> None:
    for name, value in values.items():
        setattr(row, name, value)
    row.recorded_at = utc_now()


def _written(term: Term) -> str:
    """`battery(rover_1)`"""
    return str(Fact(*term))
