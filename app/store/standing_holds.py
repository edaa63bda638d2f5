"""Holds in the database: the places of a world that are kept empty now, and the facts that are kept true."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.goal_language.kept_facts import HoldFact
from app.domain.goal_language.stated_holds import HoldEnd, StandingHold, kept_words
from app.domain.lifecycles.hold import HoldState
from app.store.tables import HoldRow
from app.store.world_summary import summary_of


def standing_rows(session: Session, world: str) -> Sequence[HoldRow]:
    """The holds of a world that stand, oldest first."""
    if not summary_of(session, world).has_holds:
        return ()
    query = select(HoldRow).where(HoldRow.world == world, HoldRow.state == HoldState.HELD)
    return session.scalars(query.order_by(HoldRow.created_at, HoldRow.id)).all()


def standing_holds(session: Session, world: str) -> Sequence[StandingHold]:
    """As `standing_rows`, as planning needs them."""
    return [
        StandingHold(
            id=row.id,
            places=frozenset(row.kept),
            words=f"{kept_words(row.places, facts_of(row))} {end_in_words(row)}",
            facts=facts_of(row),
        )
        for row in standing_rows(session, world)
    ]


def facts_of(row: HoldRow) -> tuple[HoldFact, ...]:
    """The facts that the hold keeps true."""
    return tuple(HoldFact.model_validate(fact) for fact in row.facts)


def end_in_words(row: HoldRow) -> str:
    """Until when the hold stands, in words; a span by the time at which it ends."""
    if row.ends_at_s is not None:
        return f"until {row.ends_at_s:.0f} s by the world's clock"
    return HoldEnd.model_validate(row.until).words
