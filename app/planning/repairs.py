"""Plans that the world has overtaken are repaired, not planned from nothing: operators see what has changed."""

from dataclasses import dataclass, field

from sqlalchemy.orm import Session

from app.domain.plan_document import DifferenceBody, PlanBody, RepairsBody
from app.domain.states import PlanState
from app.store import GoalRow, PlanRow
from planner import (
    KnowledgeBase,
    KnowledgeBaseError,
    Observer,
    PlanNet,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
)
from planner.repair import NOT_BEGUN, MissionProgress, Repair, repair


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplacedPlan:
    """A plan of a goal that is to be replaced: it expired, or a mission cannot go on with it."""

    plan_id: str
    plan_net: PlanNet

    def repaired_by(self, repair: Repair) -> RepairsBody | None:
        """What the new plan says of this one; None if there is no new plan."""
        if repair.difference is None:
            return None
        difference = DifferenceBody.model_validate(repair.difference, from_attributes=True)
        return RepairsBody(plan_id=self.plan_id, course=repair.course, difference=difference)


def overtaken(session: Session, goal: GoalRow, knowledge_base: KnowledgeBase) -> ReplacedPlan | None:
    """The goal's last plan if it has expired; not if the knowledge base does not know its facts any more."""
    plan = session.get(PlanRow, goal.plan_id) if goal.plan_id else None
    if plan is None or plan.state != PlanState.EXPIRED:
        return None
    try:
        net = PlanBody.model_validate(plan.body).to_plan_net(knowledge_base)
    except KnowledgeBaseError:
        return None
    return ReplacedPlan(plan_id=plan.id, plan_net=net)


@dataclass(frozen=True, slots=True, kw_only=True)
class RepairWork:
    """The work of repairing a plan, of which some may be done."""

    knowledge_base: KnowledgeBase
    plan_net: PlanNet
    problem: PlanningProblem
    request: PlanningRequest
    progress: MissionProgress = field(default=NOT_BEGUN)

    def __call__(self, engine: PlanningEngine, observer: Observer) -> Repair:
        return repair(
            engine, self.knowledge_base, self.plan_net, self.problem, self.progress, self.request, observer
        )
