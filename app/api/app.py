"""The FastAPI application: routes, streams, problems, the console's files and authentication."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from fastapi.responses import JSONResponse
from fastapi.staticfiles import StaticFiles
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES, GZipMiddleware
from starlette.routing import BaseRoute

from app.agents.running_world import WorldState
from app.api import problems
from app.api.auth import TokenCheck, TokenMiddleware
from app.api.bodies import GoalBody, plan_body
from app.api.breakpoints import breakpoints_router
from app.api.conversations import conversations_router
from app.api.dialogues import dialogues_router
from app.api.embodiments import embodiments_router
from app.api.event_schema import GOAL_STATE, MISSION_STATE, PLAN_STATE
from app.api.executors import executors_router
from app.api.factsheets import factsheets_router
from app.api.goals import goals_router, plans_router
from app.api.holds import holds_router
from app.api.input_gate import InputGate
from app.api.mission_bodies import MissionBody
from app.api.missions import missions_router
from app.api.openapi import Api
from app.api.packs import packs_router
from app.api.page_views import PageViews, views_router
from app.api.plan_bids import plan_bids_router
from app.api.recordings import MCAP, recordings_router
from app.api.robot_rules import robot_rules_router
from app.api.robot_sensors import robot_sensors_router
from app.api.robots import robots_router
from app.api.services import Services, provide
from app.api.streams import DepartureMiddleware, streams_router
from app.api.teleoperation import teleoperation_router
from app.api.viewer_proxy import view_router, viewer_router
from app.api.world_changes import world_changes_router
from app.api.world_set import world_set_router
from app.api.worlds import worlds_router
from app.workflows import PLANNING
from app.workflows.leases import Executor

MIN_COMPRESSED_BYTES = 2000
COMPRESSION_LEVEL = 4


@cache
def shared_routes() -> Sequence[BaseRoute]:
    """The routes that every application of the process has; they get its services with each request."""
    routers = [
        goals_router(),
        plans_router(),
        plan_bids_router(),
        missions_router(),
        worlds_router(),
        world_set_router(),
        holds_router(),
        world_changes_router(),
        factsheets_router(),
        robots_router(),
        robot_rules_router(),
        breakpoints_router(),
        conversations_router(),
        robot_sensors_router(),
        embodiments_router(),
        dialogues_router(),
        teleoperation_router(),
        executors_router(),
        packs_router(),
    ]
    return [route for router in routers for route in router.routes]


def build_api(service: Services, *, viewer: Callable[[], str | None], static: Path) -> FastAPI:
    check = TokenCheck(service.token)
    api = Api(
        title="Macta",
        description="Plans goals for teams of robots, has plans approved, and monitors their execution.",
        version="0.1.0",
        docs_url=None,
        redoc_url=None,
    )
    problems.install(api)
    provide(api, service)
    routers = [
        streams_router(
            events=service.events,
            board=service.board,
            clocks=service.clocks,
            stopping=service.stopping,
            snapshot=lambda: _snapshot(service),
            max_open=service.settings.open_streams,
        ),
        recordings_router(service.recordings, static),
        view_router(viewer),
        viewer_router(viewer, check.admits, max_open=service.settings.open_streams),
        views_router(PageViews(), max_open=service.settings.open_streams),
    ]
    # As they are: `include_router` would build each of these routes a second time, with the same settings.
    api.routes.extend(shared_routes())
    for router in routers:
        api.routes.extend(router.routes)
    _add_health(api, service)
    api.mount("/", StaticFiles(directory=static, html=True), name="console")
    api.add_middleware(DepartureMiddleware)
    # For operators on slow links. Recordings are compressed already; streams are sent without delay.
    api.add_middleware(
        GZipMiddleware,
        minimum_size=MIN_COMPRESSED_BYTES,
        compresslevel=COMPRESSION_LEVEL,
        exclude_content_types=(*DEFAULT_EXCLUDED_CONTENT_TYPES, MCAP),
    )
    api.add_middleware(InputGate)
    api.add_middleware(TokenMiddleware, check=check)
    return api


def _add_health(api: FastAPI, service: Services) -> None:
    # Async, not in a worker thread: all of those may be waiting for the database.
    @api.get("/healthz", tags=["health"])
    async def healthz() -> dict[str, str]:
        """The process is alive."""
        return {"status": "alive"}

    @api.get("/readyz", tags=["health"], responses=problems.declared(503))
    def readyz() -> JSONResponse:
        """The database answers, every world's robots can be reached, all processes run the same domain packs, and the
        planner has started.

        `world-differs`: a fleet drives another world file than the service has; `contract-differs`: one is of another
        major version of the contract; `broker-refuses`: the broker does not let the service in. Nothing can be sent.

        `compilation` is `compiled` once the planner and the worlds run at full speed. Before, it is `compiling`, or
        `waiting` while another process on the machine compiles them: problems of up to 8 goals are planned all the
        same, larger ones wait for it. It is `uncompiled` if they will not be compiled.

        `starting` names worlds that were added and do not run yet, `failed` those that cannot be built: the others do
        not wait for them. `waiting_for_fleet` names those that nobody drives yet. `invalid_messages` says, by world,
        how many messages of robots were dropped as invalid, and what was wrong with the last.
        """
        try:
            executors = [one for one in service.executors.executors() if one.alive]
        except Exception:
            return problems.problem(503, "not-ready", "the database does not answer")
        if (problem := _why_not_ready(service, executors)) is not None:
            return problem
        failed = service.world_set.those(WorldState.FAILED)
        plans = any(PLANNING.name in one.serves for one in executors)
        ready: dict[str, Any] = {"status": "ready", "compilation": service.compilation().value}
        if starting := service.world_set.those(WorldState.STARTING):
            ready["starting"] = starting
        if failed:
            ready["failed"] = failed
        if waiting := service.world_set.those(WorldState.WAITING_FOR_FLEET):
            ready["waiting_for_fleet"] = waiting
        if rejected := service.invalid_messages():
            ready["invalid_messages"] = {world: asdict(one) for world, one in rejected.items()}
        if not plans:
            # Goals are accepted, and planned once a planning process runs.
            return JSONResponse({**ready, "detail": "no process plans: start `macta worker`"})
        return JSONResponse(ready)


def _why_not_ready(service: Services, executors: Sequence[Executor]) -> JSONResponse | None:
    failed = service.world_set.those(WorldState.FAILED)
    broken = [
        world for world in sorted(service.clocks) if world not in failed and _is_unreachable(service, world)
    ]
    if broken:
        detail = f"no link to the robots of {', '.join(broken)}"
        return problems.problem(503, "world-unreachable", detail, worlds=broken)
    if faults := service.link_faults():
        code, detail = next(iter(faults.values()))
        return problems.problem(503, code, detail, worlds=list(faults))
    if doing := service.waits_for():
        return problems.problem(503, "starting", doing)
    if others := service.other_packs(executors):
        detail = f"give every process the same packs (--pack, MACTA_PACKS): {'; '.join(others)}"
        return problems.problem(503, "packs-differ", detail)
    return None


def _is_unreachable(service: Services, world: str) -> bool:
    return any(view.broken for view in service.board.views(world).values())


def _snapshot(service: Services) -> list[tuple[str, str, dict[str, Any]]]:
    """The newest hundred goals, open plans and missions, oldest first, for a client that does not resume."""
    goals, _ = service.goals.newest(limit=100)
    plans, _ = service.plans.newest(limit=100, state="proposed")
    missions, _ = service.missions.newest(limit=100)
    return [
        *((GOAL_STATE, g.id, GoalBody.of(g).model_dump(mode="json")) for g in reversed(goals)),
        *((PLAN_STATE, p.id, plan_body(p).model_dump(mode="json")) for p in reversed(plans)),
        *((MISSION_STATE, m[0].id, MissionBody.of(*m).model_dump(mode="json")) for m in reversed(missions)),
    ]
