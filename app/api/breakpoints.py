"""Routes of breakpoints on the rules of simulated robots."""

from typing import Annotated

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from app.agents.breakpoints import RobotBreakpoints
from app.api.bodies import Request
from app.api.goals import ACTOR
from app.api.parameters import Id
from app.api.problems import declared
from app.api.services import AppServices
from app.api.worlds import TAGS
from robots.wire import ToldAgent

Rule = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*:[1-9][0-9]*$", max_length=80)]
"""The file of a rule and the line at which it begins."""


class SetBreakpoints(Request):
    rules: list[Rule] = Field(
        max_length=64,
        description="the file of each rule and the line at which it begins",
        examples=[["guard:2"]],
    )


class FiringBody(BaseModel):
    """A rule that has fired, and whose commitment is held back."""

    model_config = ConfigDict(from_attributes=True)

    agent: str
    rule: str = Field(description="its file and line")
    does: str = Field(description="the packet, plan or action that it commits to; empty: beliefs only")
    bindings: dict[str, str]


class HaltBody(BaseModel):
    """Where a robot's mind stands."""

    model_config = ConfigDict(from_attributes=True)

    robot: str
    at_s: float = Field(description="world's clock")
    firings: list[FiringBody] = Field(description="empty after a step in which no breakpoint was met")
    agents: list[ToldAgent]


class BreakpointsBody(BaseModel):
    """The breakpoints of a robot's rules, and where its world stands."""

    robot: str
    world: str
    refusal: str = Field(description="why its world cannot stand; empty: it can")
    rules: list[str] = Field(description="the robot's breakpoints")
    of_others: int = Field(description="number of breakpoints of other robots of the world")
    halts: list[HaltBody] = Field(description="where the world stands, by robot; empty: it runs")
    left_s: float | None = Field(
        description="wall-clock seconds until the world goes on by itself, without breakpoints; null: it runs"
    )
    ended: str = Field(description="why it has gone on by itself; empty: it has not")


def breakpoints_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/robots/{name}/breakpoints", responses=declared(503))
    def get_breakpoints(services: AppServices, name: Id) -> BreakpointsBody:
        """The breakpoints of the robot's rules, and where its world stands."""
        return _body(services.breakpoints.get(name))

    @router.put("/robots/{name}/breakpoints", responses=declared(409, 503))
    def set_breakpoints(services: AppServices, name: Id, body: SetBreakpoints) -> BreakpointsBody:
        """Have the whole simulated world stand where one of these rules of the robot fires; replaces earlier ones.

        It stands before what the rule commits to takes effect, for 600 s of wall-clock time at most. A world in which
        no breakpoint is left goes on. 409 for robots with software of their own, and worlds that a fleet drives.
        """
        return _body(services.breakpoints.put(name, body.rules, actor=ACTOR))

    @router.post("/robots/{name}/breakpoints:step", responses=declared(409, 503))
    def step(services: AppServices, name: Id) -> BreakpointsBody:
        """Let the robot's world, which stands at a breakpoint, make one control cycle: each robot deliberates once."""
        return _body(services.breakpoints.go_on(name, one_cycle=True))

    @router.post("/robots/{name}/breakpoints:continue", responses=declared(409, 503))
    def go_on(services: AppServices, name: Id) -> BreakpointsBody:
        """Let the robot's world, which stands at a breakpoint, go on until the next one is met."""
        return _body(services.breakpoints.go_on(name, one_cycle=False))

    return router


def _body(known: RobotBreakpoints) -> BreakpointsBody:
    state = known.debugging
    mine = state.rules.get(known.robot, frozenset())
    return BreakpointsBody(
        robot=known.robot,
        world=known.world,
        refusal=known.refusal,
        rules=sorted(mine),
        of_others=sum(map(len, state.rules.values())) - len(mine),
        halts=[HaltBody.model_validate(one) for one in state.halts],
        left_s=state.left_s,
        ended=state.ended,
    )
