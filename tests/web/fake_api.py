"""A small stand-in for the service: its public API with canned answers, enough for console and view."""

import asyncio
import json
import threading
import time
from base64 import b64decode
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import uvicorn
from fastapi import Body, Depends, FastAPI, HTTPException, Request, Response
from fastapi.responses import JSONResponse, StreamingResponse
from fastapi.staticfiles import StaticFiles

from app.api.auth import SECURITY_HEADERS
from app.api.page_views import views_router
from app.api.viewer_proxy import view_router, viewer_router
from app.domain.world_model.layout import layout_of
from tests.ports import free_port
from tests.web.fake_service import IMAGE, WORLD, FakeService

TOKEN = "secret"
STATIC = Path(__file__).parents[2] / "web" / "static"
CONTENT_POLICY = SECURITY_HEADERS["content-security-policy"]


def require_token(request: Request) -> None:
    told = request.headers.get("authorization", "").removeprefix("Bearer ") or request.cookies.get("macta")
    if told != TOKEN:
        raise HTTPException(401)


def items(values: Any) -> dict[str, Any]:
    return {"items": list(values), "next": None}


def page(values: Any, limit: int) -> dict[str, Any]:
    """The newest, as the service does."""
    newest = sorted(values, key=lambda value: value["created_at"], reverse=True)
    return {"items": newest[:limit], "next": "more" if len(newest) > limit else None}


def known(records: dict[str, dict[str, Any]], name: str) -> dict[str, Any]:
    if name not in records:
        raise HTTPException(404)
    return records[name]


def add_changes(app: FastAPI, service: FakeService) -> None:
    @app.get("/v1/worlds/{world}/numbers", dependencies=[Depends(require_token)])
    def numbers(world: str) -> Any:
        service.asked_numbers += 1
        return items(service.numbers) | {"version": service.numbers_version}

    v1 = [Depends(require_token)]
    add_holds(app, service)

    @app.get("/v1/worlds/{world}/changes", dependencies=v1)
    def changes(world: str) -> Any:
        return items(service.changes)

    @app.post("/v1/worlds/{world}/changes", dependencies=v1)
    def change(world: str, body: dict[str, Any], request: Request) -> Any:
        assert request.headers["if-match"] == f'"{service.edition}"'
        return note_change(body)

    def note_change(body: dict[str, Any]) -> dict[str, Any]:
        service.edition += 1
        made = {"actor": "somebody", "undone_by": None, "delivery": "taken_up", "detail": "", **body}
        service.changes.insert(0, made | {"edition": service.edition})
        return service.changes[0]

    @app.post("/v1/worlds/{world}/changes:check", dependencies=v1)
    def check_change(world: str, body: dict[str, Any]) -> Any:
        taken = {fact["args"][1] for fact in service.facts}
        for edit in body["edits"]:
            if edit["edit"] == "add_sample" and edit["sample"]["at"] in taken:
                taken_by = {"title": "Place occupied", "detail": f"{edit['sample']['at']} is taken"}
                return JSONResponse(taken_by, 409, media_type="application/problem+json")
        return {}

    @app.get("/v1/worlds/{world}/factsheets", dependencies=v1)
    def factsheets(world: str) -> Any:
        return items(service.factsheets)

    @app.post("/v1/worlds/{world}/robots/{name}:{verb}", dependencies=v1)
    def decide(
        world: str, name: str, verb: str, body: Annotated[dict[str, str] | None, Body()] = None
    ) -> Any:
        (sheet,) = (one for one in service.factsheets if one["robot"] == name)
        if name == "gate_1":
            unfit = {"title": "World does not fit", "detail": "the name gate_1 is in use"}
            return JSONResponse(unfit, 422, media_type="application/problem+json")
        sheet |= {"state": "in_force"} if verb == "admit" else {"state": "refused", **(body or {})}
        return sheet

    @app.post("/v1/worlds/{world}/changes/{edition}:undo", dependencies=v1)
    def undo_change(world: str, edition: int) -> Any:
        (undone,) = (one for one in service.changes if one["edition"] == edition)
        made = note_change({"edits": undone["edits"], "reason": f"undoes edition {edition}"})
        undone["undone_by"] = made["edition"]
        return made


def add_holds(app: FastAPI, service: FakeService) -> None:
    """Places that are kept empty."""
    v1 = [Depends(require_token)]

    @app.get("/v1/worlds/{world}/holds", dependencies=v1)
    def holds(world: str) -> Any:
        return items(service.holds)

    @app.post("/v1/worlds/{world}/holds/{hold_id}:end", dependencies=v1)
    def end_hold(world: str, hold_id: str) -> Any:
        (ended,) = (one for one in service.holds if one["id"] == hold_id)
        service.holds.remove(ended)
        service.publish("hold.ended", hold_id)
        return ended


def add_goals(app: FastAPI, service: FakeService) -> None:
    """Goals and plans."""
    v1 = [Depends(require_token)]

    @app.get("/v1/goals", dependencies=v1)
    def goals(limit: int = 100) -> Any:
        return page(service.goals.values(), limit)

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

    @app.post("/v1/goals:check", dependencies=v1)
    def check_goal(body: dict[str, Any]) -> Any:
        return service.check(body["text"])

    @app.get("/v1/goals/{goal_id}", dependencies=v1)
    def goal(goal_id: str) -> Any:
        return known(service.goals, goal_id)

    @app.post("/v1/goals/{goal_id}:alternatives", dependencies=v1)
    def seek_alternatives(goal_id: str) -> Any:
        return JSONResponse(service.find_alternatives(goal_id), 202)

    @app.post("/v1/plans/{plan_id}:edit", dependencies=v1)
    def edit_plan(plan_id: str, body: dict[str, Any]) -> Any:
        return JSONResponse(service.edit(plan_id, body["edits"]), 202)

    @app.post("/v1/goals/{goal_id}:{verb}", dependencies=v1)
    def end_planning(goal_id: str, verb: str) -> Any:
        return JSONResponse(service.stop(goal_id, verb), 202)

    @app.get("/v1/goals/{goal_id}/plans", dependencies=v1)
    def compare(goal_id: str) -> Any:
        return items(plan for plan in service.plans.values() if plan["goal_id"] == goal_id)

    @app.get("/v1/plans/{plan_id}", dependencies=v1)
    def plan(plan_id: str) -> Any:
        return known(service.plans, plan_id)

    @app.get("/v1/plans/{plan_id}/actions/{action_id}/explanation", dependencies=v1)
    def action_explanation(plan_id: str, action_id: str) -> Any:
        return service.explanation["actions"][0] | {"action": action_id}

    @app.get("/v1/plans/{plan_id}/explanation", dependencies=v1)
    def explanation(plan_id: str) -> Any:
        return service.explanation

    @app.post("/v1/plans/{plan_id}:{verb}", dependencies=v1)
    def decide(plan_id: str, verb: str, body: dict[str, Any]) -> Any:
        service.decisions.append((plan_id, verb, body["comment"]))
        if body.get("delegate"):
            service.decisions.append((plan_id, "delegate", ""))
        if verb == "approve":
            return JSONResponse(service.approve(plan_id), 202)
        service.plans[plan_id] |= {"state": "rejected", "comment": body["comment"]}
        service.publish("plan.rejected", plan_id)
        return JSONResponse(service.plans[plan_id], 202)


def add_missions(app: FastAPI, service: FakeService) -> None:
    """Missions and orders on them."""
    v1 = [Depends(require_token)]

    @app.get("/v1/missions", dependencies=v1)
    def missions(limit: int = 100) -> Any:
        return page(service.missions.values(), limit)

    @app.get("/v1/missions/{mission_id}", dependencies=v1)
    def mission(mission_id: str) -> Any:
        return service.missions[mission_id]

    @app.get("/v1/missions/{mission_id}/conversation", dependencies=v1)
    def conversation(mission_id: str) -> Any:
        return items(service.said)

    @app.get("/v1/missions/{mission_id}/results", dependencies=v1)
    def results(mission_id: str) -> Any:
        return {"items": [one for one in service.results if one["mission_id"] == mission_id], "next": None}

    @app.get("/v1/missions/{mission_id}/results/{result_id}", dependencies=v1)
    def result(mission_id: str, result_id: str) -> Response:
        return Response(b64decode(IMAGE.partition(",")[2]), media_type="image/png")

    @app.get("/v1/missions/{mission_id}/replay", dependencies=v1)
    def replay(mission_id: str) -> Any:
        return service.replay(mission_id)

    @app.post("/v1/missions/{mission_id}:preview", dependencies=v1)
    def preview_mission(mission_id: str, body: Annotated[dict[str, Any], Body()]) -> Any:
        if service.refusal:
            problem = {"title": "Conflict", "status": 409, "detail": service.refusal}
            return JSONResponse(problem, 409, media_type="application/problem+json")
        if body["edits"]:
            problem = {"title": "Invalid", "status": 422, "detail": "the plan has no such action"}
            return JSONResponse(problem, 422, media_type="application/problem+json")
        achieved = [
            {"goal": {"predicate": "in", "args": [f"sample_{n}", "bay_1"]}, "in_s": 10.0 * n} for n in (1, 2)
        ]
        return {
            "reason": "",
            "ends_in_s": 20.0,
            "expected_in_s": 31.0,
            "changes": ["3 of 5 actions kept"],
            "achieved": achieved[: 1 + len(body.get("goals", ()))],
            "unkept": "",
        }

    @app.post("/v1/missions/{mission_id}:{verb}", dependencies=v1)
    def steer(mission_id: str, verb: str, body: Annotated[dict[str, Any] | None, Body()] = None) -> Any:
        if service.refusal:
            problem = {"title": "Conflict", "status": 409, "detail": service.refusal}
            return JSONResponse(problem, 409, media_type="application/problem+json")
        if verb == "replan":
            asked = body or {}
            service.asked = [*asked.get("edits", ()), *({"joins": one} for one in asked.get("goals", ()))]
        states = {"pause": "paused", "resume": "running", "cancel": "cancelled", "replan": "recovering"}
        service.missions[mission_id]["state"] = states[verb]
        service.publish(f"mission.{states[verb]}", mission_id)
        return JSONResponse(service.missions[mission_id], 202)

    @app.put("/v1/missions/{mission_id}/recovery", dependencies=v1)
    def set_recovery(mission_id: str, body: dict[str, Any]) -> Any:
        service.missions[mission_id]["recovery"] |= {"policy": body["policy"]}
        service.publish("mission.recovery_set", mission_id)
        return service.missions[mission_id]


def add_breakpoints(app: FastAPI, service: FakeService) -> None:
    v1 = [Depends(require_token)]

    @app.get("/v1/robots/{name}/breakpoints", dependencies=v1)
    def breakpoints(name: str) -> Any:
        return service.breakpoints

    @app.put("/v1/robots/{name}/breakpoints", dependencies=v1)
    def set_breakpoints(name: str, body: Annotated[dict[str, Any], Body()]) -> Any:
        service.breakpoints |= {"rules": body["rules"]}
        return service.breakpoints

    @app.post("/v1/robots/{name}/breakpoints:{verb}", dependencies=v1)
    def go_on(name: str, verb: str) -> Any:
        service.decisions.append((verb, name, ""))
        halts = [one | {"firings": []} for one in service.breakpoints["halts"]] if verb == "step" else []
        service.breakpoints |= {"halts": halts}
        return service.breakpoints


def add_robots(app: FastAPI, service: FakeService) -> None:
    v1 = [Depends(require_token)]

    @app.post("/v1/robots/{name}:teleoperate", dependencies=v1)
    def teleoperate(name: str, body: dict[str, Any]) -> Any:
        if name in service.undrivable:
            problem = {"title": "Conflict", "status": 409, "detail": service.undrivable[name]}
            return JSONResponse(problem, 409, media_type="application/problem+json")
        if (name, body["session"]) in service.released:
            problem = {"title": "Conflict", "status": 409, "detail": f"{name} is released"}
            return JSONResponse(problem, 409, media_type="application/problem+json")
        service.set_points.append((name, body))
        told = {"robot": name, "driver": body["session"], "driving": len(service.set_points) > 1}
        limits = {"valid_s": 0.5, "most_m_s": 0.3, "most_rad_s": 1.0}
        return JSONResponse(told | limits | {"last_heard_s": service.last_heard_s}, 202)

    @app.post("/v1/robots/{name}:end_teleoperation", dependencies=v1)
    def end_teleoperation(name: str, body: dict[str, Any]) -> Any:
        service.released.append((name, body["session"]))
        return JSONResponse({}, 202)

    @app.get("/v1/robots/{name}/tuning", dependencies=v1)
    def tuning(name: str) -> Any:
        return service.tuning

    @app.put("/v1/robots/{name}/tuning", dependencies=v1)
    def tune(name: str, body: dict[str, Any], request: Request) -> Any:
        if request.headers["if-match"] != f'"{service.tuning["version"]}"':
            problem = {"title": "Tuning changed", "status": 412, "detail": "the tuning of yard_1 has changed"}
            return JSONResponse(problem, 412, media_type="application/problem+json")
        service.tune(body["tuning"])
        return service.tuning

    @app.get("/v1/robots/{name}/rules", dependencies=v1)
    def rules(name: str) -> Any:
        return service.rules

    @app.put("/v1/robots/{name}/rules", dependencies=v1)
    def send_rules(name: str, body: dict[str, Any], request: Request) -> Any:
        if request.headers["if-match"] != f'"{service.rules["version"]}"':
            problem = {"title": "Rules changed", "status": 412, "detail": "the rules of yard_1 have changed"}
            return JSONResponse(problem, 412, media_type="application/problem+json")
        if any("COMIT" in text for text in body["files"].values()):
            problem = {"title": "Unfit rules", "status": 422, "detail": "guard:2:21: expected COMMIT"}
            return JSONResponse(problem, 422, media_type="application/problem+json")
        service.rule(body["files"], body["comment"])
        return service.rules

    @app.get("/v1/robots/{name}/sensors", dependencies=v1)
    def sensors(name: str) -> Any:
        return {"items": [service.sensor]}

    @app.put("/v1/robots/{name}/sensors/{sensor}", dependencies=v1)
    def set_source(name: str, sensor: str, body: dict[str, Any]) -> Any:
        service.sensor = service.sensor | {"source": body["source"]}
        return service.sensor

    @app.get("/v1/robots/{name}/embodiment", dependencies=v1)
    def embodiment(name: str) -> Any:
        return service.embodiment

    @app.post("/v1/robots/{name}:embody", dependencies=v1, status_code=202)
    def embody(name: str, body: dict[str, Any]) -> Any:
        return service.embody(name, body["body"])

    @app.get("/v1/robots/{name}/role", dependencies=v1)
    def role(name: str) -> Any:
        return service.role

    @app.put("/v1/robots/{name}/role", dependencies=v1)
    def give_role(name: str, body: dict[str, Any], request: Request) -> Any:
        if request.headers["if-match"] != f'"{service.role["version"]}"':
            problem = {"title": "Role changed", "status": 412, "detail": "the role of yard_1 has changed"}
            return JSONResponse(problem, 412, media_type="application/problem+json")
        service.play(**body)
        return service.role

    @app.delete("/v1/robots/{name}/role", dependencies=v1)
    def end_role(name: str) -> Any:
        service.play(None)
        return service.role

    @app.get("/v1/robots/{name}/conversations", dependencies=v1)
    def conversations(name: str) -> Any:
        return items(service.conversations)

    @app.get("/v1/robots/{name}/dialogues", dependencies=v1)
    def dialogues(name: str) -> Any:
        return {"items": [one for one in service.dialogues if one["robot"] == name], "next": None}

    @app.post("/v1/robots/{name}/dialogues", dependencies=v1)
    def say(name: str, body: dict[str, Any]) -> Any:
        if body["text"].startswith("fase"):
            problem = {"title": "Words not understood", "status": 422, "detail": "did you mean face?"}
            return JSONResponse(problem, 422)
        return service.take_word(name, body)

    @app.post("/v1/robots/{name}/dialogues/{dialogue}:approve", dependencies=v1)
    def approve_words(name: str, dialogue: str) -> Any:
        return service.decide(name, dialogue, "agreed")

    @app.post("/v1/robots/{name}/dialogues/{dialogue}:withdraw", dependencies=v1)
    def withdraw_words(name: str, dialogue: str) -> Any:
        return service.decide(name, dialogue, "withdrawn")

    @app.get("/v1/robots/{name}/mind", dependencies=v1)
    def mind(name: str) -> Any:
        return service.mind

    @app.get("/v1/robots/{name}/trace", dependencies=v1)
    def trace(name: str, seconds: float) -> Any:
        return service.trace

    @app.post("/v1/robots/{name}:{verb}", dependencies=v1)
    def declare(name: str, verb: str, body: Annotated[dict[str, str] | None, Body()] = None) -> Any:
        service.declare(name, verb, **(body or {}))
        return JSONResponse({}, 202)

    @app.get("/v1/robots", dependencies=v1)
    def robots() -> Any:
        return items(service.robots())

    @app.get("/v1/peripherals", dependencies=v1)
    def peripherals() -> Any:
        return items(service.peripherals())


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

    def world_line(name: str) -> dict[str, Any]:
        return {
            "id": name,
            "name": name,
            "title": service.world.title if name == WORLD else name,
            "time_s": service.time_s,
            "version": service.version,
            "edition": service.edition,
            "status": "starting" if name in service.starting else "running",
            "status_detail": "",
            "numbers_version": service.numbers_version,
        }

    @app.get("/v1/worlds", dependencies=v1)
    def worlds() -> Any:
        return items(map(world_line, service.worlds))

    @app.get("/v1/worlds/{world}", dependencies=v1)
    def world(world: str) -> Any:
        return world_line(world) | {"layout": layout_of(service.world)}

    @app.get("/v1/worlds/{world}/facts", dependencies=v1)
    def facts(world: str) -> Any:
        return items([fact | {"source": "operator", "at_s": 0.0} for fact in service.facts]) | {
            "version": service.version,
            "edition": service.edition,
        }

    @app.get("/v1/worlds/{world}/unknown", dependencies=v1)
    def unknown(world: str) -> Any:
        return items(service.unknown)

    add_changes(app, service)
    add_goals(app, service)
    add_missions(app, service)
    add_robots(app, service)
    add_breakpoints(app, service)

    app.include_router(view_router(lambda: service.view), dependencies=v1)
    app.include_router(
        viewer_router(lambda: service.view, lambda asking: asking.cookies.get("macta") == TOKEN, max_open=8)
    )
    app.include_router(views_router(service.views, max_open=8))

    async def event_lines() -> AsyncIterator[str]:
        sent = 0
        yield ": hello\n\n"
        while not service.stopping:
            fresh = service.events[sent:]  # others may be published while these are sent
            sent += len(fresh)
            for event in fresh:
                yield f"id: {event['seq']}\ndata: {json.dumps(event)}\n\n"
            await asyncio.sleep(0.02)

    @app.get("/v1/events", dependencies=v1)
    def events() -> StreamingResponse:
        return StreamingResponse(event_lines(), media_type="text/event-stream")

    async def telemetry_lines(world: str) -> AsyncIterator[str]:
        while not service.stopping:
            robots = service.telemetry if world == WORLD else {}
            told = {"world": world, "time_s": service.time_s, "robots": robots}
            yield f"data: {json.dumps(told)}\n\n"
            await asyncio.sleep(0.1)

    @app.get("/v1/telemetry", dependencies=v1)
    def telemetry(world: str) -> StreamingResponse:
        return StreamingResponse(telemetry_lines(world), media_type="text/event-stream")

    return app


def add_console(app: FastAPI) -> None:
    """The console's files, last: they answer for every path that is nobody else's."""
    app.mount("/", StaticFiles(directory=STATIC, html=True))


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
