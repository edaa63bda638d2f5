"""Missions as the API shows them: state and reason, recovery, each robot's progress."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Self

from pydantic import BaseModel, Field

from app.domain.lifecycles.mission import full_reason
from app.domain.lifecycles.recovery import RecoveryStep
from app.domain.lifecycles.script import unanswered_order
from app.domain.recovery_rules import Measure, Policy
from app.store import MissionRow, ScriptRow
from robots.wire import BehaviourScript, FailureCategory


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
    waits_for: list[str] = Field(
        default=[], description="actions, with their robots, for which it still needs clearance"
    )


PLANNED = ("id", "tag", "expected_start_s", "expected_duration_s")
"""What a packet's progress takes from the script."""


class ScriptProgress(BaseModel):
    robot: str
    script_id: str
    delivery: Literal["pending", "acknowledged", "refused", "withdrawn"]
    state: str | None
    order: str | None = Field(default=None, description="the order that the robot has not answered yet")
    lost: bool = Field(
        default=False, description="the robot was declared lost before it had ended the script"
    )
    detail: str
    heard_at_s: float | None
    packets: list[PacketProgress]

    @classmethod
    def of(cls, row: ScriptRow, doers: Mapping[str, Sequence[str]]) -> Self:
        """:param doers: the robots of each action of the mission."""
        packets = [
            PacketProgress(
                **{name: packet[name] for name in PLANNED},
                description=packet.get("description", ""),
                waits_for=[
                    f"{action} of {' and '.join(doers.get(action, ()))}"
                    for action in packet.get("after", ())
                    if action not in row.cleared
                ],
                **_reported(row.packets.get(packet["id"], {})),
            )
            for packet in row.body["packets"]  # not as a model: it was validated when it was recorded
        ]
        return cls(
            robot=row.robot,
            script_id=row.id,
            delivery=row.delivery,  # type: ignore[arg-type]
            state=row.state,
            order=order.verb.value if (order := unanswered_order(row)) else None,
            lost=row.abandoned,
            detail=row.detail,
            heard_at_s=row.heard_at_s,
            packets=packets,
        )


def _reported(known: dict[str, Any]) -> dict[str, Any]:
    wanted = ("started_at_s", "finished_at_s", "detail")
    return {"state": known.get("state", "waiting"), **{k: known[k] for k in wanted if k in known}}


class TroubleBody(BaseModel):
    robot: str
    category: FailureCategory
    detail: str
    tag: str = Field(description="the packet that it failed at; empty if that is not known")
    fit: bool = Field(description="the robot may be planned with again")
    waited: bool = Field(
        default=False,
        description="it timed out waiting for another robot, and did not fail itself",
    )
    answered: bool = Field(
        default=False,
        description="an operator has since corrected facts, declared the robot found or resumed the mission: it no "
        "longer counts against the robot",
    )


class AttemptBody(BaseModel):
    """One attempt at recovering a mission."""

    number: int
    at_s: float
    failure: FailureCategory
    reason: str
    troubles: list[TroubleBody]
    measure: Measure | None = Field(
        description="retry: the rest of the same plan; repair: another plan; replan: one without some robots"
    )
    without: list[str] = Field(description="robots, and packets of robots, excluded from planning")
    plan_id: str | None
    outcome: str = Field(
        description="planning, proposed, approved, rejected, overtaken, no plan, or taken up (resumed by an operator)"
    )
    detail: str


class RecoveryBody(BaseModel):
    """How the mission's failures are handled, and the attempts so far."""

    policy: Policy
    step: RecoveryStep | None = Field(
        description="planning, deciding: a repaired plan waits for approval, waiting: for other missions, "
        "stuck: no repair was found; correct the facts and resume, or cancel"
    )
    tries_left: int
    attempts: list[AttemptBody]


class MissionBody(BaseModel):
    id: str
    goal_id: str
    plan_id: str = Field(description="the plan that it carries out now")
    revision: int = Field(description="the number of that plan among the mission's")
    world: str
    state: str
    reason: str
    failure: str | None
    cancel_requested: bool = Field(
        default=False, description="it ends once every robot at work has answered that it stopped"
    )
    estimate_s: float
    original_estimate_s: float
    margin_s: float
    started_at_s: float | None
    revised_at_s: float | None = Field(
        default=None, description="when the plan that it carries out now began, if that is not its first"
    )
    deadline_s: float | None
    enquire_at_s: float | None
    ended_at_s: float | None
    created_at: str
    recovery: RecoveryBody
    progress: list[ScriptProgress] = Field(description="of the plan that it carries out now")
    earlier: list[ScriptProgress] = Field(
        default=[], description="the scripts of its earlier plans; each has ended or its robot is lost"
    )

    @classmethod
    def of(cls, row: MissionRow, scripts: list[ScriptRow]) -> Self:
        made = {"reason", "recovery", "progress", "earlier"}
        plain = {name: getattr(row, name) for name in cls.model_fields if name not in made}
        recovery = {
            "policy": row.recovery,
            "step": row.recovery_step,
            "tries_left": row.tries_left,
            "attempts": row.attempts,
        }
        now = [script for script in scripts if script.plan_id == row.plan_id]
        before = [script for script in scripts if script.plan_id != row.plan_id]
        return cls.model_validate(
            {
                **plain,
                "reason": full_reason(row),
                "recovery": recovery,
                "progress": _progress(now),
                "earlier": _progress(before),
            }
        )


def _progress(scripts: Sequence[ScriptRow]) -> list[ScriptProgress]:
    doers: dict[tuple[str, str], list[str]] = {}
    for script in scripts:
        for packet in script.body["packets"]:
            doers.setdefault((script.plan_id, packet["id"]), []).append(script.robot)
    return [
        ScriptProgress.of(
            script, {action: robots for (of, action), robots in doers.items() if of == script.plan_id}
        )
        for script in scripts
    ]


class ScriptBody(BaseModel):
    robot: str
    delivery: str
    state: str | None
    script: BehaviourScript
