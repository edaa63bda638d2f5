"""What the world has overtaken of a plan: facts it rests on, robots, what other missions have taken."""

from collections.abc import Iterator, Sequence

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.world_model import broken_support, taken_by
from app.domain.world_model.timeliness import DatedFact, beliefs_contradicting
from app.domain.world_model.vocabulary import symbolic
from app.store import GoalRow, PlanRow
from app.store.records import lost_robot_reasons
from planner import Fact, PlanNet


class Staleness:
    """Holds plans that wait for a decision against the world as it is."""

    def __init__(self, core: Core) -> None:
        self._facts, self._holdings = core.facts, core.holdings
        self._plan_nets, self._knowledge_base = core.plan_nets, core.knowledge_base

    def of(self, session: Session, plan: PlanRow, goal: GoalRow) -> list[str]:
        """What of the plan does not hold any more, each in words, and what is so instead; empty if all of it holds."""
        net = self._plan_nets.of(session, plan.id)
        gone = broken_support(net, self._facts.facts(session, plan.world))
        believed = self._facts.believed(session, plan.world) if gone else ()
        return [
            *(self._change(fact, believed) for fact in gone),
            *self._lost(session, net, plan.world),
            *self._taken(session, net, goal),
        ]

    def _change(self, fact: Fact, believed: Sequence[DatedFact]) -> str:
        now = [
            f"{self._said(one.fact)}, {one.source} at {one.at_s:.0f} s"
            for one in beliefs_contradicting(fact, believed)
        ]
        return f"{self._said(fact)} is no longer true" + (f": now {' and '.join(now)}" if now else "")

    def _said(self, fact: Fact) -> str:
        return str(symbolic(fact, self._knowledge_base))

    def _lost(self, session: Session, net: PlanNet, world: str) -> Iterator[str]:
        lost = lost_robot_reasons(session, world)
        return (f"{robot} was declared lost" for robot in net.robots if robot in lost)

    def _taken(self, session: Session, net: PlanNet, goal: GoalRow) -> Iterator[str]:
        mine = taken_by(net)
        for held in self._holdings.of_world(session, goal.world):
            if held.mission_id != goal.mission_id and mine.overlaps(held.reservation):
                shared = ", ".join(mine.shared(held.reservation))
                yield f"{shared} now belong to mission {held.mission_id}"
