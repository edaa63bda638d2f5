"""Every event of the log: its type, its subject and its data, as the event stream publishes them.

A class is one type of event, or one for each of the states that the event may bring. All fields but
`subject` are the event's data. Events of goals, plans and missions carry the `state` that their subject is in once the
transaction has committed; where one transaction appends several, the last of them does.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar

from app.domain.lifecycles.dialogue import DialogueState
from app.domain.lifecycles.embodiment import EmbodimentState
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.hold import HoldEnding
from app.domain.lifecycles.mission import ENDED, MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.script import TERMINAL_SCRIPTS
from robots.data import Frozen
from robots.wire import (
    DelegationBid,
    DelegationState,
    FactsheetState,
    FailureCategory,
    PacketState,
    Performative,
    RobotFault,
    ScriptState,
    SymbolicFact,
)


class Event(Frozen):
    """Something that happened to a subject.

    :param subject: the id of the goal, plan, mission, script or hold, or the name of the robot or world.
    """

    TYPE: ClassVar[str] = ""
    STATES: ClassVar[Collection[StrEnum]] = ()
    subject: str

    def __init_subclass__(cls, *, type: str = "", states: Collection[StrEnum] = ()) -> None:
        super().__init_subclass__()
        cls.TYPE = type
        cls.STATES = states

    @property
    def type(self) -> str:
        return self.TYPE.format(self)

    @classmethod
    def types(cls) -> tuple[str, ...]:
        """Every type that an event of this class may have; empty for a base class."""
        if cls.STATES:
            return tuple(sorted(cls.TYPE.replace("{0.state}", state) for state in cls.STATES))
        return (cls.TYPE,) if cls.TYPE else ()


# Goals


class GoalEvent(Event):
    """Something that happened to a goal."""

    state: GoalState


class GoalSubmitted(GoalEvent, type="goal.submitted"):
    """The goal waits to be planned: newly submitted, or again for the given reason (then `actor` is null)."""

    text: str
    actor: str | None = None
    reason: str = ""
    state: GoalState = GoalState.SUBMITTED


class GoalPlanningBegan(GoalEvent, type="goal.planning"):
    """Planning has begun."""

    state: GoalState = GoalState.PLANNING


class GoalBidsCalled(GoalEvent, type="goal.bids_called"):
    """Robots were called for proposals on the legs of the goal's first plan; it is planned once they have answered."""

    robots: tuple[str, ...]
    legs: tuple[str, ...]
    state: GoalState = GoalState.PLANNING


class GoalProgress(GoalEvent, type="goal.progress"):
    """The planner has a better plan or a better lower bound than before; also while a mission's plan is repaired.

    Before planning begins, `waits_for` says what it has to wait for.
    """

    engine: str
    elapsed_s: float
    makespan_s: float | None
    lower_bound_s: float | None
    waits_for: str = ""


class GoalPlanned(GoalEvent, type="goal.planned"):
    """A plan is proposed for the goal and waits for a decision."""

    plan: str
    state: GoalState = GoalState.PLANNED


class GoalWaiting(GoalEvent, type="goal.waiting"):
    """There is no plan yet: the goal waits for running missions, holds or unavailable robots and is then planned again.
    Also sent when the reason changes.
    """

    reason: str
    state: GoalState = GoalState.WAITING


class GoalUnsolvable(GoalEvent, type="goal.unsolvable"):
    """There is no plan for the goal; `status` is the planner's result."""

    reason: str
    status: str
    state: GoalState = GoalState.UNSOLVABLE


class GoalCommitted(GoalEvent, type="goal.committed"):
    """A plan of the goal was approved, and a mission carries it out."""

    plan: str
    mission: str
    state: GoalState = GoalState.COMMITTED


class GoalStopRequested(GoalEvent, type="goal.stop_requested"):
    """An operator has asked to end planning with the best plan so far."""

    actor: str
    state: GoalState = GoalState.PLANNING


class GoalWithdrawn(GoalEvent, type="goal.withdrawn"):
    """The goal is no longer pursued: cancelled, its last plan rejected, or its world no longer runs."""

    reason: str
    actor: str | None = None
    state: GoalState = GoalState.WITHDRAWN


class GoalFinished(GoalEvent, type="goal.finished"):
    """Its mission has ended in the state `outcome`, or has done this goal's part, or nothing was to be done."""

    outcome: MissionState
    reason: str
    state: GoalState = GoalState.FINISHED


class GoalAlternativesSought(GoalEvent, type="goal.alternatives_sought"):
    """An operator has asked for up to `count` plans to choose from, or for `edited`, a plan, with something pinned."""

    actor: str
    count: int
    edited: str | None = None
    state: GoalState = GoalState.PLANNED


class GoalAlternativesFound(GoalEvent, type="goal.alternatives_found"):
    """The search for alternatives has ended; `plans` are open to decision."""

    plans: tuple[str, ...]
    reason: str = ""
    state: GoalState = GoalState.PLANNED


class GoalAlternativesFailed(GoalEvent, type="goal.alternatives_failed"):
    """The search for alternatives found none; `plans` are open to decision as before."""

    plans: tuple[str, ...]
    reason: str
    state: GoalState = GoalState.PLANNED


# Plans


class PlanEvent(Event):
    """Something that happened to a plan."""

    goal: str
    state: PlanState


class PlanProposed(PlanEvent, type="plan.proposed"):
    """A plan was found and waits for a decision."""

    makespan_s: float
    robots: tuple[str, ...]
    state: PlanState = PlanState.PROPOSED


class PlanBidsCalled(PlanEvent, type="plan.bids_called"):
    """An operator has put the plan to these robots, which bid for its parts; the plan keeps its robots."""

    actor: str
    robots: tuple[str, ...]
    state: PlanState = PlanState.PROPOSED


class PlanDecided(PlanEvent, type="plan.{0.state}", states=(PlanState.APPROVED, PlanState.REJECTED)):
    """The plan was approved or rejected. `delegate`: robots in the field may put legs of it to each other."""

    actor: str
    comment: str
    delegate: bool = False


class PlanClosed(PlanEvent, type="plan.{0.state}", states=(PlanState.EXPIRED, PlanState.SUPERSEDED)):
    """The plan is not open to decision any longer: overtaken by the world (expired) or by another plan (superseded)."""

    reason: str
    actor: str | None = None


# Missions


class MissionEvent(Event):
    """Something that happened to a mission."""

    state: MissionState


class MissionPhase(MissionEvent):
    """The mission has entered a phase; while it is paused, the phase it goes on with and `state` is `paused`."""

    reason: str = ""


class MissionPending(MissionPhase, type="mission.pending"):
    """The mission exists, its robots have no scripts yet."""

    goal: str | None = None
    plan: str | None = None
    robots: tuple[str, ...] | None = None


class MissionDispatching(MissionPhase, type="mission.dispatching"):
    """The scripts of the mission's plan are being delivered to its robots."""

    plan: str | None = None
    revision: int | None = None
    robots: tuple[str, ...] | None = None


class MissionRunning(MissionPhase, type="mission.running"):
    """Robots are at work; `started_at_s` is set when the first of them has begun (world's clock)."""

    started_at_s: float | None = None


class MissionPaused(MissionPhase, type="mission.paused"):
    """An operator has paused the mission; its robots stand still."""

    actor: str | None = None
    comment: str | None = None


class MissionUnknown(MissionPhase, type="mission.unknown"):
    """Robots do not answer or report implausibly, so the state of the mission's execution is not known."""


class MissionRecovering(MissionPhase, type="mission.recovering"):
    """Something has gone wrong, or an operator asks: the mission's robots are stopped and its plan is made again."""


MISSION_PHASES: Mapping[MissionState, type[MissionPhase]] = {
    MissionState.PENDING: MissionPending,
    MissionState.DISPATCHING: MissionDispatching,
    MissionState.RUNNING: MissionRunning,
    MissionState.PAUSED: MissionPaused,
    MissionState.UNKNOWN: MissionUnknown,
    MissionState.RECOVERING: MissionRecovering,
}


class MissionEnded(MissionEvent, type="mission.{0.state}", states=ENDED):
    """The mission has ended; `ended_at_s` is when its robots last reported on it (world's clock)."""

    goal: str
    reason: str
    failure: FailureCategory | None
    ended_at_s: float


class MissionResumed(MissionEvent, type="mission.resumed"):
    """An operator has resumed the mission after a pause, or started the search for a repair again."""

    actor: str
    comment: str


class MissionCancelRequested(MissionEvent, type="mission.cancel_requested"):
    """An operator has asked to cancel the mission; it is cancelled once its robots have answered."""

    actor: str
    comment: str


class MissionReplanRequested(MissionEvent, type="mission.replan_requested"):
    """An operator has asked for another plan of the mission; it is made once its robots have stopped."""

    actor: str
    comment: str
    pinned: str
    goals: tuple[str, ...]


class MissionBetterPlanFound(MissionEvent, type="mission.better_plan_found"):
    """Planned again now, the mission would end sooner; it goes on with its present plan."""

    ends_in_s: float | None
    saves_s: float
    robots: tuple[str, ...]


class MissionRecoverySet(MissionEvent, type="mission.recovery_set"):
    """An operator has changed the mission's recovery policy."""

    actor: str
    policy: str


class MissionOverdue(MissionEvent, type="mission.overdue"):
    """The mission's deadline has passed (world's clock); it goes on."""

    deadline_s: float | None


class MissionRobotsAsked(MissionEvent, type="mission.robots_asked"):
    """Robots are asked for the status of their scripts: the expected time is over, or they are silent."""

    reason: str


class MissionRecoveryBegun(MissionEvent, type="mission.recovery_begun"):
    """The search for a repair of the mission's plan has begun, for the `number`-th time."""

    number: int
    failure: str | None
    reason: str


class MissionNoRepair(MissionEvent, type="mission.no_repair"):
    """No repair was found."""

    reason: str


class MissionRepairProposed(MissionEvent, type="mission.repair_proposed"):
    """A repaired plan waits for a decision."""

    plan: str
    measure: str
    reason: str


class MissionRevised(MissionEvent, type="mission.revised"):
    """The mission carries out a repaired plan from now on; its robots get new scripts."""

    plan: str
    revision: int


class MissionStuck(MissionEvent, type="mission.stuck"):
    """No way to go on was found; an operator has to decide."""

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ContradictingReport:
    """What a robot has reported of a packet; without a time it has reported nothing of it.

    :param robot: or the source of what is believed.
    :param holding: what its telemetry showed it to hold; empty if this is no such telemetry.
    :param place: likewise the place at which it stood.
    :param believed: the recorded fact; empty if this is a robot's report or telemetry.
    """

    robot: str
    packet: str
    tag: str
    state: PacketState
    at_s: float | None
    holding: str = ""
    place: str = ""
    believed: str = ""


class ReportsContradict(MissionEvent, type="mission.reports_contradict"):
    """Two robots' `reports`, or one and the record, do not fit together.

    Where the `things` are that they are about is no longer believed.
    """

    reports: tuple[ContradictingReport, ...]
    things: tuple[str, ...]
    detail: str


# Scripts and packets


class ScriptAcknowledged(Event, type="script.acknowledged"):
    """The robot has agreed to carry out the script."""

    robot: str
    reason: str = ""


class ScriptRefused(Event, type="script.refused"):
    """The robot has refused the script."""

    robot: str
    reason: str


class ScriptStatus(Event, type="script.status"):
    """The robot has answered a status query for the script; `packet` is its current one."""

    robot: str
    state: ScriptState | None
    packet: str | None
    detail: str


class ScriptReported(Event, type="script.{0.state}", states=TERMINAL_SCRIPTS):
    """The robot has reported the script's end (world's clock)."""

    robot: str
    mission: str
    state: ScriptState
    at_s: float
    detail: str


class ScriptCleared(Event, type="script.cleared"):
    """The robot gets clearance: actions of other robots, which its packets wait for, have `ended`."""

    robot: str
    ended: tuple[str, ...]


class ScriptAbandoned(Event, type="script.abandoned"):
    """The script's robot was declared lost; its end is not waited for."""

    robot: str


class ControlRefused(Event, type="control.refused"):
    """The robot has refused an order to cancel, pause or resume the script."""

    robot: str
    control: str
    reason: str


class ClearanceRefused(Event, type="clearance.refused"):
    """The robot has refused a clearance for the script."""

    robot: str
    clearance: str
    reason: str


class PacketReported(Event, type="packet.{0.state}", states=tuple(PacketState)):
    """A robot has reported the state of a packet of the mission (world's clock), and the packet's own `events`."""

    robot: str
    packet: str
    state: PacketState
    at_s: float
    events: tuple[str, ...]
    detail: str


class LegDelegated(Event, type="leg.{0.state}", states=tuple(DelegationState)):
    """A robot that could not do `packets` of its script has put them to others while the service was out of reach: what
    has become of it (world's clock). `to`: who was awarded them, empty if nobody; `bids`: of the last call.
    """

    robot: str
    to: str
    state: DelegationState
    packets: tuple[str, ...]
    bids: tuple[DelegationBid, ...]
    at_s: float
    detail: str


class SpeechHeard(Event, type="speech.heard"):
    """A robot of the mission reports what another, the `sender`, has said to it, and its answer (world's clock).
    `attempt`: how often it was said until it was heard.
    """

    robot: str
    sender: str
    performative: Performative
    content: str
    protocol: str
    conversation: str
    sent_at_s: float
    at_s: float
    attempt: int
    answer: Performative
    answer_content: str


class SpeechSaid(Event, type="speech.said"):
    """The service and a robot speak: who has said what to whom (world's clock), about a goal, a plan, a mission or
    the robot itself, the subject. `speaker`: the person on whose behalf the service speaks.
    """

    world: str
    sender: str
    receiver: str
    performative: Performative
    content: str
    protocol: str
    conversation: str
    message: str
    in_reply_to: str
    speaker: str
    sent_at_s: float
    at_s: float


class DialogueChanged(Event, type="dialogue.{0.state}", states=tuple(DialogueState)):
    """A dialogue of a person with the robot, the subject, has another state or another line: what `speaker` has said
    last, in words. `text`: what the person has said as a whole; `reason`: why it was refused or has failed.
    """

    world: str
    dialogue: str
    state: DialogueState
    actor: str
    text: str
    speaker: str
    performative: Performative
    words: str
    reason: str


class ResultReceived(Event, type="packet.result"):
    """A packet of the mission has brought a `result` (world's clock) `of` a place, sample or robot: an image of the
    camera `name`, or the `value` of the quantity `name`.
    """

    result: str
    robot: str
    packet: str
    at_s: float
    kind: str
    name: str
    of: str
    value: float | None
    unit: str


# Worlds and robots


@dataclass(frozen=True, slots=True, kw_only=True)
class Belief:
    """A fact that was believed, with its source and time (world's clock)."""

    predicate: str
    args: tuple[str, ...]
    source: str
    at_s: float


class FactsChanged(Event, type="world.facts_changed"):
    """Facts of the world were added and removed, each written `in(sample_1, bay_7)`; `version` is the world's."""

    version: int
    source: str
    added: tuple[str, ...]
    removed: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberChange:
    """A numeric fact that has changed; `before` is null if it was not known."""

    quantity: str
    args: tuple[str, ...]
    value: float
    before: float | None


class NumbersChanged(Event, type="world.numbers_changed"):
    """Numeric facts of the world have changed, such as a robot's battery, or are `gone` with what they told of, each
    written `battery(rover_1)`; `version` counts these changes.
    """

    version: int
    source: str
    at_s: float
    changed: tuple[NumberChange, ...]
    gone: tuple[str, ...] = ()


class WorldAdded(Event, type="world.added"):
    """An operator has added a world, which is at `edition` and starts now; `robots` are in it."""

    edition: int
    robots: tuple[str, ...]
    actor: str
    reason: str


class WorldRemoved(Event, type="world.removed"):
    """An operator has removed the world: it no longer runs, nor will after a restart; its history stays."""

    actor: str
    reason: str


class WorldChanged(Event, type="world.changed"):
    """The world itself has changed and is now at `edition`; `changes` in words. `undoes`: the edition taken back."""

    edition: int
    changes: tuple[str, ...]
    actor: str
    reason: str
    undoes: int | None = None


class WorldChangeTakenUp(Event, type="world.change_taken_up"):
    """The simulated or real world goes on as this edition, since `at_s` by its clock."""

    edition: int
    at_s: float


class WorldChangeRefused(Event, type="world.change_refused"):
    """The world does not go on as this edition, though it is recorded: undo it, or mend what the reason says."""

    edition: int
    reason: str


class FactsContradicted(Event, type="world.contradicted"):
    """Facts of the world proved to have been `believed` wrongly."""

    source: str
    at_s: float
    believed: tuple[Belief, ...]


class FactsCorrected(Event, type="world.corrected"):
    """An operator has corrected the world's facts; `dropped` are the facts that contradicted the correction."""

    actor: str
    comment: str
    dropped: tuple[SymbolicFact, ...]


class NumbersCorrected(Event, type="world.numbers_corrected"):
    """An operator has corrected numeric facts of the world; `stated` in words."""

    actor: str
    comment: str
    stated: tuple[str, ...]


class FactsReconciled(Event, type="world.reconciled"):
    """A robot stopped before its script's end; `notes` say which facts were given up because of its percepts."""

    robot: str
    notes: tuple[str, ...]


class LateReport(Event, type="world.late_report"):
    """Facts of a late report were ignored (`passed_over`): newer facts are known about the same things."""

    robot: str
    at_s: float
    passed_over: tuple[str, ...]


class HoldBegan(Event, type="hold.began"):
    """Places of the world are kept empty and `facts` true from now on, `until` in words; `goal` is the one that states
    it.
    """

    world: str
    places: tuple[str, ...]
    facts: tuple[str, ...] = ()
    until: str
    goal: str
    actor: str


class HoldEnded(Event, type="hold.ended"):
    """The hold's places and what its `facts` name may be used again; `why`: time, mission, goal, fact, operator (then
    `actor`), new_run or world_removed (then also `actor`).
    """

    world: str
    places: tuple[str, ...]
    facts: tuple[str, ...] = ()
    why: HoldEnding
    actor: str | None = None
    comment: str = ""


class HoldFactLost(Event, type="hold.fact_lost"):
    """A fact that the hold keeps has ceased to be true; `now`: what is believed instead, in words."""

    world: str
    fact: str
    now: str


class HoldFactRestored(Event, type="hold.fact_restored"):
    """A fact that the hold keeps, and that had ceased to be true, is true again."""

    world: str
    fact: str


class HoldRestoring(Event, type="hold.restoring"):
    """A goal that brings lost facts about again was submitted (`goal`), or could not be (`reason`)."""

    world: str
    goal: str | None
    reason: str


class RobotAnnounced(Event, type="robot.announced"):
    """The robot has told what it is, or what it told could be followed now; `reason`: why it is not in force."""

    world: str
    number: int
    outcome: FactsheetState
    reason: str
    edition: int | None


class RobotAdmitted(Event, type="robot.admitted"):
    """A robot that announced itself was added to the world: an operator admitted it, or the settings do (no actor)."""

    world: str
    edition: int
    actor: str | None
    comment: str


class RobotRefused(Event, type="robot.refused"):
    """What a robot announced is not followed: it does not fit the world (no actor), or an operator refuses it."""

    world: str
    actor: str | None
    reason: str


class RobotImpersonated(Event, type="robot.impersonated"):
    """Somebody else publishes in the robot's name: `count` messages since the event before; `reason` of the last.

    At most one such event a robot and minute.
    """

    world: str
    count: int
    reason: str


class RobotQueryNotUnderstood(Event, type="robot.query_not_understood"):
    """The robot does not understand status queries; it is not asked any longer, until it announces itself anew."""

    world: str
    reason: str


class RobotDeclaredLost(Event, type="robot.declared_lost"):
    """An operator has declared the robot lost; `silent`: it was not heard or did not answer."""

    world: str
    actor: str
    comment: str
    silent: bool


class RobotFound(Event, type="robot.found"):
    """The robot is no longer lost: an operator declared it found, or (actor `contact`) it was heard again."""

    world: str
    actor: str
    comment: str


class RobotTakenOutOfService(Event, type="robot.taken_out_of_service"):
    """An operator has taken the robot out of service: it ends what it has begun and is not recruited."""

    world: str
    actor: str
    reason: str


class RobotBroughtBack(Event, type="robot.brought_back"):
    """An operator has brought the robot back into service."""

    world: str
    actor: str
    comment: str


class TuningSet(Event, type="tuning.set"):
    """An operator has tuned the robot's packets: numbers by packet, pattern and parameter."""

    world: str
    actor: str
    comment: str
    version: int
    tuning: Mapping[str, Mapping[str, Mapping[str, float]]]


class TuningAcknowledged(Event, type="tuning.acknowledged"):
    """The robot has applied its tuning."""

    world: str
    version: int
    reason: str = ""


class TuningRefused(Event, type="tuning.refused"):
    """The robot has refused its tuning."""

    world: str
    version: int
    reason: str


class RulesSet(Event, type="rules.set"):
    """An operator has given the robot rule files: their digests by name."""

    world: str
    actor: str
    comment: str
    version: int
    digests: Mapping[str, str]


class BreakpointsSet(Event, type="breakpoints.set"):
    """An operator has set the breakpoints of a simulated robot's rules, by file and line; none: removed them."""

    world: str
    actor: str
    rules: tuple[str, ...]


class RulesAcknowledged(Event, type="rules.acknowledged"):
    """The robot follows its rules; the digests of the files by name."""

    world: str
    version: int
    reason: str = ""
    followed: Mapping[str, str]


class RulesRefused(Event, type="rules.refused"):
    """The robot has refused its rules; the digests of the files that it goes on to follow, by name."""

    world: str
    version: int
    reason: str
    followed: Mapping[str, str]


class RoleSet(Event, type="role.set"):
    """An operator has given the robot a role: what it is recruited for (null: all that it can), the home that the role
    brings, and the version of the rules by which the robot is told.
    """

    world: str
    actor: str
    comment: str
    version: int
    role: str
    tags: tuple[str, ...] | None
    home: str | None
    rules_version: int


class RoleCleared(Event, type="role.cleared"):
    """An operator has ended the robot's role; the version of the rules by which the robot is told."""

    world: str
    actor: str
    comment: str
    version: int
    role: str
    rules_version: int


class EmbodimentChanged(Event, type="embodiment.{0.state}", states=tuple(EmbodimentState)):
    """A move of the robot's mind into another body has come so far. `fence`: its fencing number; `body`, `former`: the
    kinds of the two bodies; `edition`: of the world, which exchanges them, null: none is made; `reason`: why the mind
    does not get the other body.
    """

    world: str
    fence: int
    state: EmbodimentState
    body: str
    former: str
    edition: int | None
    actor: str
    reason: str


class UpkeepReported(Event, type="upkeep.{0.state}", states=tuple(PacketState)):
    """The robot has reported a packet of its own upkeep, such as recharging (world's clock)."""

    world: str
    packet: str
    state: PacketState
    at_s: float
    detail: str


class RobotFaultsReported(Event, type="robot.faults_reported"):
    """The robot has other faults than before, as it says itself (world's clock); none: all are gone."""

    world: str
    at_s: float
    faults: tuple[RobotFault, ...]


class TeleoperationBegan(Event, type="teleoperation.began"):
    """The operator `driver` drives the robot (world's clock)."""

    world: str
    driver: str
    packet: str
    at_s: float
    detail: str


class TeleoperationEnded(Event, type="teleoperation.ended"):
    """The operator `driver` no longer drives the robot (world's clock)."""

    world: str
    driver: str
    packet: str
    at_s: float
    detail: str


def event_classes() -> tuple[type[Event], ...]:
    """Every class of this module that an event may be of, in the order of their definition."""
    known = (value for value in globals().values() if isinstance(value, type) and issubclass(value, Event))
    return tuple(one for one in known if one.types())
