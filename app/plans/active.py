"""What running missions hold: their robots, places and samples are not to be planned with."""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.database import MissionRow, PlanRow
from app.plan_body import PlanBody
from app.states import ENDED
from app.world_model import Reservation, reservation_of
from planner import KnowledgeBase


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """A running mission and what it holds."""

    mission_id: str
    reservation: Reservation

    def __str__(self) -> str:
        names = sorted({*self.reservation.robots, *self.reservation.locations, *self.reservation.samples})
        return f"mission {self.mission_id}, which uses {', '.join(names)}"


def held_by_missions(session: Session, world: str, knowledge_base: KnowledgeBase) -> Sequence[Held]:
    """The running missions of a world, oldest first."""
    query = (
        select(MissionRow.id, PlanRow.body)
        .join(PlanRow, PlanRow.id == MissionRow.plan_id)
        .where(MissionRow.world == world, MissionRow.state.not_in(ENDED))
        .order_by(MissionRow.created_at, MissionRow.id)
    )
    return [
        Held(
            mission_id=mission_id,
            reservation=reservation_of(PlanBody.model_validate(body).to_plan_net(knowledge_base)),
        )
        for mission_id, body in session.execute(query)
    ]


def all_reserved(held: Sequence[Held]) -> Reservation:
    """Everything that some running mission holds."""
    return Reservation(
        robots=frozenset().union(*(h.reservation.robots for h in held)),
        locations=frozenset().union(*(h.reservation.locations for h in held)),
        samples=frozenset().union(*(h.reservation.samples for h in held)),
    )
