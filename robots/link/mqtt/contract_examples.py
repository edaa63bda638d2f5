"""An example of each message between the service and a robot: fred carries sample_1 from door_1 to bay_7."""

from collections.abc import Mapping
from typing import Any

from robots.link.mqtt.topics import SERVICE, ConnectionState, Presence, WorldAnnouncement
from robots.wire import (
    CONTRACT,
    Acknowledgement,
    BehaviourPacket,
    BehaviourScript,
    Body,
    Clearance,
    Control,
    ControlVerb,
    DelegationBid,
    DelegationReport,
    DelegationState,
    Factsheet,
    FactsheetAnswer,
    FactsheetState,
    FaultLevel,
    FaultReport,
    Message,
    MindOrder,
    MindOrderReport,
    MindPiece,
    MindQuery,
    MindReport,
    MindTransfer,
    MindTransferReport,
    MindVerb,
    NotUnderstood,
    PacketReport,
    PacketState,
    Performative,
    ReadingResult,
    Receipt,
    Refusal,
    Retune,
    RobotFault,
    RuleSet,
    RulesReport,
    SampleReport,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    SetPoint,
    SetPointRefusal,
    SpeechAct,
    SpeechReport,
    StatusQuery,
    StatusReport,
    SymbolicFact,
    Telemetry,
    ToldAgent,
    ToldBelief,
    ToldCommitment,
    TracedPattern,
    TracedStretch,
    TracedTick,
    TraceQuery,
    TraceReport,
    TuningReport,
    UpkeepReport,
)
from robots.wire.script import Wire

ROBOT = "fred"
SCRIPT = "mission-1:fred:0"
AT_BAY = SymbolicFact(predicate="in", args=("sample_1", "bay_7"))
FAULT = RobotFault(level=FaultLevel.URGENT, type="lidar", text="its window is dirty")
HOLDING = SymbolicFact(predicate="holding", args=(ROBOT, "sample_1"))
MIND = MindReport(
    at_s=120.5,
    version=2,
    digests={"guard": "5d41402a"},
    agents=(
        ToldAgent(
            name="guard",
            beliefs=(
                ToldBelief(term="on_duty", value=True, origin="adopted", source="guard:2", since_s=0.1),
            ),
            belief_count=1,
            commitments=(
                ToldCommitment(
                    number=1,
                    rule="guard:2",
                    name="adoptBelief",
                    towards="Self",
                    made_s=0.0,
                    due_s=0.0,
                    ended_s=0.0,
                    state="fulfilled",
                ),
            ),
            commitment_count=1,
        ),
    ),
)
PACKETS = (
    BehaviourPacket(
        id="a1",
        tag="DOCK",
        arguments={"object": "sample_1", "ref1": "door_1"},
        achieves=(HOLDING,),
        expected_start_s=0.0,
        expected_duration_s=20.0,
        timeout_s=80.0,
        wait_timeout_s=120.0,
        description="fred grips sample_1 at door_1",
    ),
    BehaviourPacket(
        id="a2",
        tag="RELEASE2",
        arguments={"object": "sample_1", "ref1": "bay_7"},
        after=("a9",),
        achieves=(AT_BAY,),
        expected_start_s=20.0,
        expected_duration_s=15.0,
        timeout_s=60.0,
        wait_timeout_s=120.0,
        description="fred puts sample_1 down in bay_7",
    ),
)

_PIECE = MindPiece(
    number=0,
    count=2,
    digest="9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08",
    text='{"version": 1, "robot": "fred", "fence": 5, ',
)
"""Of a mind's document, which begins so."""


def _said(
    message_id: str, performative: Performative, body: Body, *, by_robot: bool, reply: str | None = None
) -> Message:
    return Message(
        id=message_id,
        performative=performative,
        sender=ROBOT if by_robot else SERVICE,
        receiver=SERVICE if by_robot else ROBOT,
        sent_at_s=120.5,
        in_reply_to=reply,
        body=body,
    )


def _ask(message_id: str, performative: Performative, body: Body, *, reply: str | None = None) -> Message:
    return _said(message_id, performative, body, by_robot=False, reply=reply)


def _tell(message_id: str, performative: Performative, body: Body, *, reply: str | None = None) -> Message:
    return _said(message_id, performative, body, by_robot=True, reply=reply)


def examples() -> Mapping[str, Wire]:
    """By kind, and by the name of what is retained."""
    request = f"{SCRIPT}:request"
    p = Performative
    messages = (
        _ask(
            request,
            p.REQUEST,
            ScriptRequest(
                script=BehaviourScript(id=SCRIPT, mission_id="mission-1", robot=ROBOT, packets=PACKETS)
            ),
        ),
        _ask(f"{SCRIPT}:cancel:2", p.CANCEL, Control(script_id=SCRIPT, verb=ControlVerb.CANCEL, number=2)),
        _ask(f"{SCRIPT}:cleared:1", p.REQUEST, Clearance(script_id=SCRIPT, ended=("a9",))),
        _ask(f"{SCRIPT}:status:120.5", p.QUERY, StatusQuery(script_id=SCRIPT)),
        _ask("c0ffee", p.CONFIRM, Receipt(), reply="fred-17"),
        _ask("c0ffef", p.CONFIRM, FactsheetAnswer(state=FactsheetState.IN_FORCE), reply="fred-1"),
        _ask("7e57", p.QUERY, TraceQuery(seconds=5.0)),
        _ask("7e58", p.QUERY, MindQuery()),
        _ask("fred:mind:4:rest", p.REQUEST, MindOrder(verb=MindVerb.REST, fence=4)),
        _ask("fred:mind:5:transfer:9f86d081:0", p.REQUEST, MindTransfer(fence=5, mind=_PIECE)),
        _ask("fred:tuning:3", p.REQUEST, Retune(version=3, tuning={})),
        _ask("fred:rules:2", p.REQUEST, RuleSet(version=2, files={"guard": "AGENT guard;"})),
        _ask("d41", p.REQUEST, SetPoint(driver="anna", number=8, speed_m_s=0.2, valid_s=0.5)),
        _tell(
            "fred-1",
            p.INFORM,
            Factsheet(
                number=1,
                repertoire=("DOCK", "TRANSPORT", "RELEASE2"),
                speed_m_s=0.5,
                turn_rad_s=1.5,
                start=(3.0, 1.4, 90.0),
                contract=CONTRACT,
            ),
        ),
        _tell("fred-2", p.AGREE, Acknowledgement(script_id=SCRIPT), reply=request),
        _tell("fred-3", p.REFUSE, Refusal(script_id=SCRIPT, reason="no packet LIFT"), reply=request),
        _tell(
            "fred-17",
            p.INFORM,
            PacketReport(
                script_id=SCRIPT,
                packet_id="a1",
                state=PacketState.FINISHED,
                at_s=141.0,
                perceived=(HOLDING,),
                results=(ReadingResult(name="mass", of="sample_1", value=1.2, unit="kg"),),
            ),
        ),
        _tell(
            "fred-20",
            p.INFORM,
            ScriptReport(script_id=SCRIPT, state=ScriptState.FINISHED, at_s=160.0, packet_id="a2"),
        ),
        _tell(
            "fred-18",
            p.INFORM,
            StatusReport(
                script_id=SCRIPT,
                state=ScriptState.RUNNING,
                at_s=150.0,
                packet_id="a2",
                packet_state=PacketState.WAITING,
                detail="waits for clearance: a9",
                order=1,
            ),
            reply=f"{SCRIPT}:status:120.5",
        ),
        _tell("fred-30", p.INFORM, UpkeepReport(tag="CHARGE", state=PacketState.RUNNING, at_s=400.0)),
        _tell("fred-33", p.INFORM, FaultReport(at_s=405.0, faults=(FAULT,))),
        _tell("fred-31", p.INFORM, SampleReport(sample="sample_9", place="bay_2", at_s=410.0)),
        _tell("fred-36", p.INFORM, MIND, reply="7e58"),
        _tell(
            "fred-32",
            p.INFORM,
            TraceReport(
                at_s=120.6,
                stretches=(
                    TracedStretch(
                        packet_id="a1",
                        patterns=(TracedPattern(name="translate/approach", level="reflexive"),),
                        dofs=("translate",),
                        ticks=(
                            TracedTick(
                                at_s=120.0,
                                patterns=((0.5, 1.0),),
                                resultants=((0.5, 1.0),),
                                linear_m_s=0.25,
                                angular_rad_s=0.0,
                            ),
                        ),
                    ),
                ),
            ),
            reply="7e57",
        ),
        _tell("fred-33", p.AGREE, TuningReport(version=3), reply="fred:tuning:3"),
        _tell(
            "fred-38",
            p.AGREE,
            RulesReport(version=2, digests={"guard": "6b3c7d11a0f2"}),
            reply="fred:rules:2",
        ),
        _tell("fred-39", p.AGREE, MindOrderReport(verb=MindVerb.REST, fence=4), reply="fred:mind:4:rest"),
        _tell(
            "fred-40",
            p.AGREE,
            MindTransferReport(fence=5, digest=_PIECE.digest, number=0),
            reply="fred:mind:5:transfer:9f86d081:0",
        ),
        _tell("fred-34", p.REFUSE, SetPointRefusal(driver="anna", reason="on a script"), reply="d41"),
        Message(
            id="fred-36",
            performative=p.INFORM,
            sender=ROBOT,
            receiver="ginger",
            sent_at_s=140.0,
            body=SpeechAct(
                content="ended(mission-1-ginger, a1)",
                ontology="macta-mission",
                protocol="macta-inform",
                conversation_id="8b1f",
                reply_by_s=440.0,
            ),
        ),
        _tell(
            "fred-37",
            p.INFORM,
            SpeechReport(
                script_id=SCRIPT,
                sender="ginger",
                performative=p.INFORM,
                content=f'ended("{SCRIPT}", a2)',
                protocol="macta-inform",
                conversation_id="77c0",
                sent_at_s=150.0,
                at_s=150.1,
                answer=p.CONFIRM,
                answer_content=f'ended("{SCRIPT}", a2)',
            ),
        ),
        _tell(
            "fred-39",
            p.INFORM,
            DelegationReport(
                script_id=SCRIPT,
                leg="leg_a1",
                state=DelegationState.DONE,
                at_s=190.5,
                robot="ginger",
                bids=(DelegationBid(robot="ginger", cost_s=42.0),),
                expected_s=42.0,
                stands="home_ginger",
                aside="home_fred",
            ),
        ),
        _tell("fred-35", p.NOT_UNDERSTOOD, NotUnderstood(reason="unknown kind dance"), reply="d42"),
    )
    bare: Mapping[str, Wire] = {
        "telemetry": Telemetry(
            at_s=120.5, x_m=3.0, y_m=1.4, heading_rad=1.57, battery=0.8, holding="sample_1"
        ),
        "presence": Presence(state=ConnectionState.ONLINE),
        "world_announcement": WorldAnnouncement(
            state=ConnectionState.ONLINE, run="run-4f2a", time_s=120.0, contract=CONTRACT, by=SERVICE
        ),
    }
    return {**{message.body.kind: message for message in messages}, **bare}


def example(name: str) -> dict[str, Any]:
    """As JSON. Of what has defaults only what differs is there, for a reader's sake."""
    said = examples()[name]
    lean: dict[str, Any] = _with_kinds(
        said.model_dump(mode="json", exclude_defaults=True), said.model_dump(mode="json")
    )
    return lean


def _with_kinds(lean: Any, full: Any) -> Any:
    """The shorter form with the `kind` of each part, which is a default."""
    if isinstance(lean, list):
        return [_with_kinds(*pair) for pair in zip(lean, full, strict=True)]
    if not isinstance(lean, dict):
        return lean
    kind = {"kind": full["kind"]} if "kind" in full else {}
    return kind | {name: _with_kinds(value, full[name]) for name, value in lean.items()}
