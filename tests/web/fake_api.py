"""A small stand-in for the service: its public API with canned answers, enough for console and view."""

import asyncio
import json
import socket
import threading
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import Depends, FastAPI, HTTPException, Request, Response
from fastapi.responses import JSONResponse, StreamingResponse
from fastapi.staticfiles import StaticFiles

from app.world_model.layout import layout_of
from tests.web.fake_service import WORLD, FakeService

TOKEN = "secret"
STATIC = Path(__file__).parents[2] / "web" / "static"
CONTENT_POLICY = "default-src 'self'; frame-ancestors 'self'"


def require_token(request: Request) -> None:
    told = request.headers.get("authorization", "").removeprefix("Bearer ") or request.cookies.get("macta")
    if told != TOKEN:
        raise HTTPException(401)


def items(values: Any) -> dict[str, Any]:
    return {"items": list(values), "next": None}


def create_app(service: FakeService) -> FastAPI:
    app = FastAPI()
    v1 = [Depends(require_token)]

    @app.middleware("http")
    async def policy(request: Request, call_next: Any) -> Response:
        answer: Response = await call_next(request)
        answer.headers.setdefault("content-security-policy", CONTENT_POLICY)
        if request.query_params.get("token") == TOKEN:
            answer.set_cookie("macta", TOKEN, httponly=True, samesite="strict")
        return answer

    def world_line() -> dict[str, Any]:
        title = service.world.title
        return {
            "id": WORLD,
            "name": WORLD,
            "title": title,
            "time_s": service.time_s,
            "version": service.version,
        }

    @app.get("/v1/worlds", dependencies=v1)
    def worlds() -> Any:
        return items([world_line()])

    @app.get("/v1/worlds/{world}", dependencies=v1)
    def world(world: str) -> Any:
        return world_line() | {"layout": layout_of(service.world)}

    @app.get("/v1/worlds/{world}/facts", dependencies=v1)
    def facts(world: str) -> Any:
        return items([fact | {"source": "operator", "at_s": 0.0} for fact in service.facts]) | {
            "version": service.version
        }

    @app.get("/v1/goals", dependencies=v1)
    def goals() -> Any:
        return items(service.goals.values())

    @app.post("/v1/goals", dependencies=v1)
    def state_goal(body: dict[str, Any]) -> Any:
        if "sample_9" in body["text"]:
            problem = {
                "type": "unknown-sample",
                "title": "Unknown sample",
                "status": 422,
                "detail": "There is no sample_9 in sample_store",
                "choices": ["sample_1", "sample_2"],
            }
            return JSONResponse(problem, 422, media_type="application/problem+json")
        service.asked.append(body)
        return JSONResponse(service.propose(body["text"]), 202)

    @app.get("/v1/goals/{goal_id}", dependencies=v1)
    def goal(goal_id: str) -> Any:
        return service.goals[goal_id]

    @app.post("/v1/goals/{goal_id}:alternatives", dependencies=v1)
    def seek_alternatives(goal_id: str) -> Any:
        return JSONResponse(service.find_alternatives(goal_id), 202)

    @app.post("/v1/goals/{goal_id}:{verb}", dependencies=v1)
    def end_planning(goal_id: str, verb: str) -> Any:
        return JSONResponse(service.stop(goal_id, verb), 202)

    @app.get("/v1/goals/{goal_id}/plans", dependencies=v1)
    def compare(goal_id: str) -> Any:
        return items(plan for plan in service.plans.values() if plan["goal_id"] == goal_id)

    @app.get("/v1/plans/{plan_id}", dependencies=v1)
    def plan(plan_id: str) -> Any:
        return service.plans[plan_id]

    @app.get("/v1/plans/{plan_id}/explanation", dependencies=v1)
    def explanation(plan_id: str) -> Any:
        return service.explanation

    @app.post("/v1/plans/{plan_id}:{verb}", dependencies=v1)
    def decide(plan_id: str, verb: str, body: dict[str, Any]) -> Any:
        service.decisions.append((plan_id, verb, body["comment"]))
        if verb == "approve":
            return JSONResponse(service.approve(plan_id), 202)
        service.plans[plan_id] |= {"state": "rejected", "comment": body["comment"]}
        service.publish("plan.rejected", plan_id)
        return JSONResponse(service.plans[plan_id], 202)

    @app.get("/v1/missions", dependencies=v1)
    def missions() -> Any:
        return items(service.missions.values())

    @app.get("/v1/missions/{mission_id}", dependencies=v1)
    def mission(mission_id: str) -> Any:
        return service.missions[mission_id]

    @app.post("/v1/missions/{mission_id}:{verb}", dependencies=v1)
    def steer(mission_id: str, verb: str) -> Any:
        states = {"pause": "paused", "resume": "running", "cancel": "cancelled"}
        service.missions[mission_id]["state"] = states[verb]
        service.publish(f"mission.{states[verb]}", mission_id)
        return JSONResponse(service.missions[mission_id], 202)

    @app.get("/v1/robots", dependencies=v1)
    def robots() -> Any:
        return items(service.robots())

    async def event_lines() -> AsyncIterator[str]:
        sent = 0
        yield ": hello\n\n"
        while not service.stopping:
            for event in service.events[sent:]:
                yield f"id: {event['seq']}\ndata: {json.dumps(event)}\n\n"
            sent = len(service.events)
            await asyncio.sleep(0.02)

    @app.get("/v1/events", dependencies=v1)
    def events() -> StreamingResponse:
        return StreamingResponse(event_lines(), media_type="text/event-stream")

    async def telemetry_lines() -> AsyncIterator[str]:
        while not service.stopping:
            told = {"world": WORLD, "time_s": service.time_s, "robots": service.telemetry}
            yield f"data: {json.dumps(told)}\n\n"
            await asyncio.sleep(0.1)

    @app.get("/v1/telemetry", dependencies=v1)
    def telemetry(world: str) -> StreamingResponse:
        return StreamingResponse(telemetry_lines(), media_type="text/event-stream")

    return app


def add_console(app: FastAPI) -> None:
    """The console's files, last: they answer for every path that is nobody else's."""
    app.mount("/", StaticFiles(directory=STATIC, html=True))


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def served(app: FastAPI, service: FakeService, port: int | None = None) -> Iterator[str]:
    """The app on a loopback port; yields its address."""
    port = port or free_port()
    service.stopping = False
    config = uvicorn.Config(app, host="127.0.0.1", port=port, log_level="error", timeout_graceful_shutdown=1)
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    try:
        yield f"http://127.0.0.1:{port}"
    finally:
        service.stopping = True
        server.should_exit = True
        thread.join(10)
