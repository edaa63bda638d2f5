"""The bodies of requests and answers, beside the plan body."""

from typing import Any, Generic, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from app.database import GoalRow, MissionRow, PlanRow, ScriptRow
from app.plan_body import PlanBody
from robots.wire import BehaviourScript, SymbolicFact

Item = TypeVar("Item")


class Request(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class SubmitGoal(Request):
    """A goal as a sentence or structured; exactly one of the two."""

    world: str | None = Field(default=None, description="may be left out where only one world runs")
    text: str | None = Field(default=None, min_length=1, max_length=1000, examples=["move sample_1 to bay_7"])
    goal: list[SymbolicFact] | None = Field(default=None, min_length=1, max_length=100)
    priority: int = Field(default=0, ge=-100, le=100)
    deadline_s: float | None = Field(default=None, gt=0, description="seconds from now, world's clock")
    auto_approve: bool = False

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.text is None) == (self.goal is None):
            raise ValueError('give either "text" (a sentence) or "goal" (a list of facts)')
        return self


class Decision(Request):
    comment: str = Field(default="", max_length=2000)


class FactChange(SymbolicFact):
    """A fact an operator says is true, or not."""

    value: bool = True


class CorrectFacts(Request):
    facts: list[FactChange] = Field(min_length=1, max_length=1000)
    comment: str = Field(default="", max_length=2000)


class Page(BaseModel, Generic[Item]):
    items: list[Item]
    next: str | None = None


class GoalBody(BaseModel):
    id: str
    world: str
    text: str
    goal: list[SymbolicFact]
    state: str
    reason: str
    outcome: str | None
    priority: int
    deadline_s: float | None
    auto_approve: bool
    plan_id: str | None
    mission_id: str | None
    created_by: str
    created_at: str
    updated_at: str

    @classmethod
    def of(cls, row: GoalRow) -> Self:
        return cls.model_validate({name: getattr(row, name) for name in cls.model_fields})


def plan_body(row: PlanRow) -> PlanBody:
    """The stored plan body with the decision on it."""
    decision = {
        "state": row.state,
        "reason": row.reason,
        "created_at": row.created_at,
        "comment": row.comment,
        "decided_by": row.decided_by,
        "decided_at": row.decided_at,
    }
    return PlanBody.model_validate({**row.body, **decision})


class PacketProgress(BaseModel):
    id: str
    tag: str
    description: str
    state: str
    expected_start_s: float
    expected_duration_s: float
    started_at_s: float | None = None
    finished_at_s: float | None = None
    detail: str = ""


class ScriptProgress(BaseModel):
    robot: str
    script_id: str
    delivery: Literal["pending", "acknowledged", "refused", "withdrawn"]
    state: str | None
    detail: str
    heard_at_s: float | None
    packets: list[PacketProgress]

    @classmethod
    def of(cls, row: ScriptRow) -> Self:
        script = BehaviourScript.model_validate(row.body)
        packets = [
            PacketProgress(
                id=packet.id,
                tag=packet.tag,
                description=packet.description,
                expected_start_s=packet.expected_start_s,
                expected_duration_s=packet.expected_duration_s,
                **_reported(row.packets.get(packet.id, {})),
            )
            for packet in script.packets
        ]
        return cls(
            robot=row.robot,
            script_id=row.id,
            delivery=row.delivery,  # type: ignore[arg-type]
            state=row.state,
            detail=row.detail,
            heard_at_s=row.heard_at_s,
            packets=packets,
        )


def _reported(known: dict[str, Any]) -> dict[str, Any]:
    wanted = ("started_at_s", "finished_at_s", "detail")
    return {"state": known.get("state", "waiting"), **{k: known[k] for k in wanted if k in known}}


class MissionBody(BaseModel):
    id: str
    goal_id: str
    plan_id: str
    world: str
    state: str
    reason: str
    failure: str | None
    estimate_s: float
    original_estimate_s: float
    margin_s: float
    started_at_s: float | None
    deadline_s: float | None
    enquire_at_s: float | None
    ended_at_s: float | None
    created_at: str
    progress: list[ScriptProgress]

    @classmethod
    def of(cls, row: MissionRow, scripts: list[ScriptRow]) -> Self:
        plain = {name: getattr(row, name) for name in cls.model_fields if name != "progress"}
        return cls.model_validate({**plain, "progress": [ScriptProgress.of(script) for script in scripts]})


class ScriptBody(BaseModel):
    robot: str
    delivery: str
    state: str | None
    script: BehaviourScript


class PoseBody(BaseModel):
    x_m: float
    y_m: float
    heading_rad: float


class RobotBody(BaseModel):
    id: str
    name: str
    world: str
    connection: str
    last_heard_s: float | None = Field(description="seconds ago, wall clock")
    repertoire: list[str]
    reach: list[str]
    pose: PoseBody | None = None
    battery: float | None = None
    holding: str | None = None
    packet: str | None = None
    packet_state: str | None = None
    mission_id: str | None = None
    script_id: str | None = None


class WorldItem(BaseModel):
    id: str
    name: str
    title: str
    time_s: float
    version: int


class WorldBody(WorldItem):
    layout: dict[str, Any]


class FactBody(SymbolicFact):
    source: str
    at_s: float
    recorded_at: str


class FactsBody(Page[FactBody]):
    version: int
    dropped: list[SymbolicFact] = Field(
        default=[], description="after a correction: what was believed and cannot hold beside it"
    )
