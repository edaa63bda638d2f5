"""Routes of missions and their scripts."""

from collections.abc import Callable, Mapping
from typing import Any

from fastapi import APIRouter, Response

from app.api.bodies import Decision, Page, Preview, Replan, SetRecovery
from app.api.goals import ACTOR
from app.api.mission_bodies import (
    MissionBody,
    MissionPreviewBody,
    ResultBody,
    ScriptBody,
    SpeechBody,
    mission_document,
)
from app.api.parameters import After, Id, Limit, NameFilter
from app.api.plan_json import JSON, json_of, json_page
from app.api.problems import declared
from app.api.services import AppServices
from app.domain.lifecycles.mission import MissionState
from app.missions.mission_service import Mission, MissionService
from app.store import ScriptRow
from robots.wire import BehaviourScript

IMAGE = {"schema": {"type": "string", "format": "binary"}}
CONTENT: Mapping[str, Any] = {
    "image/png": IMAGE,
    "image/jpeg": IMAGE,
    JSON: {"schema": {"$ref": "#/components/schemas/ResultBody"}},
}


def missions_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=["missions"])

    @router.get("/missions", response_model=Page[MissionBody])
    def list_missions(
        services: AppServices,
        world: NameFilter = None,
        state: MissionState | None = None,
        limit: Limit = 100,
        after: After = None,
    ) -> Response:
        found, token = services.missions.newest(world=world, state=state, limit=limit, after=after)
        return json_page((json_of(mission_document(*mission)) for mission in found), token)

    @router.get("/missions/{mission_id}")
    def get_mission(services: AppServices, mission_id: Id) -> MissionBody:
        return MissionBody.of(*services.missions.get(mission_id))

    @router.get("/missions/{mission_id}/scripts")
    def get_scripts(services: AppServices, mission_id: Id) -> Page[ScriptBody]:
        """The script of each robot."""
        _, scripts = services.missions.get(mission_id)
        return Page(items=[_script(row) for row in scripts])

    @router.get("/missions/{mission_id}/results")
    def get_results(services: AppServices, mission_id: Id) -> Page[ResultBody]:
        """The images and readings that its packets have brought, oldest first."""
        return Page(items=[ResultBody.model_validate(row) for row in services.missions.results(mission_id)])

    @router.get("/missions/{mission_id}/conversation")
    def get_conversation(services: AppServices, mission_id: Id) -> Page[SpeechBody]:
        """What its robots have said to each other, oldest first; known once they have reported it."""
        return Page(
            items=[SpeechBody.model_validate(one) for one in services.missions.conversation(mission_id)]
        )

    @router.get(
        "/missions/{mission_id}/results/{result_id}",
        response_class=Response,
        responses={200: {"description": "An image as it was taken, or a reading", "content": CONTENT}},
    )
    def get_result(services: AppServices, mission_id: Id, result_id: Id) -> Response:
        """The content of a result: an image, or a reading as JSON."""
        row = services.missions.result(mission_id, result_id)
        if row.content is None or row.media_type is None:
            return Response(ResultBody.model_validate(row).model_dump_json(), media_type=JSON)
        extension = row.media_type.partition("/")[2]
        headers = {
            "content-disposition": f'inline; filename="{row.id}.{extension}"',
            "cache-control": "private, max-age=86400, immutable",
        }
        return Response(row.content, media_type=row.media_type, headers=headers)

    @router.put("/missions/{mission_id}/recovery", responses=declared(409))
    def set_recovery(services: AppServices, mission_id: Id, body: SetRecovery) -> MissionBody:
        """Set how failures are recovered from now on: auto, ask or never."""
        return MissionBody.of(*services.missions.set_recovery(mission_id, body.policy, ACTOR))

    def order(verb: str, carry_out: Callable[[MissionService, str, str, str], Mission]) -> None:
        @router.post(
            f"/missions/{{mission_id}}:{verb}",
            status_code=202,
            operation_id=f"{verb}_mission",
            responses=declared(409),
        )
        def ordered(services: AppServices, mission_id: Id, body: Decision | None = None) -> MissionBody:
            comment = body.comment if body else ""
            return MissionBody.of(*carry_out(services.missions, mission_id, ACTOR, comment))

    @router.post("/missions/{mission_id}:replan", status_code=202, responses=declared(409))
    def replan_mission(services: AppServices, mission_id: Id, body: Replan | None = None) -> MissionBody:
        """Have what is not done yet planned again with the robots, places and facts of now, with something pinned, or
        with goals that wait. The mission's robots stop for it. The new plan is approved like a repair, by the mission's
        recovery policy; if it is rejected the mission goes on with the rest of its present plan."""
        body = body or Replan()
        return MissionBody.of(
            *services.replanning.replan(mission_id, body.edits, ACTOR, body.comment, goals=body.goals)
        )

    @router.post("/missions/{mission_id}:preview", responses=declared(409, 429, 503))
    def preview_mission(
        services: AppServices, mission_id: Id, body: Preview | None = None
    ) -> MissionPreviewBody:
        """What would come of `:replan` now: when each goal would be true, and what becomes of the present plan. It is
        planned, in up to 10 s, and nothing is changed: the robots go on meanwhile."""
        body = body or Preview()
        return MissionPreviewBody.model_validate(
            services.replanning.preview(mission_id, body.edits, goals=body.goals)
        )

    order("cancel", MissionService.cancel)
    order("pause", MissionService.pause)
    order("resume", MissionService.resume)
    return router


def _script(row: ScriptRow) -> ScriptBody:
    script = BehaviourScript.model_validate(row.body)
    return ScriptBody(robot=row.robot, delivery=row.delivery, state=row.state, script=script)
