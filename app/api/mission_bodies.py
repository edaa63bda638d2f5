"""Missions as the API shows them: state and reason, recovery, each robot's progress."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field

from app.domain.lifecycles.mission import full_reason
from app.domain.lifecycles.recovery import RecoveryStep
from app.domain.lifecycles.script import unanswered_order
from app.domain.mission_organiser.synchronisation import time_of
from app.domain.recovery_rules import Measure, Policy
from app.store import MissionRow, ScriptRow
from app.store.records import values_of
from robots.wire import BehaviourScript, FailureCategory, Performative, SymbolicFact


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
    delegated_to: str | None = Field(
        default=None, description="the robot that does it, or has done it, in this one's stead"
    )
    waits_for: list[str] = Field(
        default=[], description="actions, with their robots, for which it still needs clearance"
    )


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


def _script_document(row: ScriptRow, doers: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """A `ScriptProgress` as data for JSON.

    :param doers: the robots of each action of the mission.
    """
    return {
        "robot": row.robot,
        "script_id": row.id,
        "delivery": row.delivery,
        "state": row.state,
        "order": order.verb.value if (order := unanswered_order(row)) else None,
        "lost": row.abandoned,
        "detail": row.detail,
        "heard_at_s": row.heard_at_s,
        "packets": [
            _packet_document(packet, row.packets.get(packet["id"], {}), row.cleared, doers)
            for packet in row.body["packets"]
        ],
    }


def _packet_document(
    planned: Mapping[str, Any],
    reported: Mapping[str, Any],
    cleared: Collection[str],
    doers: Mapping[str, Sequence[str]],
) -> dict[str, Any]:
    """A `PacketProgress` as data for JSON."""
    return {
        "id": planned["id"],
        "tag": planned["tag"],
        "description": planned.get("description", ""),
        "state": reported.get("state", "waiting"),
        "expected_start_s": planned["expected_start_s"],
        "expected_duration_s": planned["expected_duration_s"],
        "started_at_s": reported.get("started_at_s"),
        "finished_at_s": reported.get("finished_at_s"),
        "detail": reported.get("detail", ""),
        "delegated_to": reported.get("delegated_to"),
        "waits_for": [
            _awaited(action, doers)
            for action in planned.get("after", ())
            if action not in cleared and action not in reported.get("cleared_by", ())
        ],
    }


def _awaited(action: str, doers: Mapping[str, Sequence[str]]) -> str:
    """What a packet is to be cleared for, in words: an action and its robots, or a time."""
    at_s = time_of(action)
    if at_s is not None:
        return f"{at_s:.0f} s by the world's clock"
    return f"{action} of {' and '.join(doers.get(action, ()))}"


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
    failure: FailureCategory | None = Field(
        description="null: nothing has failed, an operator has asked for another plan"
    )
    reason: str
    troubles: list[TroubleBody]
    measure: Measure | None = Field(
        description="retry: the rest of the same plan; repair: another plan; replan: one without some robots"
    )
    goals: list[str] = Field(default=[], description="those that waited and that it is to be for, too")
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


class ResultBody(BaseModel):
    """An image or a reading that a packet of a mission has brought."""

    model_config = ConfigDict(from_attributes=True)

    id: str
    mission_id: str
    robot: str
    packet_id: str
    kind: Literal["image", "reading"]
    name: str = Field(description="the camera or the quantity")
    of: str = Field(description="the place, sample or robot that it tells of")
    at_s: float = Field(description="world's clock")
    created_at: str = Field(description="when it was received")
    media_type: Literal["image/png", "image/jpeg"] | None = Field(description="of an image")
    size_bytes: int | None = Field(description="of an image")
    value: float | None = Field(description="of a reading")
    unit: str


class SpeechBody(BaseModel):
    """What one robot of a mission has said to another, as the other reports it, or what the service and a robot have
    said to each other about the mission or its goal.
    """

    sender: str
    robot: str = Field(description="who heard it, a robot or `service`")
    performative: Performative
    content: str = Field(description="a term, such as `ended(script, action)`")
    protocol: str
    conversation: str = Field(description="what belongs together")
    sent_at_s: float = Field(description="world's clock")
    at_s: float = Field(description="when it was heard, world's clock")
    attempt: int = Field(default=1, description="how often it was said until it was heard")
    answer: Performative | None = Field(default=None, description="null: answers are listed on their own")
    answer_content: str = ""
    speaker: str = Field(default="", description="the person for whom the service says it; empty if none")


class ReportBody(BaseModel):
    """What a robot has reported of a packet, what its telemetry showed, or what the record had."""

    robot: str = Field(description="or the source of what is believed")
    packet: str
    tag: str
    state: str
    at_s: float | None = Field(description="world's clock; null: it has reported nothing of it")
    holding: str = Field(
        default="", description="what its telemetry showed it to hold; empty if it is no such telemetry"
    )
    place: str = Field(default="", description="where its telemetry showed it to stand; likewise")
    believed: str = Field(default="", description="the recorded fact; empty if it is a robot's word")


class ContradictionBody(BaseModel):
    """Two reports on a plan that do not fit together: `later` began before `earlier` had ended, or had begun, or both
    hold the same thing or stand at the same place.
    """

    plan_id: str
    earlier: ReportBody
    later: ReportBody
    things: list[str] = Field(description="what the reports are about; where they are is no longer believed")
    detail: str


class BetterPlanBody(BaseModel):
    """What planning a mission again would have saved when it was last looked at, because a robot became available."""

    made_at_s: float = Field(description="when that was, world's clock")
    ends_in_s: float = Field(description="when all its goals would have been true, from then")
    saves_s: float = Field(
        description="by how much sooner it would have ended, the stop of its robots counted"
    )
    robots: list[str]


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
    joined_goals: list[str] = Field(
        default=[], description="goals that waited and that it carries out beside its own, or has"
    )
    better_plan: BetterPlanBody | None = Field(
        default=None,
        description="of the plan that it carries out now; `:replan` has it made. null: none that is worth it is known",
    )
    contradictions: list[ContradictionBody] = Field(
        default=[],
        description="in what its robots have reported, on all its plans; it does not complete with them",
    )
    results: int = Field(default=0, description="how many its packets have brought")
    delegate: bool = Field(
        default=False, description="robots in the field may put legs of their scripts to each other"
    )
    recovery: RecoveryBody
    progress: list[ScriptProgress] = Field(description="of the plan that it carries out now")
    earlier: list[ScriptProgress] = Field(
        default=[], description="the scripts of its earlier plans; each has ended or its robot is lost"
    )

    @classmethod
    def of(cls, row: MissionRow, scripts: list[ScriptRow]) -> Self:
        return cls.model_validate(mission_document(row, scripts))


class AchievedBody(BaseModel):
    """A goal, and when it would be true."""

    model_config = ConfigDict(from_attributes=True)

    goal: SymbolicFact
    in_s: float = Field(description="from now, world seconds; 0: it is true already")


class MissionPreviewBody(BaseModel):
    """What would come of having a mission planned again now."""

    model_config = ConfigDict(from_attributes=True)

    made_at_s: float = Field(description="world's clock")
    reason: str = Field(description="why there is no plan; empty if there is one")
    ends_in_s: float | None = Field(description="when all goals would be true, from now; null without a plan")
    expected_in_s: float | None = Field(
        description="when it is expected to end by its present plan, from now; null: it has not begun"
    )
    robots: list[str]
    changes: list[str] = Field(description="what would become of the present plan's actions, in words")
    achieved: list[AchievedBody]
    unkept: str = Field(description="what the plan would not keep to of the edits; empty if nothing")


MISSION_FIELDS = tuple(MissionBody.model_fields)
_PLAIN = tuple(
    name
    for name in MISSION_FIELDS
    if name not in ("reason", "recovery", "progress", "earlier", "better_plan")
)


def mission_document(row: MissionRow, scripts: Sequence[ScriptRow]) -> dict[str, Any]:
    """A `MissionBody` as data for JSON. Of what was validated when it was recorded nothing is validated again."""
    recovery: dict[str, Any] = {
        "policy": row.recovery,
        "step": row.recovery_step,
        "tries_left": row.tries_left,
        "attempts": row.attempts,
    }
    if row.attempts:  # earlier versions recorded fewer fields
        recovery = RecoveryBody.model_validate(recovery).model_dump(mode="json")
    known = {
        **dict(zip(_PLAIN, values_of(row, _PLAIN), strict=True)),
        "reason": full_reason(row),
        "recovery": recovery,
        "progress": _progress([script for script in scripts if script.plan_id == row.plan_id]),
        "earlier": _progress([script for script in scripts if script.plan_id != row.plan_id]),
        "better_plan": _better_plan(row),
    }
    return {name: known[name] for name in MISSION_FIELDS}


def _better_plan(row: MissionRow) -> dict[str, Any] | None:
    """The better plan that is known of a mission under way; None if it is of an earlier plan, or being made."""
    known = row.better_plan
    if known is None or known["plan_id"] != row.plan_id:
        return None
    if row.replanning is not None or row.ended_at_s is not None:
        return None
    return {name: known[name] for name in BetterPlanBody.model_fields}


def _progress(scripts: Sequence[ScriptRow]) -> list[dict[str, Any]]:
    doers: dict[tuple[str, str], list[str]] = {}
    for script in scripts:
        for packet in script.body["packets"]:
            doers.setdefault((script.plan_id, packet["id"]), []).append(script.robot)
    return [
        _script_document(
            script, {action: robots for (of, action), robots in doers.items() if of == script.plan_id}
        )
        for script in scripts
    ]


class ScriptBody(BaseModel):
    robot: str
    delivery: str
    state: str | None
    script: BehaviourScript
