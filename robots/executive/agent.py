"""The behavioural agent: the software of one robot. Call `tick()` at the control rate, 20 Hz."""

from collections import OrderedDict
from dataclasses import replace
from math import hypot

from robots.clock import Clock
from robots.conditions.facts import REPORTED
from robots.contract.known_scripts import ENDED, StaleScripts, remember, supersedes
from robots.contract.mailbox import Mailbox
from robots.contract.memory import SocialMemory
from robots.contract.telemetry_rate import TELEMETRY_S, is_due
from robots.errors import RepertoireError, SensorFault
from robots.executive.breakpoints import Halt
from robots.executive.control_loop import LOOPS, ControlLoop
from robots.executive.delegation import DelegatedLeg, is_awarded
from robots.executive.deliberation import Deliberation
from robots.executive.discoveries import Discoveries
from robots.executive.embodiment import Answer, Embodiment, EmbodimentMemory
from robots.executive.executive import Executive
from robots.executive.hand_over import NEAR_M, MindDocument, pieces_of
from robots.executive.leg_cost import offer
from robots.executive.memory import AgentMind, BodyMemory, RobotMemory
from robots.executive.offer import Declined, Offer
from robots.executive.own_packets import why_held
from robots.executive.society import Clearing, Society
from robots.executive.telemetry import telemetry
from robots.executive.teleoperation import Teleoperation
from robots.executive.trace import Trace
from robots.executive.upkeep import Upkeep
from robots.link import Link
from robots.perception.fusion import Perception
from robots.perception.health import Defect, SensorHealth
from robots.perception.percepts import GRIP, NOTHING, Percepts
from robots.perception.sensing import Mode, SensorAction, SensoryController
from robots.physical.body import Body, Pose, Sensor
from robots.physical.energy import SensingMeter, load_powers
from robots.physical.profile import RobotProfile
from robots.reactive.synthesis import Motion
from robots.repertoire import Repertoire, load_repertoire, load_self_level
from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    Clearance,
    Control,
    ControlVerb,
    DelegationReport,
    Factsheet,
    Message,
    MindOrder,
    MindOrderReport,
    MindQuery,
    MindReport,
    MindVerb,
    PacketReport,
    PacketState,
    PacketTunings,
    Performative,
    Program,
    Retune,
    RuleSet,
    RulesReport,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    SetPoint,
    SetPointRefusal,
    SpeechReport,
    StatusQuery,
    Telemetry,
    TraceQuery,
    TuningReport,
)

FAULT_S = 5.0
"""The robot stands still for this long while an essential sensor fails; then it gives up its script."""
AT_REST = (MindOrder, MindQuery, StatusQuery, TraceQuery)
"""What is handled while the mind rests; other messages wait until it goes on."""
NOT_BEGUN = (PacketState.WAITING, PacketState.INITIALIZING)
ITS_JAWS = tuple(SensorAction(sensor=sensor) for sensor in sorted(GRIP))
"""What a robot senses while another program has its mind: no mind moves into a body that holds something."""
READ_ONCE = tuple(SensorAction(sensor=sensor, mode=Mode.ONE_SHOT) for sensor in sorted(REPORTED))


class BehaviouralAgent:
    """Receives scripts, senses, runs the executive, commands the body, reports."""

    def __init__(
        self,
        *,
        profile: RobotProfile,
        body: Body,
        link: Link,
        clock: Clock,
        repertoire: Repertoire | None = None,
        memory: RobotMemory | None = None,
        factsheet: Factsheet | None = None,
        deliberation: Deliberation | None = None,
        society: Society | None = None,
        program: Program = Program.OWN,
    ) -> None:
        """
        :param deliberation: the robot's own rules; None: it has none.
        :param memory: the state saved before a power failure, or the mind of a robot with another body; None for a
            robot that starts again.
        :param factsheet: what the robot tells of itself when it starts, and once it has changed; None: nothing.
        :param society: the robot's social level; None: it does not speak with other robots.
        :param program: which of the programs that may have the robot's mind runs this.
        """
        self._announced: Factsheet | None = None
        self._program = program
        self._document: str | None = None
        """The mind as it is handed over, while it rests for that."""
        self._society = society
        self.profile = profile
        self._body = body
        self._clock = clock
        self._mailbox = Mailbox(profile.name, link, round_trip_s=profile.round_trip_s)
        self._perception = Perception(profile)
        self._repertoire = repertoire if repertoire is not None else load_repertoire()
        self._tuning_version = 0
        self._tuning = PacketTunings()
        self._executive = Executive(profile, self._repertoire)
        self._executive.delegates = society is not None
        self._deliberation = deliberation
        self._discoveries = Discoveries(profile)
        self._upkeep = Upkeep(profile, load_self_level())
        self._teleoperation = Teleoperation(profile)
        self._loop: ControlLoop = LOOPS[profile.architecture](self._executive)
        self._sensory = SensoryController(body)
        self._health = SensorHealth(profile.whisker_least_m)
        self._meter = SensingMeter(load_powers())
        self._verdicts: OrderedDict[str, str | None] = OrderedDict()
        """Script id to the reason why it was refused, None if it was accepted; the newest last."""
        self._stale = StaleScripts()
        self._percepts: Percepts | None = None
        self._deferred: list[Message] = []
        self._embodiment = Embodiment()
        self._has_stood = False
        self._withheld: list[Message] = []
        """Messages that have come while the mind rests."""
        self._held_back: list[Message] = []
        """Scripts that arrived while the robot does another one's leg, which they do not end."""
        self._last_s: float | None = None
        self._fault = ""
        self._fault_s = 0.0
        self._telemetry_s = float("-inf")
        self._sent_telemetry: Telemetry | None = None
        self._touched: bool | None = None
        """Since the last telemetry; None if the bumper has not read since."""
        if memory is not None:
            self._recall_mind(memory.mind)
            if memory.body is not None:
                self._recall_body(memory.body)
        self._unannounced: Factsheet | None = None
        if factsheet is not None:
            self.announce(factsheet)

    def break_at(self, rules: frozenset[str]) -> None:
        """Hold back what these rules, "guard:3" and the like, commit to until the next tick; for simulations."""
        if self._deliberation is not None:
            self._deliberation.break_at(rules)

    @property
    def is_held(self) -> bool:
        """True if a breakpoint was met in the last tick."""
        return self._deliberation is not None and bool(self._deliberation.held)

    def halt_report(self) -> Halt:
        """Where its mind stands after the last tick."""
        mind = self._deliberation
        return Halt(
            robot=self.profile.name,
            at_s=self._clock.now_s(),
            firings=() if mind is None else mind.held,
            agents=() if mind is None else mind.told(),
        )

    def memory(self, *, is_whole: bool = False) -> RobotMemory:
        """The state to restore after a power failure; to be called between two ticks. A mind at rest is kept whole.

        :param is_whole: with commitments and conversations, for a restart of the same robot's software.
        """
        is_whole = is_whole or self._embodiment.rests
        return RobotMemory(mind=self._mind_memory(is_whole=is_whole), body=self._body_memory())

    @property
    def embodiment(self) -> EmbodimentMemory:
        """Whether the mind acts here, rests, or is handed over."""
        return self._embodiment.memory()

    @property
    def fault(self) -> str:
        """The sensor fault of the last tick; empty if there was none."""
        return self._fault

    def stand_by(self) -> None:
        """Be silent until a mind is handed over: another program has the robot's mind."""
        self._embodiment.recall(EmbodimentMemory(is_handed_over=True))

    @property
    def pose(self) -> Pose:
        """Where it believes to stand (world frame)."""
        return self._perception.localiser.pose

    @property
    def held(self) -> str | None:
        """What its jaws held when they were sensed last."""
        return self._perception.held

    def hand_over(self) -> MindDocument:
        """The mind as a document, for another program; to be called while it rests."""
        mind = self._mind_memory(is_whole=True)
        answers = tuple(map(_without_document, mind.mailbox.answers))
        mailbox = mind.mailbox.model_copy(update={"answers": answers})
        return MindDocument(
            robot=self.profile.name,
            fence=self._embodiment.fence,
            at_s=self._clock.now_s(),
            stood=self.pose,
            mind=mind.model_copy(update={"mailbox": mailbox}),
        )

    def take_over(self, document: MindDocument, *, body: BodyMemory | None) -> str | None:
        """Take the mind up, at rest and silent until it is told to go on; or return the reason why this robot cannot
        carry it on. To be called before the first tick.

        :param body: of the body that it goes on in; None: of one that stands where the former one stood.
        """
        if (reason := self._why_unfit(document, None if body is None else body.estimate.pose)) is not None:
            return reason
        if body is not None:
            self._recall_body(body)
        resting = EmbodimentMemory(fence=document.fence, rests=True, is_handed_over=True)
        self._recall_mind(document.mind.model_copy(update={"embodiment": resting}))
        return None

    def _why_unfit(self, document: MindDocument, stands: Pose | None) -> str | None:
        me = self.profile.name
        mind = document.mind
        if document.robot != me:
            return f"it is the mind of {document.robot}, this is {me}"
        return (
            self._why_script_unfit(document, stands)
            or self._why_rules_unfit(mind)
            or self._why_speech_unfit(mind)
        )

    def _why_script_unfit(self, document: MindDocument, stands: Pose | None) -> str | None:
        """Why this robot cannot carry the script on from where it is."""
        me = self.profile.name
        mind = document.mind
        try:
            repertoire = self._repertoire.tuned(mind.tuning)
        except RepertoireError as error:
            return f"its tuning does not fit {me}: {error}"
        kept = mind.executive.script
        if kept is None or mind.executive.states.get(kept.script.id) in (None, *ENDED):
            return None
        unable = Executive(self.profile, repertoire).why_unable(kept.script)
        stood = document.stood
        has_begun = any(one.state not in NOT_BEGUN for one in kept.packets)
        if unable is not None or not has_begun or stands is None or stood is None:
            return unable
        far_m = hypot(stands.x_m - stood.x_m, stands.y_m - stood.y_m)
        if far_m <= NEAR_M:
            return None
        return (
            f"{me} stands {far_m:.1f} m from ({stood.x_m:.1f}, {stood.y_m:.1f}), where script {kept.script.id} has "
            "come to; drive it there first"
        )

    def _why_rules_unfit(self, mind: AgentMind) -> str | None:
        """Why this robot cannot follow the mind's rules; if it can, it does from now on."""
        rules = mind.rules
        if rules is None or not rules.files:
            return None
        if self._deliberation is None:
            return f"{self.profile.name} has no deliberative level, and the mind follows {', '.join(rules.files)}"
        return self._deliberation.follow(rules.files, rules.version, self._clock.now_s(), rules.role)

    def _why_speech_unfit(self, mind: AgentMind) -> str | None:
        if self._society is not None or mind.social == SocialMemory():
            return None
        return f"{self.profile.name} has no social level, and the mind has conversations"

    def _mind_memory(self, *, is_whole: bool = False) -> AgentMind:
        """:param is_whole: with commitments and conversations, which do not outlive a power failure."""
        society = self._society
        social = SocialMemory() if society is None else society.hand_over() if is_whole else society.memory()
        mind = self._deliberation
        rules = None if mind is None else mind.hand_over() if is_whole else mind.memory()
        return AgentMind(
            mailbox=self._mailbox.memory(),
            executive=self._executive.hand_over() if is_whole else self._executive.memory(),
            upkeep=self._upkeep.state.saved(),
            verdicts=dict(self._verdicts),
            stale=self._stale.memory(),
            tuning_version=self._tuning_version,
            tuning=self._tuning,
            social=social,
            rules=rules,
            embodiment=self._embodiment.memory(),
        )

    def _body_memory(self) -> BodyMemory:
        return BodyMemory(
            estimate=self._perception.localiser.memory(),
            held=self._perception.held,
            sensing_used_j=self._meter.used_j,
            sensing_saved_j=self._meter.saved_j,
            announced=self._announced,
        )

    def _recall_mind(self, mind: AgentMind) -> None:
        now_s = self._clock.now_s()
        self._mailbox.recall(mind.mailbox, now_s)
        self._verdicts = OrderedDict(mind.verdicts)
        self._stale.recall(mind.stale)
        self._tuning_version = mind.tuning_version
        self._tuning = mind.tuning
        self._executive.retune(self._repertoire.tuned(mind.tuning))
        self._executive.recall(mind.executive, now_s)
        self._upkeep.state = mind.upkeep.saved()
        self._embodiment.recall(mind.embodiment)
        self._has_stood = mind.embodiment.rests
        if self._society is not None:
            self._society.recall(mind.social)
        if self._deliberation is not None and mind.rules is not None:
            self._deliberation.recall(mind.rules, now_s)

    def _recall_body(self, body: BodyMemory) -> None:
        self._perception.localiser.recall(body.estimate)
        self._perception.held = body.held
        self._announced = body.announced
        self._meter = SensingMeter(load_powers(), used_j=body.sensing_used_j, saved_j=body.sensing_saved_j)

    def announce(self, factsheet: Factsheet) -> None:
        """Tell what the robot is from now on, unless it was told already."""
        said = self._announced
        is_said = said is not None and said.content == factsheet.content
        self._unannounced = None if is_said else factsheet

    @property
    def trace(self) -> Trace:
        """The utilitors and resultants of the last ticks, for debugging."""
        return self._executive.trace

    def tick(self) -> None:
        """One control cycle: sense, handle messages, act, report."""
        now_s = self._clock.now_s()
        step_s = now_s - self._last_s if self._last_s is not None else 0.0
        self._last_s = now_s
        self._meter.count(self._sensory.running, step_s)
        percepts = self._sense(now_s, step_s)
        if self._embodiment.is_mute:
            self._stay_mute(now_s)
            return
        one_shots = self._handle_messages(now_s)
        self._settle_rest(percepts, now_s)
        if self._embodiment.stands(now_s):
            self._has_stood = True
            self._command(Motion())
            self._sensory.run(one_shots, self._executive.wanted)
        else:
            self._act(percepts, step_s, now_s, one_shots)
        self._announce(now_s)
        self._send_reports(now_s)
        self._send_telemetry(now_s)

    def _stay_mute(self, now_s: float) -> None:
        """Stand, and hear nothing but orders to the mind: another program speaks for the robot."""
        self._has_stood = True
        self._command(Motion())
        self._sensory.run(ITS_JAWS, ())
        for message in self._mailbox.collect_orders_to_mind():
            if isinstance(message.body, MindOrder) and message.body.to is self._program:
                self._handle(message, now_s)

    def _act(
        self, percepts: Percepts | None, step_s: float, now_s: float, one_shots: tuple[SensorAction, ...]
    ) -> None:
        """Speak, decide and move; a mind that rests does not."""
        if self._has_stood:
            self._has_stood = False
            self._executive.go_on()
        self._speak()
        self._take_held_back(now_s)
        self._start_upkeep(percepts)
        if self._deliberation is not None:
            self._executive.left_to_rules = self._deliberation.takes_over
            self._deliberation.cycle(self._executive, percepts, now_s)
        for found in self._discoveries.new(percepts):
            self._mailbox.report(Performative.INFORM, found, now_s)
        if percepts is not None:
            percepts.drive_command = self._teleoperation.command(now_s)
        self._command(self._loop.execute(percepts, step_s) if percepts else Motion())
        self._sensory.run((*self._beside(), *one_shots), self._executive.wanted)

    def _settle_rest(self, percepts: Percepts | None, now_s: float) -> None:
        """Let the mind come to rest if that was asked for and this is a safe point."""
        driver = self._teleoperation.driver
        held = None if percepts is None else why_held(self.profile, percepts, may_carry=True)
        unsafe = f"{driver} drives it" if driver is not None else held or self._executive.unsafe
        if not unsafe and self._embodiment.is_to_be_handed_over and self._executive.delegated is not None:
            unsafe = "a leg of its script is put to other robots"
        odometry = None if percepts is None else percepts.odometry
        if (settled := self._embodiment.settle(odometry, now_s, unsafe=unsafe)) is not None:
            self._answer_order(settled, now_s)

    def _answer_order(self, settled: Answer, now_s: float) -> None:
        report = settled.report
        if settled.piece is not None and report.verb is MindVerb.REST:
            if self._document is None:
                self._document = self.hand_over().model_dump_json()
            pieces = pieces_of(self._document)
            wanted = pieces[min(settled.piece, len(pieces) - 1)]
            report = report.model_copy(update={"mind": wanted})
        elif not self._embodiment.rests:
            self._document = None
        self._mailbox.answer(settled.request, settled.performative, report, now_s)

    def _beside(self) -> tuple[SensorAction, ...]:
        """The sensor actions to run until the next tick, with those that its rules and questions to it need."""
        beside = self._loop.beside
        needed = NOTHING if self._deliberation is None else self._deliberation.needs
        if self._society is not None:
            needed = needed | (self._society.needs & self.profile.sensors)
        further = needed - {action.sensor for action in beside}
        if not further:
            return beside
        return (*beside, *(SensorAction(sensor=sensor) for sensor in sorted(further)))

    def _sense(self, now_s: float, step_s: float) -> Percepts | None:
        """The percepts of this tick; None during a sensor fault."""
        try:
            odometry = self._body.get_position()
            readings = self._health.inspect(self._body.sense(), odometry)
            sensed = self._perception.perceive(
                self._sensory.collect(readings),
                odometry,
                now_s,
                battery=readings.battery,
                charging=readings.charging,
                measured=readings.measured,
                degraded=self._health.degraded,
            )
        except (SensorFault, OSError, ValueError) as fault:
            self._fault = str(fault)
            self._fault_s += step_s
            if self._fault_s > FAULT_S:
                self._executive.fault(f"for {FAULT_S:.0f} s {fault}", self._percepts, now_s)
            return None
        self._fault = ""
        # NOTE: not reset to 0: a sensor that fails every other tick must fail the script in the end.
        self._fault_s = max(0.0, self._fault_s - step_s)
        self._percepts = self._loop.update(sensed)
        return self._percepts

    def _send_telemetry(self, now_s: float) -> None:
        """Send telemetry, less often while nothing happens; during a sensor fault, the last percepts with the fault."""
        known = self._percepts
        touches = None if known is None else known.data.values.get(Sensor.BUMPER)
        if touches is not None:
            self._touched = bool(touches or self._touched)
        if known is None or now_s - self._telemetry_s < TELEMETRY_S - 1e-6:
            return
        self._telemetry_s = now_s
        if self._fault:
            fault = Defect(sensor="", words=self._fault)
            known = replace(known, time_s=now_s, degraded=(*known.degraded, fault))
        driver = self._teleoperation.driver
        body = telemetry(
            known,
            self._executive,
            self._meter,
            self._sensory.running,
            driven_by=driver,
            touched=self._touched,
        )
        if is_due(body, self._sent_telemetry):
            self._sent_telemetry = body
            self._touched = None
            self._mailbox.post(body, now_s)

    def _handle_messages(self, now_s: float) -> tuple[SensorAction, ...]:
        """Handle the new messages. If the robot senses nothing, those whose answer reports percepts are handled in the
        next tick, after the one-shot sensor actions that are returned; of a mind that rests, most once it goes on.
        """
        deferred = self._deferred
        self._deferred = []
        for message in deferred:
            self._handle(message, now_s)
        withheld = self._withheld
        self._withheld = []
        for message in (*withheld, *self._mailbox.collect(now_s)):
            if self._embodiment.stands(now_s) and not isinstance(message.body, AT_REST):
                if not isinstance(message.body, SetPoint):
                    self._withheld.append(message)
                continue
            blind = self._percepts is None or not self._percepts.data.holds(REPORTED)
            if blind and self._needs_percepts(message):
                self._deferred.append(message)
            else:
                self._handle(message, now_s)
        return READ_ONCE if self._deferred else ()

    def _speak(self) -> None:
        """Let the social level hear what other robots have said, and speak."""
        arrived = self._mailbox.speech()
        if self._society is not None:
            self._society.step(arrived, self)

    def clear_by(self, script_id: str, action: str, robot: str) -> Clearing:
        """See `robots.executive.society.Situated`, as for the next ones."""
        return self._executive.clear_by(script_id, action, robot)

    def offer(self, leg: BehaviourScript, *, promised_s: float) -> Offer | Declined:
        return offer(
            leg,
            profile=self.profile,
            executive=self._executive,
            percepts=self._percepts,
            fault=self._fault,
            driver=self._teleoperation.driver,
            promised_s=promised_s,
        )

    def state_of(self, script_id: str) -> ScriptState | None:
        return self._executive.state_of(script_id)

    def perform(self, script: BehaviourScript) -> str | None:
        me = self.profile.name
        current = self._executive.script
        if current is not None and (not current.is_own or is_awarded(current)):
            return f"{me} is busy with script {current.id}"
        if current is not None and current.is_for_person and is_awarded(script):
            return f"{me} is busy with what a person has asked for: {current.id}"
        if (driver := self._teleoperation.driver) is not None:
            return f"{driver} drives {me}"
        if self._fault:
            return f"{me}: {self._fault}"
        percepts = self._percepts
        if percepts is not None and (held := why_held(self.profile, percepts, may_carry=True)) is not None:
            return held
        reason = self._low_battery() or self._executive.why_unable(script)
        return reason or self._executive.accept(script)

    def halt(self, prefix: str) -> str | None:
        script = self._executive.script
        if script is None or not script.id.startswith(prefix):
            doing = "stands" if script is None else f"is at script {script.id}"
            return f"{self.profile.name} {doing}: nobody has asked for that"
        self.withdraw(script.id)
        return None

    @property
    def delegated(self) -> DelegatedLeg | None:
        return self._executive.delegated

    def make_way(self, own: BehaviourScript) -> str | None:
        return self._executive.make_way(own)

    def end_delegated(self, robot: str) -> None:
        self._executive.end_delegated(robot, self._percepts, self._clock.now_s())

    def take_back(self, reason: str) -> None:
        self._executive.take_back(reason, self._percepts, self._clock.now_s())

    def packets_ended(self, script_id: str) -> int | None:
        return self._executive.packets_ended(script_id)

    def moves_jaws(self, packet: BehaviourPacket) -> bool:
        return self._executive.moves_jaws(packet)

    @property
    def service_heard_s(self) -> float:
        return self._mailbox.heard_s

    @property
    def service_answers_s(self) -> float:
        return self._mailbox.answer_s

    def withdraw(self, script_id: str) -> None:
        self._executive.withdraw_own(script_id, self._percepts, self._clock.now_s())

    def why_ended(self, script_id: str) -> str:
        return self._executive.why_ended(script_id)

    @property
    def percepts(self) -> Percepts | None:
        return self._percepts

    @property
    def activity(self) -> tuple[str, ...]:
        run = self._executive.current
        state = self._executive.packet_state
        if run is None or state is None:
            return ()
        return run.packet.tag, state.value, self._executive.script_id or ""

    @property
    def beliefs(self) -> tuple[str, ...]:
        told = () if self._deliberation is None else self._deliberation.told()
        return tuple(one.term if one.value else f"not({one.term})" for agent in told for one in agent.beliefs)

    def send(self, message: Message) -> None:
        self._mailbox.pass_on(message)

    def tell_service(self, report: SpeechReport | DelegationReport) -> None:
        self._mailbox.report(Performative.INFORM, report, report.at_s)

    def _needs_percepts(self, message: Message) -> bool:
        """True if handling the message makes a report with percepts."""
        if isinstance(message.body, ScriptRequest):
            return supersedes(message.body.script, self._executive.script)
        return isinstance(message.body, Control | StatusQuery)

    def _command(self, motion: Motion) -> None:
        self._body.set_velocity(motion.linear_m_s, motion.angular_rad_s)
        if motion.close_gripper is not None:
            self._body.set_gripper(closed=motion.close_gripper)

    def _handle(self, message: Message, now_s: float) -> None:
        match message.body:
            case ScriptRequest(script=script):
                self._take_up(message, script, now_s)
            case Control(script_id=script_id) as order:
                refusal = self._control(order, now_s)
                self._mailbox.agree_or_refuse(message, script_id, refusal, now_s)
            case Clearance(script_id=script_id, ended=ended):
                refusal = self._executive.clear(script_id, ended)
                self._mailbox.agree_or_refuse(message, script_id, refusal, now_s)
            case StatusQuery(script_id=script_id):
                status = self._executive.status(script_id, self._percepts, now_s)
                self._mailbox.answer(message, Performative.INFORM, status, now_s)
            case TraceQuery(seconds=seconds):
                run = self._executive.current
                conditions = () if run is None else tuple(run.traced_conditions())
                self._mailbox.tell(message, self.trace.report(now_s, seconds, conditions), now_s)
            case MindOrder(to=to) as order:
                if to not in (None, self._program):
                    return  # another program answers
                if (settled := self._embodiment.follow(message, order, now_s)) is not None:
                    self._answer_order(settled, now_s)
            case MindQuery():
                self._mailbox.tell(message, self._mind(now_s), now_s)
            case Retune() as wanted:
                self._retune(message, wanted, now_s)
            case RuleSet() as rules:
                self._follow(message, rules, now_s)
            case SetPoint() as set_point:
                self._drive(message, set_point, now_s)

    def _take_up(self, message: Message, script: BehaviourScript, now_s: float) -> None:
        """Accept a script or refuse it; one that finds the robot at another one's leg waits for its end."""
        if script.id not in self._verdicts and is_awarded(self._executive.script):
            self._held_back.append(message)
            return
        if script.id not in self._verdicts:
            remember(self._verdicts, script.id, self._accept(script, now_s))
        self._mailbox.agree_or_refuse(message, script.id, self._verdicts[script.id], now_s)

    def _take_held_back(self, now_s: float) -> None:
        """Take up what waits for the end of another robot's leg. After a power failure the service says it again."""
        if self._held_back and not is_awarded(self._executive.script):
            held_back = self._held_back
            self._held_back = []
            for message in held_back:
                self._handle(message, now_s)

    def _accept(self, script: BehaviourScript, now_s: float) -> str | None:
        """Accept a script and cancel the one it supersedes, or return the reason against it."""
        if (stale := self._stale.refusal(script)) is not None:
            return stale
        current = self._executive.script
        if current is not None and supersedes(script, current):
            reason = f"superseded by revision {script.revision} of its mission"
            self._executive.control(current.id, ControlVerb.CANCEL, self._percepts, now_s, reason)
        return self._low_battery() or self._executive.accept(script)

    def _control(self, order: Control, now_s: float) -> str | None:
        """Follow an order on a script, or return the reason against it. A cancel may arrive before its script."""
        script_id = order.script_id
        verb = order.verb
        is_early = verb is ControlVerb.CANCEL and script_id not in self._verdicts
        if is_early and self._executive.cancel_before_arrival(script_id, self._percepts, now_s):
            self._stale.cancel(script_id)
            return None
        return self._executive.control(script_id, verb, self._percepts, now_s, number=order.number)

    def _retune(self, message: Message, wanted: Retune, now_s: float) -> None:
        """Tune the later packets. An older version than the current one changes nothing."""
        performative = Performative.AGREE
        reason = ""
        if wanted.version >= self._tuning_version:
            try:
                self._executive.retune(self._repertoire.tuned(wanted.tuning))
                self._tuning_version = wanted.version
                self._tuning = wanted.tuning
            except RepertoireError as error:
                performative = Performative.REFUSE
                reason = str(error)
        self._mailbox.answer(
            message, performative, TuningReport(version=wanted.version, reason=reason), now_s
        )

    def _follow(self, message: Message, wanted: RuleSet, now_s: float) -> None:
        """Follow other rules. An older version than the current one changes nothing."""
        mind = self._deliberation
        reason: str | None = f"{self.profile.name} has no deliberative level"
        digests: dict[str, str] = {}
        role = ""
        if mind is not None:
            is_new = wanted.version >= mind.version
            reason = mind.follow(wanted.files, wanted.version, now_s, wanted.role) if is_new else None
            digests = dict(mind.digests)
            role = mind.role
        performative = Performative.AGREE if reason is None else Performative.REFUSE
        report = RulesReport(version=wanted.version, reason=reason or "", digests=digests, role=role)
        self._mailbox.answer(message, performative, report, now_s)

    def _mind(self, now_s: float) -> MindReport:
        mind = self._deliberation
        return MindReport(
            at_s=now_s,
            version=0 if mind is None else mind.version,
            digests={} if mind is None else dict(mind.digests),
            agents=() if mind is None else mind.told(),
            conversations=() if self._society is None else self._society.told(),
            heard=() if mind is None else mind.told_messages,
        )

    def _drive(self, message: Message, wanted: SetPoint, now_s: float) -> None:
        """Drive by an operator's set-point, or refuse it. One that arrives too late is ignored."""
        driving = self._teleoperation
        if driving.is_late(message.sent_at_s, wanted, now_s):
            return
        reason = driving.follow(wanted, self._executive, now_s, low_battery=self._low_battery())
        if reason is not None:
            refusal = SetPointRefusal(driver=wanted.driver, reason=reason)
            self._mailbox.tell(message, refusal, now_s, Performative.REFUSE)

    def _start_upkeep(self, percepts: Percepts | None) -> None:
        """Without a script, start one of the robot's own if it needs one, unless its rules see to that."""
        if percepts is None or self._executive.active:
            return
        if self._deliberation is not None and self._deliberation.charges:
            return
        own = self._upkeep.script(percepts)
        if own is not None:
            self._executive.begin_own(own, percepts, percepts.time_s)

    def _low_battery(self) -> str | None:
        """Why the battery is too low for a script; None if it is not."""
        run = self._executive.current
        return self._upkeep.refusal(self._percepts, current_tag=run.packet.tag if run else None)

    def _announce(self, now_s: float) -> None:
        """Send the factsheet once, unless the last one said the same."""
        if self._unannounced is None:
            return
        number = 0 if self._announced is None else self._announced.number + 1
        self._announced = self._unannounced.model_copy(update={"number": number})
        self._unannounced = None
        self._mailbox.report(Performative.INFORM, self._announced, now_s)

    def _owe_clearance(self, report: PacketReport) -> None:
        """Have those told of a packet's end who wait for it."""
        packet = self._executive.packet(report.script_id, report.packet_id)
        if self._society is not None and packet is not None and packet.tells:
            self._society.packet_ended(packet)

    def _send_reports(self, now_s: float) -> None:
        if (ended := self._teleoperation.settle(self._executive, self._percepts, now_s)) is not None:
            self._mailbox.report(Performative.INFORM, ended, now_s)
        for report in self._executive.take_reports():
            ended_badly = isinstance(report, ScriptReport) and report.state is not ScriptState.FINISHED
            self._mailbox.report(Performative.FAILURE if ended_badly else Performative.INFORM, report, now_s)
            if isinstance(report, PacketReport) and report.state is PacketState.FINISHED:
                self._owe_clearance(report)
        self._mailbox.resend(now_s)


def _without_document(answer: Message) -> Message:
    """An answer as it is kept: the document that it brought is not part of the next one."""
    if isinstance(answer.body, MindOrderReport) and answer.body.mind is not None:
        return answer.model_copy(update={"body": answer.body.model_copy(update={"mind": None})})
    return answer
