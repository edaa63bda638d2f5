"""The behavioural agent: the software of one robot, driven by calling `tick()` at the control rate, 20 Hz."""

from dataclasses import replace

from robots.clock import Clock
from robots.conditions.facts import REPORTED
from robots.errors import RepertoireError, SensorFault
from robots.executive.actions import Mode, SensorAction
from robots.executive.control_loop import control_loop
from robots.executive.executive import Executive
from robots.executive.known_scripts import KEPT_STATES
from robots.executive.looking import conditions_of
from robots.executive.mailbox import Mailbox
from robots.executive.memory import RobotMemory
from robots.executive.patience import FAULT_S
from robots.executive.stale import StaleScripts, supersedes
from robots.executive.telemetry import telemetry
from robots.executive.teleoperation import Teleoperation
from robots.executive.trace import Trace
from robots.executive.upkeep import Upkeep
from robots.link.channel import Link
from robots.perception.fusion import Perception
from robots.perception.health import SensorHealth
from robots.perception.percepts import Percepts
from robots.perception.sensing import SensoryController
from robots.physical.body import Body
from robots.physical.energy import SensingMeter, load_powers
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.reactive.synthesis import Motion
from robots.repertoire import Repertoire, load_repertoire, load_self_level
from robots.wire import (
    BehaviourScript,
    Clearance,
    Control,
    ControlVerb,
    Message,
    PacketState,
    PacketTunings,
    Performative,
    Retune,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    SetPoint,
    SetPointRefusal,
    StatusQuery,
    TraceQuery,
    TuningReport,
    UpkeepReport,
)

__all__ = ["BeaconSpec", "BehaviouralAgent", "RobotProfile"]

TELEMETRY_S = 0.1
LOOK_ROUND = tuple(SensorAction(sensor=sensor, mode=Mode.ONE_SHOT) for sensor in sorted(REPORTED))


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
    ) -> None:
        """:param memory: what it kept before its power failed; None for a robot that is set out."""
        self.profile = profile
        self._body = body
        self._clock = clock
        self._mailbox = Mailbox(profile.name, link, round_trip_s=profile.round_trip_s)
        self._perception = Perception(profile)
        self._repertoire = repertoire if repertoire is not None else load_repertoire()
        self._tuning_version, self._tuning = 0, PacketTunings()
        self._executive = Executive(profile, self._repertoire)
        self._upkeep = Upkeep(profile, load_self_level())
        self._teleoperation = Teleoperation(profile)
        self._loop = control_loop(profile.architecture, self._executive)
        self._sensory = SensoryController(body)
        self._health = SensorHealth(profile.whisker_least_m)
        self._meter = SensingMeter(load_powers())
        self._verdicts: dict[str, str | None] = {}
        self._stale = StaleScripts()
        self._percepts: Percepts | None = None
        self._unanswered: list[Message] = []
        self._last_s: float | None = None
        self._fault, self._fault_s = "", 0.0
        self._told_s = float("-inf")
        if memory is not None:
            self._recall(memory)

    def memory(self) -> RobotMemory:
        """What it must not forget; whoever keeps it does so between two ticks."""
        return RobotMemory(
            mailbox=self._mailbox.memory(),
            executive=self._executive.memory(),
            verdicts=dict(self._verdicts),
            stale=self._stale.memory(),
            tuning_version=self._tuning_version,
            tuning=self._tuning,
            estimate=self._perception.localiser.memory(),
            upkeep=self._upkeep.memory(),
            sensing_used_j=self._meter.used_j,
            sensing_saved_j=self._meter.saved_j,
        )

    def _recall(self, memory: RobotMemory) -> None:
        now_s = self._clock.now_s()
        self._mailbox.recall(memory.mailbox, now_s)
        self._verdicts = dict(memory.verdicts)
        self._stale.recall(memory.stale)
        self._tuning_version, self._tuning = memory.tuning_version, memory.tuning
        self._executive.retune(self._repertoire.tuned(memory.tuning))
        self._executive.recall(memory.executive, now_s)
        self._perception.localiser.recall(memory.estimate)
        self._upkeep.recall(memory.upkeep)
        self._meter = SensingMeter(
            load_powers(), used_j=memory.sensing_used_j, saved_j=memory.sensing_saved_j
        )

    @property
    def trace(self) -> Trace:
        """What its patterns contributed and what came of it, tick by tick, for debugging."""
        return self._executive.trace

    def tick(self) -> None:
        """One turn: sense, letters in, act, letters out."""
        now_s = self._clock.now_s()
        step_s = now_s - self._last_s if self._last_s is not None else 0.0
        self._last_s = now_s
        self._meter.count(self._sensory.running, step_s)
        percepts = self._sense(now_s, step_s)
        look = self._attend_all(now_s)
        self._look_after_itself(percepts)
        if percepts is not None:
            percepts.wish = self._teleoperation.wish(now_s)
        self._command(self._loop.execute(percepts, step_s) if percepts else Motion())
        self._sensory.run((*self._loop.beside, *look))
        self._report(now_s)
        self._tell(now_s)

    def _sense(self, now_s: float, step_s: float) -> Percepts | None:
        """What is known at this instant; None while a sensor cannot be relied on."""
        try:
            odometry = self._body.get_position()
            readings = self._health.inspect(self._body.sense(), odometry)
            sensed = self._perception.perceive(
                self._sensory.collect(readings),
                odometry,
                now_s,
                battery=readings.battery,
                charging=readings.charging,
                degraded=self._health.degraded,
            )
        except (SensorFault, OSError, ValueError) as fault:
            self._fault, self._fault_s = str(fault), self._fault_s + step_s
            if self._fault_s > FAULT_S:
                self._executive.fault(f"for {FAULT_S:.0f} s {fault}", self._percepts, now_s)
            return None
        # NOTE: not to 0: a sensor that fails every other tick must not go on so for ever.
        self._fault, self._fault_s = "", max(0.0, self._fault_s - step_s)
        self._percepts = self._loop.update(sensed)
        return self._percepts

    def _tell(self, now_s: float) -> None:
        """Telemetry; while a sensor cannot be relied on, of what was known before, and of the fault."""
        known = self._percepts
        if known is None or now_s - self._told_s < TELEMETRY_S - 1e-6:
            return
        self._told_s = now_s
        if self._fault:
            known = replace(known, time_s=now_s, degraded=(*known.degraded, self._fault))
        driver, running = self._teleoperation.driver, self._sensory.running
        told = telemetry(known, self._executive, self._meter, running, driven_by=driver)
        self._mailbox.post(told, now_s)

    def _attend_all(self, now_s: float) -> tuple[SensorAction, ...]:
        """Attend to the letters. Who asks what the robot perceives while it senses nothing is answered a tick later,
        after a look round: the one-shot sensor actions that are returned.
        """
        waiting, self._unanswered = self._unanswered, []
        for message in waiting:
            self._attend(message, now_s)
        for message in self._mailbox.collect():
            blind = self._percepts is None or not self._percepts.data.holds(REPORTED)
            if blind and self._tells_what_it_perceives(message):
                self._unanswered.append(message)
            else:
                self._attend(message, now_s)
        return LOOK_ROUND if self._unanswered else ()

    def _tells_what_it_perceives(self, message: Message) -> bool:
        """True if the answer will be, or will bring about, a report of what it perceives."""
        if isinstance(message.body, ScriptRequest):
            return supersedes(message.body.script, self._executive.script)
        return isinstance(message.body, Control | StatusQuery)

    def _command(self, motion: Motion) -> None:
        self._body.set_velocity(motion.linear_m_s, motion.angular_rad_s)
        if motion.close_gripper is not None:
            self._body.set_gripper(closed=motion.close_gripper)

    def _attend(self, message: Message, now_s: float) -> None:
        match message.body:
            case ScriptRequest(script=script):
                if script.id not in self._verdicts:
                    self._judge(script, now_s)
                self._mailbox.agree_or_refuse(message, script.id, self._verdicts[script.id], now_s)
            case Control(script_id=script_id) as order:
                why_not = self._control(order, now_s)
                self._mailbox.agree_or_refuse(message, script_id, why_not, now_s)
            case Clearance(script_id=script_id, ended=ended):
                why_not = self._executive.clear(script_id, ended)
                self._mailbox.agree_or_refuse(message, script_id, why_not, now_s)
            case StatusQuery(script_id=script_id):
                status = self._executive.status(script_id, self._percepts, now_s)
                self._mailbox.answer(message, Performative.INFORM, status, now_s)
            case TraceQuery(seconds=seconds):
                told = self.trace.report(now_s, seconds, conditions_of(self._executive.current))
                self._mailbox.tell(message, told, now_s)
            case Retune() as wanted:
                self._retune(message, wanted, now_s)
            case SetPoint() as set_point:
                self._drive(message, set_point, now_s)

    def _take_on(self, script: BehaviourScript, now_s: float) -> str | None:
        """Accept a script in place of what it supersedes, or say why not."""
        if (stale := self._stale.refusal(script)) is not None:
            return stale
        under_way = self._executive.script
        if under_way is not None and supersedes(script, under_way):
            why = f"superseded by revision {script.revision} of its mission"
            self._executive.control(under_way.id, ControlVerb.CANCEL, self._percepts, now_s, why)
        return self._too_weak() or self._executive.accept(script)

    def _control(self, order: Control, now_s: float) -> str | None:
        """Follow an order on a script, or say why not. A cancel that overtook its script holds when that comes."""
        script_id, verb = order.script_id, order.verb
        overtook = verb is ControlVerb.CANCEL and script_id not in self._verdicts
        if overtook and self._executive.forgo(script_id, self._percepts, now_s):
            self._stale.cancel(script_id)
            return None
        return self._executive.control(script_id, verb, self._percepts, now_s, number=order.number)

    def _retune(self, message: Message, wanted: Retune, now_s: float) -> None:
        """Tune the packets to come; what is older than what is in use changes nothing."""
        performative, reason = Performative.AGREE, ""
        if wanted.version >= self._tuning_version:
            try:
                self._executive.retune(self._repertoire.tuned(wanted.tuning))
                self._tuning_version, self._tuning = wanted.version, wanted.tuning
            except RepertoireError as error:
                performative, reason = Performative.REFUSE, str(error)
        self._mailbox.answer(
            message, performative, TuningReport(version=wanted.version, reason=reason), now_s
        )

    def _drive(self, message: Message, wanted: SetPoint, now_s: float) -> None:
        """Drive by an operator's set-point, or say why not. One that comes too late to be his wish says nothing."""
        driving = self._teleoperation
        if driving.is_late(message.sent_at_s, wanted, now_s):
            return
        why_not = driving.follow(wanted, self._executive, now_s, too_weak=self._too_weak())
        if why_not is not None:
            refusal = SetPointRefusal(driver=wanted.driver, reason=why_not)
            self._mailbox.tell(message, refusal, now_s, Performative.REFUSE)

    def _look_after_itself(self, percepts: Percepts | None) -> None:
        """With nothing else to do. A need that it cannot see to it reports."""
        if percepts is None or self._executive.active:
            return
        own = self._upkeep.script(percepts)
        why_not = self._executive.accept(own) if own else None
        if own and why_not:
            failed = UpkeepReport(
                tag=own.packets[0].tag, state=PacketState.FAILED, at_s=percepts.time_s, detail=why_not
            )
            self._mailbox.report(Performative.INFORM, failed, percepts.time_s)

    def _judge(self, script: BehaviourScript, now_s: float) -> None:
        """Take a script on or not, once; of the last ones it is remembered which."""
        self._verdicts[script.id] = self._take_on(script, now_s)
        if len(self._verdicts) > KEPT_STATES:
            del self._verdicts[next(iter(self._verdicts))]

    def _too_weak(self) -> str | None:
        run = self._executive.current
        return self._upkeep.refusal(self._percepts, under_way=run.packet.tag if run else None)

    def _report(self, now_s: float) -> None:
        if (gave_way := self._teleoperation.settle(self._executive, self._percepts, now_s)) is not None:
            self._mailbox.report(Performative.INFORM, gave_way, now_s)
        for report in self._executive.take_reports():
            ended_badly = isinstance(report, ScriptReport) and report.state is not ScriptState.FINISHED
            self._mailbox.report(Performative.FAILURE if ended_badly else Performative.INFORM, report, now_s)
        self._mailbox.resend(now_s)
