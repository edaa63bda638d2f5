"""Routes of robots: their state, traces of their behaviour synthesis, the tuning of their packets."""

from typing import Any

from anyio import to_thread
from fastapi import APIRouter, Query, Response
from pydantic import BaseModel, ConfigDict, Field

from app.agents.robot_directory import RobotReport
from app.agents.tuning import TunedRobot
from app.api.bodies import (
    Decision,
    FactsheetBody,
    ImpersonationBody,
    LostBody,
    OutOfServiceBody,
    Page,
    PoseBody,
    Request,
    RobotBody,
    RobotDetailBody,
    UnaskedBody,
)
from app.api.etags import IfMatch, etag_of, version_of
from app.api.goals import ACTOR
from app.api.parameters import Id, NameFilter
from app.api.problems import declared
from app.api.services import AppServices, Services
from app.api.worlds import TAGS
from robots.wire import TRACED_S, MindReport, PacketTunings, TraceReport

EXAMPLE = {"NAVIGATE": {"translate/obstacle_avoid": {"stimulus.reach_m": 0.4}}}


class SetTuning(Request):
    """The parameters to override, by packet, pattern and parameter; the others keep the world file's values."""

    tuning: PacketTunings = Field(examples=[EXAMPLE])
    comment: str = Field(default="", max_length=2000)


class TakeOutOfService(Request):
    reason: str = Field(min_length=1, max_length=2000, examples=["its left wheel slips"])


class TakeGroupOutOfService(TakeOutOfService):
    robots: list[str] = Field(min_length=1, max_length=1000)


class BringGroupBack(Decision):
    robots: list[str] = Field(min_length=1, max_length=1000)


class TuningBody(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    robot: str
    world: str
    version: int
    tuning: PacketTunings = Field(description="what operators have overridden")
    set_out: PacketTunings = Field(description="what the world file overrides")
    packets: PacketTunings = Field(description="the resulting value of every parameter")
    delivery: str = Field(description="untouched, pending, acknowledged or refused by the robot")
    detail: str = Field(description="why the robot refused it")
    comment: str
    decided_by: str | None
    decided_at: str | None


def robots_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/robots", responses=declared(404))
    def list_robots(services: AppServices, world: NameFilter = None) -> Page[RobotBody]:
        return Page(items=[_robot(report) for report in services.robots.robots(world)])

    @router.get("/peripherals", responses=declared(404))
    def list_peripherals(services: AppServices, world: NameFilter = None) -> Page[RobotBody]:
        """Doors, hatches and lifts. Each is `/v1/robots/NAME`, too, and is taken out of service as robots are."""
        return Page(items=[_robot(report) for report in services.robots.peripherals(world)])

    @router.get("/robots/{name}")
    def get_robot(services: AppServices, name: Id) -> RobotDetailBody:
        report = services.robots.robot(name)
        row = services.factsheets.of_robot(report.view.world, name)
        return RobotDetailBody(
            **dict(_robot(report)),
            senses=list(report.senses),
            factsheet=None if row is None else FactsheetBody.model_validate(row),
            dialogue_id=services.dialogues.open_one(name),
        )

    @router.post("/robots/{name}:declare_lost", status_code=202)
    def declare_lost(services: AppServices, name: Id, body: Decision | None = None) -> RobotBody:
        """Declare the robot lost: its missions are recovered without it. It is ordered to stop when heard again.

        A robot that was silent is used again once it is heard and has reported the end of its script.
        """
        world = services.robots.robot(name).view.world
        services.lost_robots.declare_lost(world, name, actor=ACTOR, comment=body.comment if body else "")
        return _robot(services.robots.robot(name))

    @router.post("/robots/{name}:declare_found", status_code=202, responses=declared(409))
    def declare_found(services: AppServices, name: Id, body: Decision | None = None) -> RobotBody:
        """Use a lost robot again. 409 if it is not lost or has not reported the end of its script."""
        world = services.robots.robot(name).view.world
        services.lost_robots.declare_found(world, name, actor=ACTOR, comment=body.comment if body else "")
        return _robot(services.robots.robot(name))

    @router.post("/robots/{name}:take_out_of_service")
    def take_out_of_service(services: AppServices, name: Id, body: TakeOutOfService) -> RobotBody:
        """Have the robot end what it has begun and not recruit it: goals wait for it, plans with it are out of date."""
        services.out_of_service.take_out([_named(services, name)], actor=ACTOR, reason=body.reason)
        return _robot(services.robots.robot(name))

    @router.post("/robots/{name}:bring_back", responses=declared(409))
    def bring_back(services: AppServices, name: Id, body: Decision | None = None) -> RobotBody:
        """Recruit the robot again. 409 if it is not out of service."""
        services.out_of_service.bring_back(
            [_named(services, name)], actor=ACTOR, comment=body.comment if body else ""
        )
        return _robot(services.robots.robot(name))

    @router.post("/robots:take_out_of_service", responses=declared(404))
    def take_group_out_of_service(services: AppServices, body: TakeGroupOutOfService) -> Page[RobotBody]:
        """Take several robots out of service, all or none."""
        services.out_of_service.take_out(
            [_named(services, name) for name in body.robots], actor=ACTOR, reason=body.reason
        )
        return Page(items=[_robot(services.robots.robot(name)) for name in dict.fromkeys(body.robots)])

    @router.post("/robots:bring_back", responses=declared(404, 409))
    def bring_group_back(services: AppServices, body: BringGroupBack) -> Page[RobotBody]:
        """Recruit several robots again, all or none. 409 names one that is not out of service."""
        services.out_of_service.bring_back(
            [_named(services, name) for name in body.robots], actor=ACTOR, comment=body.comment
        )
        return Page(items=[_robot(services.robots.robot(name)) for name in dict.fromkeys(body.robots)])

    @router.get("/robots/{name}/trace", responses=declared(409, 429, 504))
    async def get_trace(
        services: AppServices, name: Id, seconds: float = Query(default=5.0, gt=0, le=TRACED_S)
    ) -> TraceReport:
        """The robot's behaviour synthesis in the last seconds, queried from the robot (504 if it does not answer).

        Times are the world's clock. A tick's (r, u) are in the order of its stretch's `patterns` and `dofs`.
        """

        def ask() -> TraceReport:
            return services.questions.trace(services.robots.robot(name).view.name, seconds)

        return await to_thread.run_sync(ask, limiter=services.waiting_for_robots)

    @router.get("/robots/{name}/mind", responses=declared(409, 429, 504))
    async def get_mind(services: AppServices, name: Id) -> MindReport:
        """What the robot's rules have made of it: beliefs, commitments, roles and open conversations.

        Queried from the robot (504 if it does not answer, 409 if its software does not know the question). A commitment
        is one firing of a rule. Times are the world's clock.
        """

        def ask() -> MindReport:
            return services.questions.mind(services.robots.robot(name).view.name)

        return await to_thread.run_sync(ask, limiter=services.waiting_for_robots)

    @router.get("/robots/{name}/tuning")
    def get_tuning(services: AppServices, name: Id, response: Response) -> TuningBody:
        """Every parameter of the robot's packets, with its overrides."""
        return _tuning(services.tunings.get(name), response)

    @router.put("/robots/{name}/tuning", responses=declared(412))
    def set_tuning(
        services: AppServices, name: Id, body: SetTuning, response: Response, if_match: IfMatch = None
    ) -> TuningBody:
        """Override parameters of the robot's packets from its next packet on; replaces the earlier overrides.

        With `If-Match`, only if they were not changed since (412). Delivery is repeated until the robot answers, and
        again when its world starts again.
        """
        tuned = services.tunings.put(
            name,
            body.tuning,
            actor=ACTOR,
            comment=body.comment,
            expected_version=version_of(if_match),
        )
        return _tuning(tuned, response)

    return router


def _named(services: Services, name: str) -> tuple[str, str]:
    """The robot with its world first."""
    return services.robots.robot(name).view.world, name


def _tuning(tuned: TunedRobot, response: Response) -> TuningBody:
    response.headers["etag"] = etag_of(tuned.version)
    return TuningBody.model_validate(tuned)


def _robot(report: RobotReport) -> RobotBody:
    said = report.view.telemetry
    live: dict[str, Any] = (
        {}
        if said is None
        else {
            "pose": PoseBody(x_m=said.x_m, y_m=said.y_m, heading_rad=said.heading_rad),
            "battery": said.battery,
            "holding": said.holding,
            "driven_by": said.driven_by,
            "packet": said.packet_tag,
            "packet_state": said.packet_state,
            "script_id": said.script_id,
        }
    )
    return RobotBody(
        id=report.view.name,
        name=report.view.name,
        world=report.view.world,
        kind=report.kind,
        state=report.state,
        connection=report.connection,
        world_stands=report.world_stands,
        last_heard_s=report.last_heard_s,
        heard_at_s=report.view.heard_s,
        silent=report.silent,
        next_contact_s=report.next_contact_s,
        repertoire=list(report.repertoire),
        reach=list(report.reach),
        mission_id=report.mission_id,
        role=report.role,
        body=report.body,
        lost=None if report.lost is None else LostBody.model_validate(report.lost),
        out_of_service=None
        if report.out_of_service is None
        else OutOfServiceBody.model_validate(report.out_of_service),
        impersonation=None
        if report.impersonation is None
        else ImpersonationBody.model_validate(report.impersonation),
        unasked=None if report.unasked is None else UnaskedBody.model_validate(report.unasked),
        **live,
    )
