"""Goals and plans: state a goal, read what came of it, decide on a plan."""

from enum import Enum
from typing import Annotated

from fastapi import APIRouter, Header, Query

from app.api.bodies import Decision, GoalBody, Page, SubmitGoal, plan_body
from app.goals.desk import GoalDesk, GoalRequest
from app.plan_body import PlanBody
from app.plans.desk import PlanDesk
from app.states import GoalState, PlanState

Limit = Annotated[int, Query(ge=1, le=1000)]
IdempotencyKey = Annotated[str | None, Header(max_length=200)]
ACTOR = "administrator"
"""The one operator there is while there is one token."""
TAGS: list[str | Enum] = ["goals and plans"]


class Decided(PlanBody):
    """The plan after the decision, with the mission that came of it."""

    mission_id: str | None = None


def goals_router(goals: GoalDesk) -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.post("/goals", status_code=202)
    def submit_goal(body: SubmitGoal, idempotency_key: IdempotencyKey = None) -> GoalBody:
        """State a goal, as a sentence or structured. The answer comes before the plan; follow `state`."""
        request = GoalRequest(**{**body.model_dump(), "goal": body.goal})
        return GoalBody.of(goals.submit(request, actor=ACTOR, key=idempotency_key))

    @router.get("/goals")
    def list_goals(
        world: str | None = None, state: GoalState | None = None, limit: Limit = 100, after: str | None = None
    ) -> Page[GoalBody]:
        rows, token = goals.newest(world=world, state=state, limit=limit, after=after)
        return Page(items=[GoalBody.of(row) for row in rows], next=token)

    @router.get("/goals/{goal_id}")
    def get_goal(goal_id: str) -> GoalBody:
        return GoalBody.of(goals.get(goal_id))

    return router


def plans_router(plans: PlanDesk) -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/plans")
    def list_plans(
        goal_id: str | None = None,
        state: PlanState | None = None,
        limit: Limit = 100,
        after: str | None = None,
    ) -> Page[PlanBody]:
        rows, token = plans.newest(goal_id=goal_id, state=state, limit=limit, after=after)
        return Page(items=[plan_body(row) for row in rows], next=token)

    @router.get("/plans/{plan_id}")
    def get_plan(plan_id: str) -> PlanBody:
        return plan_body(plans.get(plan_id))

    @router.post("/plans/{plan_id}:approve", status_code=202)
    def approve_plan(plan_id: str, body: Decision | None = None) -> Decided:
        """Set the robots to work. 409 if the world has changed under the plan; a fresh one is then made."""
        comment = body.comment if body else ""
        row, mission_id = plans.approve(plan_id, actor=ACTOR, comment=comment)
        return Decided(**plan_body(row).model_dump(), mission_id=mission_id)

    @router.post("/plans/{plan_id}:reject", status_code=202)
    def reject_plan(plan_id: str, body: Decision | None = None) -> Decided:
        """Turn the plan down; its goal is withdrawn."""
        row = plans.reject(plan_id, actor=ACTOR, comment=body.comment if body else "")
        return Decided(**plan_body(row).model_dump())

    return router
