"""A plan's problem posed again: what the plan may be held against as the world is now."""

from dataclasses import dataclass

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import unrecorded
from app.domain.plan_document import PlanBody
from app.domain.states import PlanState
from app.domain.world_model import broken_support
from app.planning.problem_builder import ProblemBuilder
from app.store import GoalRow, PlanRow
from planner import PlanNet, PlanningProblem


@dataclass(frozen=True, slots=True, kw_only=True)
class CurrentProblem:
    """A plan-net and the problem that its goal poses now.

    :param is_current: the plan is open to decision and what it rests on is true. The problem then leaves what other
        missions need alone; else nothing is taken to be reserved.
    """

    goal: GoalRow
    plan_net: PlanNet
    problem: PlanningProblem
    is_current: bool
    world_version: int


def plan_row(session: Session, plan_id: str) -> PlanRow:
    """:raises NotFound: if there is no such plan."""
    plan = session.get(PlanRow, plan_id)
    if plan is None:
        raise unrecorded("plan", plan_id)
    return plan


def current_problem(session: Session, plan: PlanRow, posing: ProblemBuilder, core: Core) -> CurrentProblem:
    """:raises Conflict: if the plan's world does not run."""
    goal = session.get_one(GoalRow, plan.goal_id)
    posed = posing.pose(session, goal)
    net = PlanBody.model_validate(plan.body).to_plan_net(core.knowledge_base)
    is_current = plan.state == PlanState.PROPOSED and not broken_support(
        net, core.facts.facts(session, plan.world)
    )
    return CurrentProblem(
        goal=goal,
        plan_net=net,
        problem=posed.problem if is_current else posed.whole,
        is_current=is_current,
        world_version=posed.world_version,
    )
