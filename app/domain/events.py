"""Every event of the log: its type, its subject and its data, as the event stream publishes them.

A class is one type of event (`TYPE`), or one for each state that the event may bring (`STATES`). All fields but
`subject` are the event's data. Events of goals, plans and missions carry the `state` that their subject is in once the
transaction has committed; where one transaction appends several, the last of them does.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar

from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import ENDED, MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.lifecycles.script import TERMINAL_SCRIPTS
from robots.wire import FailureCategory, PacketState, ScriptState, SymbolicFact


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Something that happened to a subject.

    :param subject: the id of the goal, plan, mission or script, or the name of the robot or world.
    """

    TYPE: ClassVar[str] = ""
    STATES: ClassVar[Collection[StrEnum]] = ()
    subject: str

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


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalEvent(Event):
    """Something that happened to a goal."""

    state: GoalState


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalSubmitted(GoalEvent):
    """The goal waits to be planned: newly submitted, or again for the given reason (then `actor` is null)."""

    TYPE: ClassVar[str] = "goal.submitted"
    text: str
    actor: str | None = None
    reason: str = ""
    state: GoalState = GoalState.SUBMITTED


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalPlanningBegan(GoalEvent):
    """Planning has begun."""

    TYPE: ClassVar[str] = "goal.planning"
    state: GoalState = GoalState.PLANNING


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalProgress(GoalEvent):
    """The planner has a better plan or a better lower bound than before; also while a mission's plan is repaired."""

    TYPE: ClassVar[str] = "goal.progress"
    engine: str
    elapsed_s: float
    makespan_s: float | None
    lower_bound_s: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalPlanned(GoalEvent):
    """A plan is proposed for the goal and waits for a decision."""

    TYPE: ClassVar[str] = "goal.planned"
    plan: str
    state: GoalState = GoalState.PLANNED


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalWaiting(GoalEvent):
    """There is no plan yet: the goal waits for running missions or resting robots and is then planned again."""

    TYPE: ClassVar[str] = "goal.waiting"
    reason: str
    state: GoalState = GoalState.WAITING


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalUnsolvable(GoalEvent):
    """There is no plan for the goal; `status` is the planner's result."""

    TYPE: ClassVar[str] = "goal.unsolvable"
    reason: str
    status: str
    state: GoalState = GoalState.UNSOLVABLE


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalCommitted(GoalEvent):
    """A plan of the goal was approved, and a mission carries it out."""

    TYPE: ClassVar[str] = "goal.committed"
    plan: str
    mission: str
    state: GoalState = GoalState.COMMITTED


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalStopRequested(GoalEvent):
    """An operator wants the planning to end and its best plan so far."""

    TYPE: ClassVar[str] = "goal.stop_requested"
    actor: str
    state: GoalState = GoalState.PLANNING


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalWithdrawn(GoalEvent):
    """The goal is no longer pursued: cancelled, its last plan rejected, or its world no longer runs."""

    TYPE: ClassVar[str] = "goal.withdrawn"
    reason: str
    actor: str | None = None
    state: GoalState = GoalState.WITHDRAWN


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalFinished(GoalEvent):
    """The goal's mission has ended; `outcome` is the state it ended in."""

    TYPE: ClassVar[str] = "goal.finished"
    outcome: MissionState
    reason: str
    state: GoalState = GoalState.FINISHED


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalAlternativesSought(GoalEvent):
    """An operator wants up to `count` plans to choose from."""

    TYPE: ClassVar[str] = "goal.alternatives_sought"
    actor: str
    count: int
    state: GoalState = GoalState.PLANNED


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalAlternativesFound(GoalEvent):
    """The search for alternatives has ended; `plans` are open to decision."""

    TYPE: ClassVar[str] = "goal.alternatives_found"
    plans: tuple[str, ...]
    reason: str = ""
    state: GoalState = GoalState.PLANNED


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalAlternativesFailed(GoalEvent):
    """The search for alternatives found none; `plans` are open to decision as before."""

    TYPE: ClassVar[str] = "goal.alternatives_failed"
    plans: tuple[str, ...]
    reason: str
    state: GoalState = GoalState.PLANNED


# Plans


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanEvent(Event):
    """Something that happened to a plan."""

    goal: str
    state: PlanState


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanProposed(PlanEvent):
    """A plan was found and waits for a decision."""

    TYPE: ClassVar[str] = "plan.proposed"
    makespan_s: float
    robots: tuple[str, ...]
    state: PlanState = PlanState.PROPOSED


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanDecided(PlanEvent):
    """The plan was approved or rejected."""

    TYPE: ClassVar[str] = "plan.{0.state}"
    STATES: ClassVar[Collection[PlanState]] = (PlanState.APPROVED, PlanState.REJECTED)
    actor: str
    comment: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanClosed(PlanEvent):
    """The plan is not open to decision any longer: overtaken by the world (expired) or by another plan (superseded)."""

    TYPE: ClassVar[str] = "plan.{0.state}"
    STATES: ClassVar[Collection[PlanState]] = (PlanState.EXPIRED, PlanState.SUPERSEDED)
    reason: str
    actor: str | None = None


# Missions


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionEvent(Event):
    """Something that happened to a mission."""

    state: MissionState


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionPhase(MissionEvent):
    """The mission has entered a phase; while it is paused, the phase it goes on with and `state` is `paused`."""

    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionPending(MissionPhase):
    """The mission exists, its robots have no scripts yet."""

    TYPE: ClassVar[str] = "mission.pending"
    goal: str | None = None
    plan: str | None = None
    robots: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionDispatching(MissionPhase):
    """The scripts of the mission's plan are being delivered to its robots."""

    TYPE: ClassVar[str] = "mission.dispatching"
    plan: str | None = None
    revision: int | None = None
    robots: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRunning(MissionPhase):
    """Robots are at work; `started_at_s` is set when the first of them has begun (world's clock)."""

    TYPE: ClassVar[str] = "mission.running"
    started_at_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionPaused(MissionPhase):
    """An operator has paused the mission; its robots stand still."""

    TYPE: ClassVar[str] = "mission.paused"
    actor: str | None = None
    comment: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionUnknown(MissionPhase):
    """Robots do not answer, so what becomes of the mission is not known."""

    TYPE: ClassVar[str] = "mission.unknown"


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRecovering(MissionPhase):
    """Something has gone wrong: the mission's robots are stopped and its plan is repaired."""

    TYPE: ClassVar[str] = "mission.recovering"


MISSION_PHASES: Mapping[MissionState, type[MissionPhase]] = {
    MissionState.PENDING: MissionPending,
    MissionState.DISPATCHING: MissionDispatching,
    MissionState.RUNNING: MissionRunning,
    MissionState.PAUSED: MissionPaused,
    MissionState.UNKNOWN: MissionUnknown,
    MissionState.RECOVERING: MissionRecovering,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionEnded(MissionEvent):
    """The mission has ended, when its robots were last heard of it (world's clock)."""

    TYPE: ClassVar[str] = "mission.{0.state}"
    STATES: ClassVar[Collection[MissionState]] = ENDED
    goal: str
    reason: str
    failure: FailureCategory | None
    ended_at_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionResumed(MissionEvent):
    """An operator has the mission go on after a pause, or has a repair sought again."""

    TYPE: ClassVar[str] = "mission.resumed"
    actor: str
    comment: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionCancelRequested(MissionEvent):
    """An operator wants the mission to end; it is cancelled once its robots have answered."""

    TYPE: ClassVar[str] = "mission.cancel_requested"
    actor: str
    comment: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRecoverySet(MissionEvent):
    """An operator has changed what becomes of the mission's failures."""

    TYPE: ClassVar[str] = "mission.recovery_set"
    actor: str
    policy: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionOverdue(MissionEvent):
    """The mission's deadline has passed (world's clock); it goes on."""

    TYPE: ClassVar[str] = "mission.overdue"
    deadline_s: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRobotsAsked(MissionEvent):
    """Robots are asked how their scripts stand: the expected time is over, or they are silent."""

    TYPE: ClassVar[str] = "mission.robots_asked"
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRecoveryBegun(MissionEvent):
    """A repair of the mission's plan is sought, for the `number`-th time."""

    TYPE: ClassVar[str] = "mission.recovery_begun"
    number: int
    failure: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionNoRepair(MissionEvent):
    """No repair was found."""

    TYPE: ClassVar[str] = "mission.no_repair"
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRepairProposed(MissionEvent):
    """A repaired plan waits for a decision."""

    TYPE: ClassVar[str] = "mission.repair_proposed"
    plan: str
    measure: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRevised(MissionEvent):
    """The mission carries out a repaired plan from now on; its robots get new scripts."""

    TYPE: ClassVar[str] = "mission.revised"
    plan: str
    revision: int


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionStuck(MissionEvent):
    """No way to go on was found; an operator has to decide."""

    TYPE: ClassVar[str] = "mission.stuck"
    reason: str


# Scripts and packets


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptAcknowledged(Event):
    """The robot has agreed to carry out the script."""

    TYPE: ClassVar[str] = "script.acknowledged"
    robot: str
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptRefused(Event):
    """The robot has refused the script."""

    TYPE: ClassVar[str] = "script.refused"
    robot: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptStatus(Event):
    """The robot has answered how the script stands; `packet` is what it is at."""

    TYPE: ClassVar[str] = "script.status"
    robot: str
    state: ScriptState | None
    packet: str | None
    detail: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptReported(Event):
    """The robot has reported the script's end (world's clock)."""

    TYPE: ClassVar[str] = "script.{0.state}"
    STATES: ClassVar[Collection[ScriptState]] = TERMINAL_SCRIPTS
    robot: str
    mission: str
    state: ScriptState
    at_s: float
    detail: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptCleared(Event):
    """The robot is told which actions of others have `ended` that its packets come after."""

    TYPE: ClassVar[str] = "script.cleared"
    robot: str
    ended: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptAbandoned(Event):
    """The script's robot was declared lost; its end is not waited for."""

    TYPE: ClassVar[str] = "script.abandoned"
    robot: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlRefused(Event):
    """The robot has refused an order to cancel, pause or resume the script."""

    TYPE: ClassVar[str] = "control.refused"
    robot: str
    control: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ClearanceRefused(Event):
    """The robot has refused a clearance for the script."""

    TYPE: ClassVar[str] = "clearance.refused"
    robot: str
    clearance: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketReported(Event):
    """A robot has reported the state of a packet of the mission (world's clock), and the packet's own `events`."""

    TYPE: ClassVar[str] = "packet.{0.state}"
    STATES: ClassVar[Collection[PacketState]] = tuple(PacketState)
    robot: str
    packet: str
    state: PacketState
    at_s: float
    events: tuple[str, ...]
    detail: str


# Worlds and robots


@dataclass(frozen=True, slots=True, kw_only=True)
class Belief:
    """A fact that was believed, who said it and when (world's clock)."""

    predicate: str
    args: tuple[str, ...]
    source: str
    at_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FactsChanged(Event):
    """Facts of the world were added and removed, each written `in(sample_1, bay_7)`; `version` is the world's."""

    TYPE: ClassVar[str] = "world.facts_changed"
    version: int
    source: str
    added: tuple[str, ...]
    removed: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FactsContradicted(Event):
    """Facts of the world proved to have been `believed` wrongly."""

    TYPE: ClassVar[str] = "world.contradicted"
    source: str
    at_s: float
    believed: tuple[Belief, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FactsCorrected(Event):
    """An operator has corrected the world's facts; `dropped` cannot hold beside the correction."""

    TYPE: ClassVar[str] = "world.corrected"
    actor: str
    comment: str
    dropped: tuple[SymbolicFact, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FactsReconciled(Event):
    """A robot stopped before its script's end; `notes` say what its percepts gave up of the world's facts."""

    TYPE: ClassVar[str] = "world.reconciled"
    robot: str
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LateReport(Event):
    """Facts of a report were `passed_over`, for something newer is known of their subjects."""

    TYPE: ClassVar[str] = "world.late_report"
    robot: str
    at_s: float
    passed_over: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotDeclaredLost(Event):
    """An operator has declared the robot lost; `silent`: it was not heard or did not answer."""

    TYPE: ClassVar[str] = "robot.declared_lost"
    world: str
    actor: str
    comment: str
    silent: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotFound(Event):
    """The robot is counted on again: an operator said so, or (actor `contact`) it was heard."""

    TYPE: ClassVar[str] = "robot.found"
    world: str
    actor: str
    comment: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TuningSet(Event):
    """An operator has tuned the robot's packets: numbers by packet, pattern and parameter."""

    TYPE: ClassVar[str] = "tuning.set"
    world: str
    actor: str
    comment: str
    version: int
    tuning: Mapping[str, Mapping[str, Mapping[str, float]]]


@dataclass(frozen=True, slots=True, kw_only=True)
class TuningAcknowledged(Event):
    """The robot has taken on its tuning."""

    TYPE: ClassVar[str] = "tuning.acknowledged"
    world: str
    version: int
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TuningRefused(Event):
    """The robot has refused its tuning."""

    TYPE: ClassVar[str] = "tuning.refused"
    world: str
    version: int
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class UpkeepReported(Event):
    """The robot has reported a packet that it carries out for its own sake, such as recharging (world's clock)."""

    TYPE: ClassVar[str] = "upkeep.{0.state}"
    STATES: ClassVar[Collection[PacketState]] = tuple(PacketState)
    world: str
    packet: str
    state: PacketState
    at_s: float
    detail: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TeleoperationBegan(Event):
    """The operator `driver` drives the robot (world's clock)."""

    TYPE: ClassVar[str] = "teleoperation.began"
    world: str
    driver: str
    packet: str
    at_s: float
    detail: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TeleoperationEnded(Event):
    """The operator `driver` drives the robot no more (world's clock)."""

    TYPE: ClassVar[str] = "teleoperation.ended"
    world: str
    driver: str
    packet: str
    at_s: float
    detail: str


def event_classes() -> tuple[type[Event], ...]:
    """Every class of this module that an event may be of, in the order of their definition."""
    known = (value for value in globals().values() if isinstance(value, type) and issubclass(value, Event))
    return tuple(one for one in known if one.types())
