"""The world model's facts in the record: each with its source and time, each change counted in the world's version."""

from collections.abc import Iterable, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.database import FactRow, WorldRow
from app.events import EventLog
from planner import Fact


class FactStore:
    """Reads and changes facts inside the caller's transaction."""

    def __init__(self, events: EventLog) -> None:
        self._events = events

    def facts(self, session: Session, world: str) -> frozenset[Fact]:
        return frozenset(Fact(row.predicate, tuple(row.args)) for row in self.rows(session, world))

    def rows(self, session: Session, world: str) -> Sequence[FactRow]:
        return session.scalars(select(FactRow).where(FactRow.world == world).order_by(FactRow.atom)).all()

    def version(self, session: Session, world: str) -> int:
        return session.scalars(select(WorldRow.version).where(WorldRow.id == world)).one()

    def lock(self, session: Session, world: str) -> WorldRow:
        """The world's row, for this transaction alone to its end."""
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
    ) -> int:
        """Make facts true and false; what is both removed and added is true. Answers the world's version after it."""
        row = self.lock(session, world)
        added, removed = set(add), set(remove)
        known = {fact.atom: fact for fact in self.rows(session, world)}
        gone = [known[str(fact)] for fact in removed - added if str(fact) in known]
        new = [fact for fact in sorted(added) if str(fact) not in known]
        for old in gone:
            session.delete(old)
        for fact in new:
            session.add(_row(world, fact, source, at_s))
        if gone or new:
            row.version += 1
            self._events.append(
                session,
                "world.facts_changed",
                world,
                version=row.version,
                source=source,
                added=[str(fact) for fact in new],
                removed=[old.atom for old in gone],
            )
        return row.version


def _row(world: str, fact: Fact, source: str, at_s: float) -> FactRow:
    return FactRow(
        world=world,
        atom=str(fact),
        predicate=fact.predicate,
        args=list(fact.args),
        source=source,
        at_s=at_s,
    )
