"""Robots that do as their scripts say without moving: they implement the far end of a link, for tests of the service.

Time is a manual clock's; a packet takes as long as its script expects. What goes wrong is chosen by the test.
"""

import threading
import time
from dataclasses import dataclass, field

from robots.clock import ManualClock
from robots.deliberative.mind import Mind
from robots.executive.hand_over import pieces_of
from robots.link import InMemoryLink
from robots.wire import (
    WORLD,
    Acknowledgement,
    BehaviourPacket,
    BehaviourScript,
    Body,
    Clearance,
    Control,
    ControlVerb,
    FactsheetAnswer,
    FailureCategory,
    Message,
    MindOrder,
    MindOrderReport,
    MindQuery,
    MindReport,
    MindTransfer,
    MindTransferReport,
    MindVerb,
    NotUnderstood,
    PacketReport,
    PacketResult,
    PacketState,
    PacketTunings,
    Performative,
    Program,
    Receipt,
    Refusal,
    Retune,
    RuleSet,
    RulesReport,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    SetPoint,
    SetPointRefusal,
    SpeechAct,
    StatusQuery,
    StatusReport,
    SymbolicFact,
    Telemetry,
    TraceQuery,
    TraceReport,
    TuningReport,
    WorldChange,
    WorldEdition,
)
from robots.world import load_world

STORE = load_world("sample_store")
DOCUMENT = '{"version": 1, "robot": "yard_1"}'
"""What any robot hands over as its mind."""
NO_MIND = "no mind was handed over"
TICK_S = 0.5
SAID_AGAIN_S = 0.5
"""Wall-clock seconds without a receipt after which a patient team says a report again."""


@dataclass
class FakeRobot:
    """One robot's place in its script."""

    script: BehaviourScript | None = None
    state: ScriptState | None = None
    packet: int = 0
    started: bool = False
    left_s: float = 0.0
    executed: list[str] = field(default_factory=list)
    deeds: list[tuple[str, ...]] = field(default_factory=list)
    """Tag and arguments of each packet that it has finished."""
    cleared: set[str] = field(default_factory=set)
    seen: set[str] = field(default_factory=set)
    answers: dict[str, Message] = field(default_factory=dict)
    at: tuple[str, str] | None = None
    """Relation and place, where it is at one."""
    holds: str | None = None
    tunings: list[PacketTunings] = field(default_factory=list)
    mind: Mind | None = None
    """Its deliberative level; without one it does not understand rules."""
    forgone: set[str] = field(default_factory=set)
    set_points: list[SetPoint] = field(default_factory=list)
    order: int = 0
    """The number of the newest order followed on the script."""
    heard: list[tuple[str, str, str]] = field(default_factory=list)
    """Performative, content and speaker of what was said to it, each once."""
    orders: list[MindOrder] = field(default_factory=list)
    """What its mind was ordered, each once."""
    rests: bool = False
    program: Program = Program.WORLD
    """Which of its programs acts, or has acted last."""
    taken: dict[int, str] = field(default_factory=dict)
    """What its own software has of the mind that is handed over, by the number of the piece."""
    says: dict[str, list[tuple[Performative, str]]] = field(default_factory=dict)
    """What it answers, one after the other, by the name of the content's term, or its beginning, `leg(leg_1`; else
    nothing.
    """

    def answer_to(self, content: str) -> list[tuple[Performative, str]]:
        named = self.says.get(content.partition("(")[0])
        begun = (
            answers for start, answers in self.says.items() if "(" in start and content.startswith(start)
        )
        return next(begun, []) if named is None else named


@dataclass
class Faults:
    """What goes wrong: robots that are silent, fail at a packet tag, refuse scripts, or say everything twice."""

    silent: set[str] = field(default_factory=set)
    fails_at: dict[str, str] = field(default_factory=dict)
    says: str = "the gripper does not close"
    """What one says that fails."""
    failures_left: int = 1_000_000
    """So often any of them fails; then they do as they are told."""
    perceives: bool = False
    """Robots whose script ends before its time say where they are and what they hold."""
    drops: set[str] = field(default_factory=set)
    """Robots that lose what they carry on the way, and say so."""
    refuses: set[str] = field(default_factory=set)
    stuck: set[str] = field(default_factory=set)
    takes_s: dict[str, float] = field(default_factory=dict)
    """How long packets of a tag take, whatever their script expects."""
    late_s: dict[tuple[str, str], float] = field(default_factory=dict)
    """By how much a robot's report that a packet of a tag has ended arrives late."""
    repeats: bool = False
    own_is_off: set[str] = field(default_factory=set)
    """Robots whose own software does not run."""
    unfit: dict[str, str] = field(default_factory=dict)
    """Why a robot's own software takes no mind."""
    world_refuses: bool = False
    """The world takes up no edition."""
    lost: int = 0
    """So many of the next messages to robots never arrive."""


class FakeTeam:
    """All robots of a world on one link, in a thread, with the world's clock."""

    def __init__(self, run: str = "run-of-the-fake-team") -> None:
        self.link, self._far = InMemoryLink.pair()
        self.run = run
        self.clock = ManualClock()
        self.tick_s = TICK_S
        """By how much the world's time goes on with each turn of the thread, some 5 ms; 0: it stands."""
        self.faults = Faults()
        self.robots: dict[str, FakeRobot] = {}
        self.true_facts: set[SymbolicFact] = set()
        self.receipts: list[str] = []
        self.arrived: list[str] = []
        """The ids of all messages to robots, also of the lost."""
        self.unbelieved: str | None = None
        """The packet whose finish is never reported."""
        self.patient = True
        """Reports are said again until there is a receipt, as real robots do: the service takes none while its lease
        has lapsed."""
        self.replies: list[tuple[str, FactsheetAnswer]] = []
        """What robots were told of their factsheets, in order; the same answer to what was said again counts once."""
        self._answered: set[tuple[str | None, FactsheetAnswer]] = set()
        self.editions: list[int] = []
        self.minds: list[dict[str, str]] = []
        """With which the world was to take the places of robots' own software, by edition."""
        """Those that the world was told of, in order."""
        self.edition = 0
        """The one that the world has taken up."""
        self._unconfirmed: dict[str, tuple[float, Message]] = {}
        self._held_back: list[tuple[float, Message]] = []
        self.brings: dict[str, tuple[PacketResult, ...]] = {}
        """What packets bring that finish, by tag."""
        self.traced = TraceReport(at_s=0.0)
        """What robots tell of their traces."""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "FakeTeam":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def tell(
        self,
        name: str,
        *,
        battery: float,
        charging: bool = False,
        driven_by: str | None = None,
        script_id: str | None = None,
    ) -> None:
        """A robot's telemetry arrives."""
        x_m, y_m = self._point(name)
        told = Telemetry(
            at_s=self.clock.now_s(),
            x_m=x_m,
            y_m=y_m,
            heading_rad=0.0,
            battery=battery,
            charging=charging,
            driven_by=driven_by,
            script_id=script_id,
        )
        self._far.send(self._message(name, Performative.INFORM, told))

    def _point(self, name: str) -> tuple[float, float]:
        """The place where the robot is, in the sample store; where it starts if it is at none."""
        robot = self.robots.get(name)
        if robot is not None and robot.at is not None and robot.at[1] in STORE.points:
            return STORE.location(robot.at[1]).at
        return STORE.robot(name).start[:2]

    def report(self, name: str, body: Body) -> str:
        """A robot's report arrives, not before it was made: time goes on until then. Answers its id."""
        self.clock.advance(max(0.0, getattr(body, "at_s", 0.0) - self.clock.now_s()))
        message = self._message(name, Performative.INFORM, body)
        self._say(message)
        return message.id

    def _run(self) -> None:
        while not self._stop.is_set():
            for message in self._far.receive():
                self.arrived.append(message.id)
                if self.faults.lost > 0:
                    self.faults.lost -= 1
                elif message.receiver not in self.faults.silent and not self._is_for_nobody(message):
                    self._take(message)
            self.clock.advance(self.tick_s)
            for name, robot in list(self.robots.items()):  # tests add some meanwhile
                if name not in self.faults.silent:
                    self._work(name, robot)
            self._say_again()
            due = [held for held in self._held_back if held[0] <= self.clock.now_s()]
            for held in due:
                self._held_back.remove(held)
                self._say(held[1])
            time.sleep(0.005)

    def _is_for_nobody(self, message: Message) -> bool:
        """True for what is for a robot's own software that does not run."""
        body = message.body
        is_for_own = isinstance(body, MindTransfer) or (
            isinstance(body, MindOrder) and body.to is Program.OWN
        )
        return is_for_own and message.receiver in self.faults.own_is_off

    def _take(self, message: Message) -> None:
        if message.receiver == WORLD:
            self._take_as_world(message)
            return
        robot = self.robots.setdefault(message.receiver, FakeRobot())
        if isinstance(message.body, Receipt | FactsheetAnswer):
            self._note_answer(message, message.body)
            return
        if isinstance(message.body, TraceQuery | MindQuery):
            self._far.send(self._told(message, robot.mind))
            return
        if isinstance(message.body, SetPoint | SpeechAct):
            self._take_at_once(message, message.body, robot)
            return
        if message.id in robot.answers:
            self._far.send(robot.answers[message.id])
            return
        if isinstance(message.body, Retune):
            self._retune(message, message.body, robot)
            return
        if isinstance(message.body, RuleSet):
            answer = self._follow(message, message.body, robot.mind)
        else:
            answer = self._answer(message, robot)
        if not _may_be_otherwise(answer):
            robot.answers[message.id] = answer
        self._far.send(answer)

    def _take_at_once(self, message: Message, body: SetPoint | SpeechAct, robot: FakeRobot) -> None:
        if isinstance(body, SetPoint):
            self._drive(message, body, robot)
        else:
            self._speak(message, body, robot)

    def _speak(self, message: Message, act: SpeechAct, robot: FakeRobot) -> None:
        """Answer what is said once, and its repetitions by the last answer."""
        if message.id not in robot.answers:
            robot.heard.append((message.performative.value, act.content, act.speaker))
        for performative, content in robot.answer_to(act.content):
            body = act.model_copy(update={"content": content, "speaker": ""})
            answer = self._message(message.receiver, performative, body, message.id)
            robot.answers[message.id] = answer
            self._far.send(answer)

    def _take_as_world(self, message: Message) -> None:
        if isinstance(message.body, WorldChange):
            if (self.editions[-1:], self.minds[-1:]) != ([message.body.edition], [message.body.minds]):
                self.editions.append(message.body.edition)  # not what is said again
                self.minds.append(message.body.minds)
            refused = self.faults.world_refuses
            self.edition = self.edition if refused else message.body.edition
            taken = WorldEdition(edition=self.edition, reason="it cannot be made" if refused else "")
            performative = Performative.REFUSE if refused else Performative.AGREE
            self._far.send(self._message(WORLD, performative, taken, message.id))

    def _note_answer(self, message: Message, answer: Receipt | FactsheetAnswer) -> None:
        if isinstance(answer, FactsheetAnswer):
            if (message.in_reply_to, answer) not in self._answered:
                self._answered.add((message.in_reply_to, answer))
                self.replies.append((message.receiver, answer))
        else:
            self.receipts.append(message.in_reply_to or "")
            self._unconfirmed.pop(message.in_reply_to or "", None)

    def _drive(self, message: Message, wanted: SetPoint, robot: FakeRobot) -> None:
        robot.set_points.append(wanted)
        name, driver = message.receiver, None if wanted.ends else wanted.driver
        if name in self.faults.refuses:
            refusal = SetPointRefusal(driver=wanted.driver, reason=f"{name} is not willing")
            self._far.send(self._message(name, Performative.REFUSE, refusal, message.id))
        else:
            self.tell(name, battery=1.0, driven_by=driver)

    def _retune(self, message: Message, wanted: Retune, robot: FakeRobot) -> None:
        refused = message.receiver in self.faults.refuses
        answer = TuningReport(version=wanted.version, reason="not willing" if refused else "")
        performative = Performative.REFUSE if refused else Performative.AGREE
        robot.tunings.append(wanted.tuning)
        robot.answers[message.id] = self._message(message.receiver, performative, answer, message.id)
        self._far.send(robot.answers[message.id])

    def _follow(self, message: Message, wanted: RuleSet, mind: Mind | None) -> Message:
        name = message.receiver
        if mind is None:
            unknown = NotUnderstood(reason="unknown kind rule_set")
            return self._message(name, Performative.NOT_UNDERSTOOD, unknown, message.id)
        reason = mind.follow(wanted.files, wanted.version, self.clock.now_s(), wanted.role)
        performative = Performative.AGREE if reason is None else Performative.REFUSE
        report = RulesReport(
            version=wanted.version, reason=reason or "", digests=dict(mind.digests), role=mind.role
        )
        return self._message(name, performative, report, message.id)

    def _told(self, message: Message, mind: Mind | None) -> Message:
        name = message.receiver
        if isinstance(message.body, TraceQuery):
            return self._message(name, Performative.INFORM, self.traced, message.id)
        if mind is None:
            unknown = NotUnderstood(reason="unknown kind mind_query")
            return self._message(name, Performative.NOT_UNDERSTOOD, unknown, message.id)
        told = MindReport(
            at_s=self.clock.now_s(),
            version=mind.version,
            digests=dict(mind.digests),
            agents=mind.told(),
        )
        return self._message(name, Performative.INFORM, told, message.id)

    def _answer(self, message: Message, robot: FakeRobot) -> Message:
        name = message.receiver
        match message.body:
            case ScriptRequest(script=script) if name in self.faults.refuses:
                refusal = Refusal(script_id=script.id, reason=f"{name} is not willing")
                return self._message(name, Performative.REFUSE, refusal, message.id)
            case ScriptRequest(script=script) if script.id in robot.forgone:
                refusal = Refusal(script_id=script.id, reason="stale: cancelled before it arrived")
                return self._message(name, Performative.REFUSE, refusal, message.id)
            case ScriptRequest(script=script):
                robot.script, robot.state, robot.packet, robot.started = (
                    script,
                    ScriptState.ACCEPTED,
                    0,
                    False,
                )
                robot.order = 0
                robot.cleared.clear()
                if robot.at is None and "ref1" in script.packets[0].arguments:
                    robot.at = ("near", script.packets[0].arguments["ref1"])
                return self._message(
                    name, Performative.AGREE, Acknowledgement(script_id=script.id), message.id
                )
            case Clearance(script_id=script_id, ended=ended):
                robot.cleared.update(ended)
                return self._message(
                    name, Performative.AGREE, Acknowledgement(script_id=script_id), message.id
                )
            case Control() | MindOrder() | MindTransfer():
                return self._obey(message, message.body, robot)
            case StatusQuery(script_id=script_id):
                known = robot.script is not None and robot.script.id == script_id
                waits = known and not robot.started and robot.state is ScriptState.RUNNING
                status = StatusReport(
                    script_id=script_id,
                    state=robot.state if known else None,
                    at_s=self.clock.now_s(),
                    packet_id=robot.script.packets[robot.packet].id if waits and robot.script else None,
                    packet_state=PacketState.INITIALIZING if waits else None,
                    detail="waits" if waits else "",
                    order=robot.order if known else 0,
                )
                return self._message(name, Performative.INFORM, status, message.id)
        raise AssertionError(f"a robot is not sent {message.body.kind}")

    def _obey(self, message: Message, order: Control | MindOrder | MindTransfer, robot: FakeRobot) -> Message:
        name = message.receiver
        if isinstance(order, Control):
            return self._ordered(message, order, robot)
        if isinstance(order, MindTransfer):
            return self._take_mind(message, order, robot)
        robot.orders.append(order)
        refused = name in self.faults.refuses
        reason = f"{name} is not willing" if refused else ""
        is_own = order.to is Program.OWN and robot.program is Program.WORLD and not refused
        if is_own and order.verb is MindVerb.GO_ON and not robot.taken:
            reason = NO_MIND
        if not reason:
            robot.rests = order.verb is MindVerb.REST
            if order.verb is MindVerb.GO_ON and order.to is not None:
                robot.program = order.to
                robot.taken = {}
        hands_over = order.piece is not None and not reason
        report = MindOrderReport(
            verb=order.verb,
            fence=order.fence,
            reason=reason,
            lease_until_s=order.lease_until_s,
            mind=pieces_of(DOCUMENT, size=10)[order.piece or 0] if hands_over else None,
        )
        performative = Performative.REFUSE if reason else Performative.AGREE
        return self._message(name, performative, report, message.id)

    def _take_mind(self, message: Message, transfer: MindTransfer, robot: FakeRobot) -> Message:
        name, piece = message.receiver, transfer.mind
        reason = self.faults.unfit.get(name, "")
        if not reason:
            robot.taken[piece.number] = piece.text
        report = MindTransferReport(
            fence=transfer.fence, digest=piece.digest, number=piece.number, reason=reason
        )
        return self._message(name, Performative.REFUSE if reason else Performative.AGREE, report, message.id)

    def _ordered(self, message: Message, order: Control, robot: FakeRobot) -> Message:
        name, script_id = message.receiver, order.script_id
        if order.verb is not ControlVerb.CANCEL and order.number < robot.order:
            refusal = Refusal(script_id=script_id, reason=f"overtaken by order {robot.order}")
            return self._message(name, Performative.REFUSE, refusal, message.id)
        robot.order = max(order.number, robot.order)
        self._control(name, robot, script_id, order.verb)
        return self._message(name, Performative.AGREE, Acknowledgement(script_id=script_id), message.id)

    def _control(self, name: str, robot: FakeRobot, script_id: str, verb: ControlVerb) -> None:
        if robot.script is None or robot.script.id != script_id:
            if verb is ControlVerb.CANCEL:
                robot.forgone.add(script_id)
                forgone = ScriptReport(
                    script_id=script_id, state=ScriptState.CANCELLED, at_s=self.clock.now_s()
                )
                self._say(self._message(name, Performative.FAILURE, forgone))
        elif robot.state not in (ScriptState.ACCEPTED, ScriptState.RUNNING, ScriptState.PAUSED):
            return  # it has ended meanwhile
        elif verb is ControlVerb.CANCEL:
            self._end(name, robot, ScriptState.CANCELLED)
        else:
            robot.state = ScriptState.PAUSED if verb is ControlVerb.PAUSE else ScriptState.RUNNING

    def _work(self, name: str, robot: FakeRobot) -> None:
        if robot.rests or robot.script is None:
            return
        if robot.state not in (ScriptState.ACCEPTED, ScriptState.RUNNING):
            return
        packet = robot.script.packets[robot.packet]
        if not robot.started:
            sensed = set(packet.awaits) <= self.true_facts
            if not sensed or not set(packet.after) <= robot.cleared or name in self.faults.stuck:
                return
            robot.state, robot.started = ScriptState.RUNNING, True
            robot.left_s = self.faults.takes_s.get(packet.tag, packet.expected_duration_s)
            if packet.tag in ("NAVIGATE", "TRANSPORT"):
                robot.at = None
            self._report(name, robot, PacketState.RUNNING)
            return
        robot.left_s -= self.tick_s
        if robot.left_s > 0 or self._is_let_down(packet):
            return
        dropped = name in self.faults.drops and packet.tag == "TRANSPORT"
        if dropped:
            robot.holds = None
        fails = self.faults.fails_at.get(name) == packet.tag and self.faults.failures_left > 0
        if dropped or fails:
            self.faults.failures_left -= fails
            self._report(name, robot, PacketState.FAILED)
            self._end(name, robot, ScriptState.FAILED)
            return
        robot.executed.append(packet.id)
        robot.deeds.append((packet.tag, *packet.arguments.values()))
        self._moved(robot, packet)
        self.true_facts |= set(packet.achieves)
        self._report(name, robot, PacketState.FINISHED)
        robot.packet, robot.started = robot.packet + 1, False
        if robot.packet == len(robot.script.packets):
            self._end(name, robot, ScriptState.FINISHED)

    def _is_let_down(self, packet: BehaviourPacket) -> bool:
        """True if it carries something with a partner that does not go on: neither gets on alone."""
        partner = self.robots.get(packet.arguments.get("partner", ""))
        return partner is not None and partner.state in (ScriptState.FAILED, ScriptState.CANCELLED)

    def _moved(self, robot: FakeRobot, packet: BehaviourPacket) -> None:
        if packet.tag == "DOCK":
            robot.at, robot.holds = ("at", packet.arguments["ref1"]), packet.arguments["object"]
        elif packet.tag == "DOCK2":
            robot.at, robot.holds = ("at", packet.arguments["ref2"]), packet.arguments["object"]
        elif "ref2" in packet.arguments:
            robot.at = ("near", packet.arguments["ref2"])
        if packet.tag in ("RELEASE1", "RELEASE2"):
            robot.holds = None

    def _perceived(self, name: str, robot: FakeRobot) -> tuple[SymbolicFact, ...]:
        if not self.faults.perceives:
            return ()
        grip = "full" if robot.holds else "empty"
        facts = [SymbolicFact(predicate="robot_attribute", args=(name, "gripper", grip))]
        if robot.holds:
            facts.append(SymbolicFact(predicate="in", args=(robot.holds, name)))
        if robot.at:
            facts.append(SymbolicFact(predicate=robot.at[0], args=(name, robot.at[1])))
        return tuple(facts)

    def _report(self, name: str, robot: FakeRobot, state: PacketState) -> None:
        assert robot.script is not None
        packet = robot.script.packets[robot.packet]
        if state is PacketState.FINISHED and packet.id == self.unbelieved:
            return
        report = PacketReport(
            script_id=robot.script.id,
            packet_id=packet.id,
            state=state,
            at_s=self.clock.now_s(),
            events=("goal",) if state is PacketState.FINISHED else (),
            results=self.brings.get(packet.tag, ()) if state is PacketState.FINISHED else (),
        )
        message = self._message(name, Performative.INFORM, report)
        late_s = self.faults.late_s.get((name, packet.tag), 0.0) if state is PacketState.FINISHED else 0.0
        if late_s:
            self._held_back.append((self.clock.now_s() + late_s, message))
        else:
            self._say(message)

    def _end(self, name: str, robot: FakeRobot, state: ScriptState) -> None:
        assert robot.script is not None
        robot.state = state
        failed = state is ScriptState.FAILED
        report = ScriptReport(
            script_id=robot.script.id,
            state=state,
            at_s=self.clock.now_s(),
            category=FailureCategory.ROBOT if failed else None,
            detail=self.faults.says if failed else "",
            perceived=() if state is ScriptState.FINISHED else self._perceived(name, robot),
        )
        self._say(self._message(name, Performative.FAILURE if failed else Performative.INFORM, report))

    def _say(self, message: Message) -> None:
        for _ in range(2 if self.faults.repeats else 1):
            self._far.send(message)

        if self.patient:
            self._unconfirmed[message.id] = (time.monotonic() + SAID_AGAIN_S, message)

    def _say_again(self) -> None:
        for due_at, message in list(self._unconfirmed.values()):
            if time.monotonic() >= due_at:
                self._say(message)

    def _message(
        self, name: str, performative: Performative, body: Body, in_reply_to: str | None = None
    ) -> Message:
        return Message(
            performative=performative,
            sender=name,
            receiver="service",
            sent_at_s=self.clock.now_s(),
            in_reply_to=in_reply_to,
            body=body,
        )


def _may_be_otherwise(answer: Message) -> bool:
    """True for an answer that depends on whether the mind is there: repeated, the request gets another one."""
    body = answer.body
    return isinstance(body, MindTransferReport) or (
        isinstance(body, MindOrderReport) and body.reason == NO_MIND
    )
