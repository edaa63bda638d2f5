"""The services of an application, which its routes get with each request.

So the routes themselves are made once in a process, whatever the number of applications.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Event
from typing import Annotated

from anyio import CapacityLimiter
from fastapi import Depends, FastAPI
from starlette.requests import HTTPConnection

from app.agents import Questions, RobotBoard
from app.agents.breakpoints import BreakpointService
from app.agents.robot_directory import RobotDirectory
from app.agents.rules import RuleService
from app.agents.speech import SpeechService
from app.agents.teleoperation import Teleoperation
from app.agents.tuning import TuningService
from app.agents.world_service import WorldService
from app.api.etags import VersionedJson
from app.api.plan_json import PlanJson
from app.background_compilation import Stage
from app.missions.dialogues import DialogueService
from app.missions.embodiments import EmbodimentService
from app.missions.factsheets import Factsheets
from app.missions.lost_robots import LostRobots
from app.missions.mission_service import MissionService
from app.missions.out_of_service import OutOfService
from app.missions.replanning import MissionReplanning
from app.missions.roles import RoleService
from app.missions.sensor_sources import SensorSources
from app.missions.world_changes import WorldChanges
from app.missions.world_set import WorldSet
from app.packs.contents import PackContents
from app.planning.alternatives import Alternatives
from app.planning.approval import PlanApproval
from app.planning.bids import PlanBids
from app.planning.explanations import Explanations
from app.planning.export import PlanExport
from app.planning.goal_service import GoalService
from app.planning.hold_service import HoldService
from app.planning.tenders import Tenders
from app.recordings import RecordingStore
from app.settings import Settings
from app.store.event_log import EventLog
from app.workflows.leases import Executor, ExecutorRegistry
from robots.clock import Clock
from robots.link.mqtt.inbox import Rejected

WAITING_FOR_ROBOTS = 16
"""Requests that may wait for robots' answers at the same time; further ones queue and do not block other routes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Services:
    """The services that an application's routes call, and what the routes keep between requests.

    :param token: the administrator's token.
    :param stopping: set when the process is about to end; open streams then end.
    :param waits_for: why the service cannot plan yet; empty once it can.
    :param compilation: how far the compilation of its planner and its worlds is.
    :param other_packs: which of the service's processes run other domain packs than this one, in words.
    :param link_faults: by world, code and words of why no message to or from its robots can pass.
    :param invalid_messages: by world, the messages from its robots that were dropped as invalid.
    :param plan_json, facts_json, numbers_json: answers that need not be serialised again.
    :param waiting_for_robots: limits the requests that wait for robots' answers at the same time.
    """

    token: str
    settings: Settings
    stopping: Event
    events: EventLog
    clocks: Mapping[str, Clock]
    board: RobotBoard
    goals: GoalService
    holds: HoldService
    alternatives: Alternatives
    plans: PlanApproval
    explanations: Explanations
    plan_bids: PlanBids
    tenders: Tenders
    export: PlanExport
    missions: MissionService
    replanning: MissionReplanning
    worlds: WorldService
    world_set: WorldSet
    world_changes: WorldChanges
    factsheets: Factsheets
    robots: RobotDirectory
    questions: Questions
    tunings: TuningService
    rules: RuleService
    breakpoints: BreakpointService
    roles: RoleService
    sensor_sources: SensorSources
    embodiments: EmbodimentService
    speech: SpeechService
    dialogues: DialogueService
    lost_robots: LostRobots
    out_of_service: OutOfService
    teleoperation: Teleoperation
    recordings: RecordingStore
    executors: ExecutorRegistry
    packs: Sequence[PackContents]
    waits_for: Callable[[], str] = lambda: ""
    compilation: Callable[[], Stage] = lambda: Stage.COMPILED
    other_packs: Callable[[Sequence[Executor]], Sequence[str]] = lambda executors: ()
    invalid_messages: Callable[[], Mapping[str, Rejected]] = dict
    link_faults: Callable[[], Mapping[str, tuple[str, str]]] = dict
    plan_json: PlanJson = field(default_factory=PlanJson)
    facts_json: VersionedJson = field(default_factory=VersionedJson)
    numbers_json: VersionedJson = field(default_factory=VersionedJson)
    waiting_for_robots: CapacityLimiter = field(default_factory=lambda: CapacityLimiter(WAITING_FOR_ROBOTS))


def provide(api: FastAPI, services: Services) -> None:
    """Have the application's routes call these services."""
    api.state.services = services


async def _services(connection: HTTPConnection) -> Services:
    """Async, so that it is called in the event loop and costs no worker thread."""
    services: Services = connection.app.state.services
    return services


AppServices = Annotated[Services, Depends(_services)]
"""The services of the application that the request has come to."""
