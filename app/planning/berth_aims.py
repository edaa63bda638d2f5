"""Where the samples of plans that are open to decision, or were, are meant to end up."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sqlalchemy import or_, select
from sqlalchemy.orm import Session

from app.domain.goal_language.berth_choice import assign_berths
from app.domain.states import PlanState
from app.domain.world_model import Facts, Reservation
from app.store import GoalRow, PlanRow
from robots.wire import SymbolicFact
from robots.world import WorldFile


def with_chosen_berths(
    session: Session,
    goal: GoalRow,
    wanted: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    reserved: Reservation,
) -> Sequence[SymbolicFact]:
    """The goal with a berth for each location that has several.

    Those of its last plan, unless a mission took them; else rather such as no mission and no other open plan aims at.
    """
    if all(len(row) == 1 for row in world.rows.values()):
        return wanted
    ours, others = _aims(session, goal)
    return assign_berths(
        wanted, world, facts, preferred=ours - reserved.locations, avoid=others | reserved.locations
    )


def _aims(session: Session, goal: GoalRow) -> tuple[frozenset[str], frozenset[str]]:
    """The places that the goal's last plan and the open plans of other goals in its world aim at."""
    query = select(PlanRow.id, PlanRow.goal_id, PlanRow.body["goals"]).where(
        PlanRow.world == goal.world, or_(PlanRow.id == goal.plan_id, PlanRow.state == PlanState.PROPOSED)
    )
    plans = [(plan, of, _places(facts)) for plan, of, facts in session.execute(query)]
    ours = frozenset[str]().union(*(places for plan, _, places in plans if plan == goal.plan_id))
    others = frozenset[str]().union(*(places for _, of, places in plans if of != goal.id))
    return ours, others


def _places(facts: Iterable[Mapping[str, Any]]) -> frozenset[str]:
    return frozenset(fact["args"][-1] for fact in facts if fact["args"])
