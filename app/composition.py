"""The composition root: wires the concrete parts into a service. Nothing is made at import."""

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from threading import Event

from fastapi import FastAPI

from app.agents import AgentModels, ContactMonitor, Questions, RobotBoard
from app.agents.robot_directory import RobotDirectory
from app.agents.running_world import RunningWorld
from app.agents.teleoperation import Teleoperation
from app.agents.tuning import TuningService
from app.agents.world_service import WorldService
from app.api.app import Services, build_api
from app.api.recordings import as_the_api_has_it
from app.core import Core
from app.domain.mission_organiser import Margin, load_library
from app.missions.dispatch import ScriptDispatcher
from app.missions.fleet_run import FleetRun
from app.missions.life import MissionLife, WorldTime
from app.missions.lost_robots import LostRobots
from app.missions.mission_service import MissionService
from app.missions.recovery import RecoveryPlanning, RecoverySteps
from app.missions.reports import MissionReports
from app.missions.world_start import begin_world, part_from_others
from app.planning.alternatives import Alternatives, AlternativesSearch
from app.planning.approval import PlanApproval
from app.planning.explanations import Explanations
from app.planning.export import PlanExport
from app.planning.goal_planning import GoalPlanning
from app.planning.goal_service import GoalService
from app.planning.limits import PlanningLimits
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.work import make_engine
from app.planning.problem_builder import ProblemBuilder
from app.planning.proposals import Proposals
from app.planning.requests import PlanningRequests
from app.planning.waiting_goals import WaitingGoals
from app.recordings import Recorder, RecordingStore
from app.settings import Settings, lock_folder
from app.store import Database
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.migrate import migrate
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from app.workflows import (
    FIND_ALTERNATIVES,
    MISSION_LIFE,
    MISSIONS,
    PLAN_GOAL,
    PLAN_WAITING,
    QUEUES,
    RECOVER_MISSION,
    Queue,
    Workflows,
)
from app.workflows.leases import ExecutorRegistry
from app.workflows.notifications import NotificationListener
from app.workflows.retention import Retention
from planner import load_knowledge_base
from robots.clock import Clock
from robots.world import WorldFile

__all__ = ["RunningWorld", "Service", "make_engine"]

WEB = Path(__file__).parent.parent / "web" / "static"


class Service:
    """Everything that runs in the service's process. `start` before use, `close` at the end."""

    def __init__(
        self,
        settings: Settings,
        worlds: Sequence[RunningWorld],
        *,
        viewer: Callable[[], str | None] = lambda: None,
        worker: PlanningWorker | None = None,
        serves: Collection[Queue] | None = None,
    ) -> None:
        """
        :param serves: the queues whose workflows run here; all, but for plans where no planning process is wanted.
        :param viewer: the address of the view of the world, None while there is none.
        :param worker: the planning process; one of its own unless given, then the giver closes it.
        """
        served = serves or (QUEUES if settings.planning_processes else (MISSIONS,))
        self.stopping = Event()
        """Set when the service is about to end: open streams then end by themselves."""
        self.settings, self._viewer = settings, viewer
        self._speaks = MISSIONS in served
        # One that only plans keeps nothing in the folder.
        self._lock = lock_folder(settings.data) if self._speaks else None
        self.token = settings.resolved_token() if self._speaks else ""
        self._worlds = {world.file.name: world for world in worlds}
        self._files: Mapping[str, WorldFile] = {name: world.file for name, world in self._worlds.items()}
        self.database = Database(settings.resolved_database_url())
        migrate(self.database)
        self.events = EventLog(self.database)
        knowledge_base = load_knowledge_base()
        self.workflows = Workflows(settings.resolved_database_url(), serves=served)
        plan_nets = PlanNets(knowledge_base)
        self._core = Core(
            database=self.database,
            events=self.events,
            facts=FactStore(self.events, knowledge_base),
            workflows=self.workflows,
            knowledge_base=knowledge_base,
            plan_nets=plan_nets,
            holdings=Reservations(plan_nets),
        )
        self._notifications = NotificationListener(self.database, self.workflows.topics)
        self.presence = ExecutorRegistry(
            self.database,
            self.workflows,
            serves=[queue.name for queue in served],
            worlds=self._files if self._speaks else (),
        )
        self.clocks: dict[str, Clock] = {name: world.clock for name, world in self._worlds.items()}
        self.board = RobotBoard.of(self._files, clocks=self.clocks, low_battery=settings.low_battery)
        self.hearing = ContactMonitor(self.board, clocks=self.clocks, worlds=self._files)
        self.questions = Questions(patience_s=settings.answer_patience_s)
        self._own_worker = worker is None
        self._worker = worker or PlanningWorker(
            make_engine, processes=settings.planning_processes, memory_mb=settings.planning_memory_mb
        )
        self._wire_desks()
        self._retention = Retention.of(self.database, self.workflows, settings)
        self.shelf = RecordingStore.of(settings)
        self._recorder = Recorder(
            self._core,
            shelf=self.shelf,
            board=self.board,
            clocks=self.clocks,
            shown=as_the_api_has_it(self.worlds, self.plans),
            presence=self.presence,
        )
        self._agents = [self._agents_of(world) for world in worlds]

    @cached_property
    def api(self) -> FastAPI:
        services = Services(
            token=self.token,
            settings=self.settings,
            stopping=self.stopping,
            events=self.events,
            clocks=self.clocks,
            board=self.board,
            goals=self.goals,
            alternatives=self.choices,
            plans=self.plans,
            explanations=self.explaining,
            export=self.exporting,
            missions=self.missions,
            worlds=self.worlds,
            robots=self.robots,
            questions=self.questions,
            tunings=self.tunings,
            lost_robots=self.lost,
            teleoperation=self.teleoperation,
            recordings=self.shelf,
            executors=self.presence,
        )
        return build_api(services, viewer=self._viewer, static=WEB)

    def start(self) -> None:
        """Begin: the worlds that go on or start afresh, the workflows that were left, the links to the robots."""
        ready = self._worker.warm_up()
        simulated = [name for name, world in self._worlds.items() if world.run is not None]
        self.presence.register(simulated if self._speaks else ())
        # Also those whose lease another process holds: it may die before it has recorded anything of them.
        mine = list(self._worlds.values()) if self._speaks else []
        with self.database.write() as session:
            for world in mine:
                begin_world(session, self._core, world)
            if not self.database.shared:
                part_from_others(session, self._core, self._files.keys())
        self.workflows.register(PLAN_GOAL, self._planning.run)
        self.workflows.register(FIND_ALTERNATIVES, self._alternatives_search.run)
        self.workflows.register(PLAN_WAITING, partial(self._waiting.run, plan=self._planning.run))
        self.workflows.register(MISSION_LIFE, self._life.run)
        self.workflows.register(RECOVER_MISSION, self._recovery.run)
        self.workflows.launch()
        self.presence.start()
        self._notifications.start()
        for world in self._worlds.values():
            world.listen(self.board)
        for agents in self._agents:
            agents.start()
        with self.database.write() as session:
            for world in mine:
                self._waiting.release(session, world.file.name)
        self._retention.start()
        self._recorder.start()
        ready.result(timeout=300)
        for world in self._worlds.values():
            world.let_go()

    def close(self) -> None:
        self.stopping.set()
        self._retention.close()
        self._recorder.close()
        for agents in self._agents:
            agents.close()
        self._notifications.close()
        self.presence.stop()
        self.workflows.close()
        self.presence.close()
        if self._own_worker:
            self._worker.close()
        self.database.close()
        if self._lock is not None:
            self._lock.close()

    def __enter__(self) -> "Service":
        try:
            self.start()
        except BaseException:
            self.close()  # an interruption, too, leaves no process behind
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _wire_desks(self) -> None:
        core, settings = self._core, self.settings
        limits = PlanningLimits.of(settings)
        self.worlds = WorldService(core, worlds=self._files, clocks=self.clocks)
        self.robots = RobotDirectory(
            self.database, worlds=self._files, board=self.board, contact=self.hearing
        )
        self.teleoperation = Teleoperation(self.robots, {n: w.pace for n, w in self._worlds.items()})
        self.tunings = TuningService(core, worlds=self._files)
        self.missions = MissionService(core)
        requests = PlanningRequests(core, clocks=self.clocks)
        self.plans = PlanApproval(
            core,
            margin=Margin(
                relative=settings.margin_relative,
                absolute_s=settings.margin_s,
                answers_s={name: file.answer_s for name, file in self._files.items()},
            ),
            requests=requests,
        )
        self._wire_planning(limits, requests)
        self.goals = GoalService(
            core,
            world=self.worlds.world,
            clocks=self.clocks,
            limits=limits,
            open_goals=settings.open_goals,
            requests=requests,
        )
        self.lost = LostRobots(core, clocks=self.clocks, board=self.board, waiting=self._waiting)
        self._reports = MissionReports(core, waiting=self._waiting)
        repertoires = {n: {r.name: r.repertoire for r in w.robots} for n, w in self._files.items()}
        self._life = MissionLife(
            core,
            dispatching=ScriptDispatcher(
                core, library=load_library(core.knowledge_base), repertoires=repertoires
            ),
            times={n: WorldTime.of(w) for n, w in self._worlds.items()},
            patience_s=settings.answer_patience_s,
            recovery=RecoverySteps(self.events, requests=requests),
            waiting=self._waiting,
            silent_in_s=self.hearing.silent_in_s,
        )

    def _wire_planning(self, limits: PlanningLimits, requests: PlanningRequests) -> None:
        core, worker = self._core, self._worker
        problems = ProblemBuilder(
            core, worlds=self._files, clocks=self.clocks, points=self.board.points, resting=self.board.resting
        )
        proposals = Proposals(core, clocks=self.clocks)
        self._waiting = WaitingGoals(core)
        self.board.rested.append(self._waiting.rested)
        self._planning = GoalPlanning(
            core,
            problems=problems,
            proposals=proposals,
            waiting=self._waiting,
            worker=worker,
            limits=limits,
            approval=self.plans,
        )
        self._recovery = RecoveryPlanning(
            core,
            problems=problems,
            proposals=proposals,
            worker=worker,
            limits=limits,
            clocks=self.clocks,
            requests=requests,
            approval=self.plans,
        )
        self.choices = Alternatives(core)
        self._alternatives_search = AlternativesSearch(
            core, problems=problems, proposals=proposals, worker=worker, limits=limits
        )
        self.explaining = Explanations(core, problems=problems, worker=worker, limits=limits)
        self.exporting = PlanExport(core, problems=problems)

    def _agents_of(self, world: RunningWorld) -> AgentModels:
        return AgentModels(
            robots={robot.name: world.file.link_of(robot) for robot in world.file.robots},
            link=world.link,
            clock=world.clock,
            database=self.database,
            reports=self._reports,
            board=self.board,
            questions=self.questions,
            teleoperation=self.teleoperation,
            tunings=self.tunings,
            readmit=partial(self.lost.welcome, world.file.name),
            world=world.file.name,
            has_lease=partial(self.presence.holds_lease, world.file.name),
            each_turn=self._seeing_to(world),
        )

    def _seeing_to(self, world: RunningWorld) -> Callable[[], None]:
        """What a world's agent models see to between messages: who drives it, and who of it may be recruited again."""
        rested = partial(self._waiting.look, world.file.name)
        if world.fleet is None:
            return rested
        speaks = partial(self.presence.holds_lease, world.file.name)
        meeting = FleetRun(self._core, world.file, world.fleet, waiting=self._waiting, speaks=speaks)

        def see() -> None:
            meeting.look()
            rested()

        return see
