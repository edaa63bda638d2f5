"""Routes of goals and plans."""

from collections.abc import Sequence
from enum import Enum

from fastapi import APIRouter, Response

from app.api.bodies import (
    Approval,
    CheckedGoal,
    CheckGoal,
    Decision,
    EditPlan,
    GoalBody,
    Page,
    PlanChoice,
    SeekAlternatives,
    StatedFact,
    SubmitGoal,
    goal_document,
    plan_body,
)
from app.api.parameters import After, Id, IdempotencyKey, Limit, NameFilter
from app.api.plan_json import JSON, json_of, json_page
from app.api.problems import declared
from app.api.services import AppServices
from app.domain.explanation_document import ActionExplanationBody, ExplanationBody
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.plan import PlanState
from app.domain.plan_document import PlanBody
from app.planning.export import PddlBody
from app.planning.goal_service import GoalRequest
from app.planning.limits import PlanningWish
from planner.interchange.pddl import Form
from robots.wire import SymbolicFact

ACTOR = "administrator"
"""The operator of all requests: there is only one token."""
TAGS: list[str | Enum] = ["goals and plans"]


class Decided(PlanBody):
    """The plan after the decision; `mission_id` if it was approved."""

    mission_id: str | None = None


def _facts(stated: Sequence[StatedFact] | None) -> Sequence[SymbolicFact] | None:
    if stated is None:
        return None
    return [SymbolicFact(predicate=one.predicate, args=one.args) for one in stated]


def goals_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.post("/goals", status_code=202, responses=declared(404, 409, 429))
    def submit_goal(
        services: AppServices, body: SubmitGoal, idempotency_key: IdempotencyKey = None
    ) -> GoalBody:
        """Submit a goal, as a sentence or structured. The answer comes before the plan; follow `state`."""
        wish = PlanningWish(time_limit_s=body.time_limit_s, effort_s=body.effort_s, objective=body.objective)
        given = body.model_dump(exclude={"time_limit_s", "effort_s", "objective"})
        stated = {
            "goal": _facts(body.goal),
            "constraints": body.constraints,
            "holds": body.holds,
            "planning": wish,
        }
        request = GoalRequest(**{**given, **stated})
        return GoalBody.of(services.goals.submit(request, actor=ACTOR, key=idempotency_key))

    @router.post("/goals:check", responses=declared(404))
    def check_goal(services: AppServices, body: CheckGoal) -> CheckedGoal:
        """How a goal is understood, what it lacks, and how it can be completed. Nothing is recorded."""
        request = GoalRequest(
            world=body.world,
            text=body.text,
            goal=_facts(body.goal),
            constraints=body.constraints,
            holds=body.holds,
        )
        return CheckedGoal.model_validate(services.goals.check(request), from_attributes=True)

    @router.get("/goals", response_model=Page[GoalBody])
    def list_goals(
        services: AppServices,
        world: NameFilter = None,
        state: GoalState | None = None,
        limit: Limit = 100,
        after: After = None,
    ) -> Response:
        rows, token = services.goals.newest(world=world, state=state, limit=limit, after=after)
        return json_page((json_of(goal_document(row)) for row in rows), token)

    @router.get("/goals/{goal_id}")
    def get_goal(services: AppServices, goal_id: Id) -> GoalBody:
        """A goal and its state; `planning` shows the progress while it is planned."""
        return GoalBody.of(services.goals.get(goal_id))

    @router.post("/goals/{goal_id}:stop", status_code=202, responses=declared(409))
    def stop_planning(services: AppServices, goal_id: Id) -> GoalBody:
        """Stop planning and take the best plan so far. 409 if planning has not begun."""
        return GoalBody.of(services.goals.stop(goal_id, actor=ACTOR))

    @router.post("/goals/{goal_id}:cancel", status_code=202, responses=declared(409))
    def cancel_goal(services: AppServices, goal_id: Id, body: Decision | None = None) -> GoalBody:
        """Withdraw a goal; its planning ends. 409 once a mission runs for it."""
        return GoalBody.of(services.goals.cancel(goal_id, actor=ACTOR, comment=body.comment if body else ""))

    @router.post("/goals/{goal_id}:alternatives", status_code=202, responses=declared(409))
    def seek_alternatives(
        services: AppServices, goal_id: Id, body: SeekAlternatives | None = None
    ) -> GoalBody:
        """Find alternatives to the proposed plan; follow `alternatives`. 409 if no plan waits for a decision."""
        count = (body or SeekAlternatives()).count
        return GoalBody.of(services.alternatives.search(goal_id, count, actor=ACTOR))

    @router.get("/goals/{goal_id}/plans")
    def compare_plans(services: AppServices, goal_id: Id) -> Page[PlanChoice]:
        """The goal's open plans with their figures, shortest first. Approving one supersedes the others."""
        rows = services.alternatives.plans(goal_id)
        return Page(items=[PlanChoice.of(row, start_s=services.plans.start_of(row)) for row in rows])

    return router


def plans_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/plans", response_model=Page[PlanBody])
    def list_plans(
        services: AppServices,
        goal_id: NameFilter = None,
        state: PlanState | None = None,
        limit: Limit = 100,
        after: After = None,
    ) -> Response:
        known = services.plan_json.known()
        rows, token = services.plans.newest(
            goal_id=goal_id, state=state, limit=limit, after=after, without_body=known
        )
        return json_page(
            [services.plan_json.of(row, known, start=services.plans.start_of) for row in rows], token
        )

    @router.get("/plans/{plan_id}", response_model=PlanBody)
    def get_plan(services: AppServices, plan_id: Id) -> Response:
        known = services.plan_json.known()
        row = services.plans.get(plan_id, without_body=known)
        shown = services.plan_json.of(
            row, known, services.plans.why_stale(row), start=services.plans.start_of
        )
        return Response(shown, media_type=JSON)

    @router.get("/plans/{plan_id}/explanation", responses=declared(409))
    def explain_plan(services: AppServices, plan_id: Id) -> ExplanationBody:
        """The reasons for the plan; for an open plan also what it costs to do without each robot."""
        return services.explanations.explanation(plan_id)

    @router.get("/plans/{plan_id}/actions/{action_id}/explanation", responses=declared(409))
    def explain_action(services: AppServices, plan_id: Id, action_id: Id) -> ActionExplanationBody:
        """The reasons for one action, its robots and its place in the order."""
        return services.explanations.of_action(plan_id, action_id)

    @router.get("/plans/{plan_id}/pddl", responses=declared(409))
    def plan_as_pddl(services: AppServices, plan_id: Id, form: Form = Form.TEMPORAL) -> PddlBody:
        """The problem of the plan's goal as PDDL: temporal (2.1, durative actions), numeric (the same with
        the numbers that plans keep, such as batteries), or classical with action costs."""
        return services.export.pddl(plan_id, form)

    @router.post("/plans/{plan_id}:approve", status_code=202, responses=declared(409))
    def approve_plan(services: AppServices, plan_id: Id, body: Approval | None = None) -> Decided:
        """Approve the plan and start its mission. 409 if the world has changed since; the plan is then repaired."""
        body = body or Approval()
        row, mission_id = services.plans.approve(
            plan_id, actor=ACTOR, comment=body.comment, delegate=body.delegate
        )
        return Decided(**plan_body(row).model_dump(), mission_id=mission_id)

    @router.post("/plans/{plan_id}:edit", status_code=202, responses=declared(409))
    def edit_plan(services: AppServices, plan_id: Id, body: EditPlan) -> GoalBody:
        """Have a proposed plan planned once more with something pinned, with as few changes as pays. Follow the goal's
        `alternatives`: the edited plan is open to decision beside the plan, which stays as it is."""
        return GoalBody.of(services.alternatives.edit(plan_id, body.edits, actor=ACTOR))

    @router.post("/plans/{plan_id}:reject", status_code=202, responses=declared(409))
    def reject_plan(services: AppServices, plan_id: Id, body: Decision | None = None) -> Decided:
        """Reject the plan; with the last open plan its goal is withdrawn."""
        row = services.plans.reject(plan_id, actor=ACTOR, comment=body.comment if body else "")
        return Decided(**plan_body(row).model_dump())

    return router
