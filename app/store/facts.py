"""The world model's facts in the database: each with source and time; each change increments the world's version."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.events import Belief, FactsChanged, FactsContradicted
from app.domain.world_model.beliefs import CLEAR, ROBOT_POSITION, VACANT
from app.domain.world_model.timeliness import DatedFact, subjects_of
from app.domain.world_model.vocabulary import symbolic, symbolic_all
from app.store import FactRow, WorldRow
from app.store.event_log import EventLog
from app.store.unknowns import unknown_rows, update_unknowns
from planner import Fact, KnowledgeBase


class FactStore:
    """Reads and changes facts inside the caller's transaction."""

    def __init__(self, events: EventLog, knowledge_base: KnowledgeBase) -> None:
        self._events = events
        self._knowledge_base = knowledge_base

    def facts(self, session: Session, world: str) -> frozenset[Fact]:
        return frozenset(Fact(row.predicate, tuple(row.args)) for row in self.rows(session, world))

    def rows(self, session: Session, world: str) -> Sequence[FactRow]:
        return session.scalars(select(FactRow).where(FactRow.world == world).order_by(FactRow.atom)).all()

    def believed(self, session: Session, world: str) -> list[DatedFact]:
        """Every fact with its source and time."""
        return [_dated(row.predicate, row.args, row.source, row.at_s) for row in self.rows(session, world)]

    def dated(self, session: Session, world: str) -> Sequence[DatedFact]:
        """Every fact with its source and time, and the last beliefs of what has no place now."""
        last_beliefs = [
            _dated(row.believed["predicate"], row.believed["args"], row.source, row.since_s)
            for row in unknown_rows(session, world)
        ]
        return [*self.believed(session, world), *last_beliefs]

    def version(self, session: Session, world: str) -> int:
        return session.scalars(select(WorldRow.version).where(WorldRow.id == world)).one()

    def lock(self, session: Session, world: str) -> WorldRow:
        """The world's row, locked until the end of the transaction."""
        query = select(WorldRow).where(WorldRow.id == world).with_for_update()
        return session.scalars(query.execution_options(populate_existing=True)).one()

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
        """Add and remove facts; one that is in both is true. Returns the world's version afterwards.

        :param corrects: what is removed was believed wrongly, rather than ended: it stays visible as `instead_of`.
        """
        row = self.lock(session, world)
        added = set(add)
        removed = set(remove)
        known = {fact.atom: fact for fact in self.rows(session, world)}
        gone = [known[str(fact)] for fact in removed - added if str(fact) in known]
        new = [fact for fact in sorted(added) if str(fact) not in known]
        before = [_belief(old) for old in gone if corrects and not _is_passing(old, source)]
        for old in gone:
            session.delete(old)
            del known[old.atom]
        for fact in new:
            known[str(fact)] = _row(world, fact, source, at_s, before)
            session.add(known[str(fact)])
        update_unknowns(session, world, gone=gone, left=known.values(), source=source, at_s=at_s)
        if gone or new:
            row.version += 1
            self._events.append(
                session,
                FactsChanged(
                    subject=world,
                    version=row.version,
                    source=source,
                    added=self._relations(new),
                    removed=self._relations(Fact(old.predicate, tuple(old.args)) for old in gone),
                ),
            )
        if before:
            believed = tuple(map(self._belief, before))
            contradicted = FactsContradicted(subject=world, source=source, at_s=at_s, believed=believed)
            self._events.append(session, contradicted)
        return row.version

    def _relations(self, facts: Iterable[Fact]) -> tuple[str, ...]:
        """The facts as text in the rel/ref form of the API."""
        return tuple(str(fact) for fact in symbolic_all(facts, self._knowledge_base))

    def _belief(self, before: Mapping[str, Any]) -> Belief:
        fact = symbolic(Fact(before["predicate"], tuple(before["args"])), self._knowledge_base)
        return Belief(predicate=fact.predicate, args=fact.args, source=before["source"], at_s=before["at_s"])


def source_of(robot: str) -> str:
    """The source of facts that a robot reported."""
    return f"report of {robot}"


def _is_passing(old: FactRow, source: str) -> bool:
    """True of derived facts, and of the former position of a robot that reports its position itself."""
    if old.predicate == ROBOT_POSITION:
        return source == source_of(old.args[0])
    return old.predicate in (VACANT, CLEAR)


def _belief(row: FactRow) -> dict[str, Any]:
    return {"predicate": row.predicate, "args": list(row.args), "source": row.source, "at_s": row.at_s}


def _dated(predicate: str, args: Sequence[str], source: str, at_s: float) -> DatedFact:
    return DatedFact(fact=Fact(predicate, tuple(args)), source=source, at_s=at_s)


def _row(world: str, fact: Fact, source: str, at_s: float, before: Sequence[dict[str, Any]]) -> FactRow:
    """:param before: facts that were believed wrongly; those about the same things are kept with the new fact."""
    about = subjects_of(fact)
    contradicted = [
        one for one in before if not about.isdisjoint(subjects_of(Fact(one["predicate"], tuple(one["args"]))))
    ]
    return FactRow(
        world=world,
        atom=str(fact),
        predicate=fact.predicate,
        args=list(fact.args),
        source=source,
        at_s=at_s,
        instead_of=contradicted,
    )
