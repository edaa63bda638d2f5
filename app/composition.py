"""The composition root: wires the concrete parts into a service."""

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import Future
from functools import cached_property, partial
from pathlib import Path
from threading import Event
from typing import Any

from fastapi import FastAPI

from app.agents import AgentModels, ContactMonitor, Questions, RobotBoard
from app.agents.battery_record import BatteryRecord
from app.agents.breakpoints import BreakpointService
from app.agents.edition_delivery import EditionDelivery
from app.agents.foreign_states import ForeignStates
from app.agents.impersonation import Impersonations, KeyFile, RobotWatch
from app.agents.robot_directory import RobotDirectory
from app.agents.rules import RuleService, rule_check
from app.agents.running_world import AnnouncesWorld, RejectsMessages, RunningWorld, WorldHost
from app.agents.running_worlds import RunningWorlds
from app.agents.signature_counters import SignatureCounters
from app.agents.speech import SpeechService
from app.agents.teleoperation import Teleoperation
from app.agents.tuning import TuningService
from app.agents.world_service import WorldService
from app.api.app import build_api
from app.api.recordings import recorded_bodies
from app.api.services import Services
from app.background_compilation import BackgroundCompilation, Stage
from app.core import Core
from app.domain.mission_organiser import Margin
from app.domain.world_model.senses import restricted_senses
from app.missions.better_plans import BetterPlans
from app.missions.dialogues import DialogueService
from app.missions.dispatch import ScriptDispatcher
from app.missions.embodiments import EmbodimentService
from app.missions.factsheets import Factsheets
from app.missions.fleet_run import DeclaresPacks, FleetRun
from app.missions.life import MissionLife, WorldTime
from app.missions.lost_robots import LostRobots
from app.missions.mission_service import MissionService
from app.missions.out_of_service import OutOfService
from app.missions.plausibility import Plausibility
from app.missions.recovery import RecoveryJob, RecoverySteps
from app.missions.repair_tasks import RepairTasks
from app.missions.replanning import MissionReplanning
from app.missions.reports import MissionReports
from app.missions.roles import RoleService
from app.missions.run_announcer import RunAnnouncer
from app.missions.sensor_sources import SensorSources
from app.missions.world_changes import WorldChanges
from app.missions.world_set import FileChecks, WorldSet
from app.missions.world_start import end_missions_of_absent_worlds, start_world
from app.packs.contents import contents_of
from app.packs.find import load_packs
from app.packs.pack_set import difference
from app.planning.alternatives import Alternatives, AlternativesJob
from app.planning.approval import PlanApproval
from app.planning.bids import PlanBids
from app.planning.charge_watch import ChargeWatch, charging_range
from app.planning.explanations import Explanations
from app.planning.export import PlanExport
from app.planning.goal_planning import GoalPlanningJob
from app.planning.goal_service import GoalService
from app.planning.hold_service import HoldService
from app.planning.hold_watch import HoldWatch
from app.planning.joint_goals import JointGoals
from app.planning.leg_calls import LegCalls
from app.planning.limits import PlanningLimits
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.work import make_engine
from app.planning.problem_builder import ProblemBuilder
from app.planning.proposals import Proposals
from app.planning.requests import PlanningRequests
from app.planning.tenders import Tenders
from app.planning.waiting_goals import WaitingGoals
from app.recordings import MindSampler, Recorder, RecordingStore
from app.settings import Settings, lock_folder
from app.store import Database
from app.store.editions import WorldDirectory
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
    SEEK_BETTER_PLANS,
    Queue,
    Workflows,
)
from app.workflows.leases import Executor, ExecutorRegistry
from app.workflows.notifications import NotificationListener
from app.workflows.retention import Retention
from robots.clock import Clock
from robots.link.mqtt.inbox import Rejected
from robots.link.mqtt.signature import OrderSigner
from robots.world import WorldFile

logger = logging.getLogger(__name__)

__all__ = ["RunningWorld", "Service", "make_engine"]

WEB = Path(__file__).parent.parent / "web" / "static"
CHEAP_ROUND_TRIP_S = 1.0
"""Recordings have the minds of robots whose radio takes at most this long there and back."""


class Service:
    """Everything that runs in the service's process: `start` before use, `close` at the end."""

    def __init__(
        self,
        settings: Settings,
        worlds: Sequence[RunningWorld],
        *,
        viewer: Callable[[], str | None] = lambda: None,
        worker: PlanningWorker | None = None,
        host: WorldHost | None = None,
        compilation: BackgroundCompilation | None = None,
        serves: Collection[Queue] | None = None,
        tell: Callable[[str], None] = logger.info,
    ) -> None:
        """
        :param worlds: those that are given at the start; the caller ends them.
        :param viewer: the address of the 3D view, None while there is none.
        :param worker: the planning processes; made and closed by the service if None.
        :param host: makes worlds run that are added meanwhile; None: none can be added.
        :param compilation: of what this process and its children call; started and closed by the caller.
        :param serves: the queues whose workflows run here; by default all, without planning processes only missions.
        :param tell: called with a message about each step of the planner's start; unused if `worker` is given.
        """
        served = serves or (QUEUES if settings.planning_processes else (MISSIONS,))
        self.stopping = Event()
        """Set when the service begins to shut down: open streams then end."""
        self.settings = settings
        self.packs = load_packs(settings.packs)
        self._pack_digests = self.packs.digests()
        self._viewer = viewer
        self._drives_robots = MISSIONS in served
        # A process that only plans keeps nothing in the data folder.
        self._lock = lock_folder(settings.data) if self._drives_robots else None
        self.token = settings.resolved_token() if self._drives_robots else ""
        self._running = RunningWorlds(worlds, agents=self._agents_of, listen=self._listen)
        self._given = tuple(self._running)
        files = {name: world.file for name, world in self._running.items()}
        self.clocks: Mapping[str, Clock] = self._running.each(lambda world: world.clock)
        self.planner_ready: Future[bool] = Future()
        """Done once the first planning process can plan; raises Unavailable if none starts."""
        self._owns_worker = worker is None
        self._worker = worker or PlanningWorker(
            partial(make_engine, knowledge_bases=self.packs.knowledge_bases),
            processes=settings.planning_processes,
            memory_mb=settings.planning_memory_mb,
            tell=tell,
            compilation=compilation,
        )
        self._compilation = compilation
        self._wire_store(served, files)
        self._wire_worlds(host)
        self._wire_robots()
        self._wire_planning()
        self._wire_missions()
        self._wire_recordings()

    def _wire_store(self, served: Collection[Queue], files: Mapping[str, WorldFile]) -> None:
        """The database, the durable workflows, and the registry of the processes that share them."""
        settings = self.settings
        self.database = Database(settings.resolved_database_url())
        migrate(self.database)
        self._files = WorldDirectory(self.database, files)
        with self.database.write() as session:
            self._files.start(session)
        self.events = EventLog(self.database)
        knowledge_base = self.packs.knowledge_base()
        self.workflows = Workflows(settings.resolved_database_url(), serves=served)
        plan_nets = PlanNets(knowledge_base)
        self.core = Core(
            database=self.database,
            events=self.events,
            facts=FactStore(self.events, knowledge_base),
            workflows=self.workflows,
            knowledge_base=knowledge_base,
            plan_nets=plan_nets,
            reservations=Reservations(plan_nets),
        )
        self.executors = ExecutorRegistry(
            self.database,
            self.workflows,
            serves=[queue.name for queue in served],
            worlds=self._running if self._drives_robots else (),
            planning=self._planning_status,
            packs=self._pack_digests,
        )
        self._retention = Retention.of(self.database, self.workflows, settings)

    def _wire_worlds(self, host: WorldHost | None) -> None:
        """Worlds that are added and removed while the service runs."""
        repertoire = self.packs.repertoire()
        self._file_checks = FileChecks(
            tags=repertoire.tags, tuning=repertoire.tuned, rules=rule_check(repertoire)
        )
        self._perceives = repertoire.senses
        self.world_set = WorldSet(
            self.core,
            files=self._files,
            running=self._running,
            host=host,
            checks=self._file_checks,
            limit=self.settings.worlds,
        )
        topics = {**self.workflows.topics, **self.world_set.topics}
        self._notifications = NotificationListener(self.database, topics, wake=self.workflows.wake_here)

    def _wire_robots(self) -> None:
        """The robots' state, and what operators send to robots directly: questions, set-points, tunings, rules."""
        settings = self.settings
        self.board = RobotBoard.of(self._files, clocks=self.clocks, low_battery=settings.low_battery)
        self._files.renewed.append(self.board.renew)
        self._files.removed.append(self.board.forget)
        self.contact = ContactMonitor(self.board, clocks=self.clocks, worlds=self._files)
        self._files.removed.append(self.contact.forget)
        repertoire = self.packs.repertoire()
        self.rules = RuleService(self.core, worlds=self._files, repertoire=repertoire)
        self.breakpoints = BreakpointService(
            self.core, files=self._files, running=self._running, rules=self.rules
        )
        self.questions = Questions(patience_s=settings.answer_patience_s, why_mute=self.breakpoints.why_mute)
        self.worlds = WorldService(
            self.core,
            worlds=self._files,
            clocks=self.clocks,
            status=lambda name: self._running[name].status(),
            find=self.world_set.find,
        )
        keys = KeyFile(settings.robot_keys)
        self._order_signer = OrderSigner(keys.read)
        self._counters = SignatureCounters(self.database)
        self._watches: dict[str, RobotWatch] = {}
        self._announcers: dict[str, RunAnnouncer] = {}
        self.impersonations = Impersonations(self.events, worlds=self._files, keys=keys.read)
        self.robots = RobotDirectory(
            self.core,
            worlds=self._files,
            board=self.board,
            contact=self.contact,
            perceives=self._perceives,
            impersonation=self.impersonations.of,
            stands=self.breakpoints.stands,
        )
        self._paces = self._running.each(lambda world: world.pace)
        self.teleoperation = Teleoperation(self.robots, self._paces)
        self.tunings = TuningService(self.core, worlds=self._files, repertoire=repertoire)
        self.speech = SpeechService(self.core, worlds=self._files, clocks=self.clocks, paces=self._paces)

    def _wire_planning(self) -> None:
        """From a goal to an approved plan."""
        core = self.core
        settings = self.settings
        limits = PlanningLimits.of(settings)
        self._requests = PlanningRequests(core, clocks=self.clocks)
        margin = Margin(
            relative=settings.margin_relative,
            absolute_s=settings.margin_s,
            answers_s=self._files.each(lambda file: file.answer_s),
        )
        calls = LegCalls(core, speech=self.speech, library=self.packs.library())
        self.tenders = Tenders(
            core,
            speech=self.speech,
            worlds=self._files,
            clocks=self.clocks,
            calls=calls,
            requests=self._requests,
        )
        self.plans = PlanApproval(
            core,
            margin=margin,
            requests=self._requests,
            worlds=self._files,
            clocks=self.clocks,
            perceives=self._perceives,
            tenders=self.tenders,
        )
        problems = ProblemBuilder(
            core,
            worlds=self._files,
            clocks=self.clocks,
            points=self.board.points,
            unavailable=self.board.unavailable,
            low_battery=settings.low_battery,
            find=self.world_set.find,
            perceives=self._perceives,
        )
        proposals = Proposals(core, clocks=self.clocks)
        self._waiting_goals = WaitingGoals(core, clocks=self.clocks)
        repairs = RepairTasks(
            core, problems=problems, limits=limits, clocks=self.clocks, tenders=self.tenders
        )
        self.replanning = MissionReplanning(
            core,
            problems=problems,
            tasks=repairs,
            worker=self._worker,
            waiting=self._waiting_goals,
            clocks=self.clocks,
        )
        self._better_plans = BetterPlans(core, replanning=self.replanning)
        self.out_of_service = OutOfService(
            core, clocks=self.clocks, waiting=self._waiting_goals, better_plans=self._better_plans
        )
        self.worlds.numbers_corrected.append(self._waiting_goals.release)
        self.holds = HoldService(core, worlds=self._files, clocks=self.clocks, waiting=self._waiting_goals)
        self._files.removed.append(self.holds.forget)
        self.board.became_available.append(self._waiting_goals.robot_available)
        self.board.became_available.append(self._better_plans.robot_available)
        self.board.unavailability_changed.append(self._waiting_goals.unavailability_changed)
        self._goal_planning = GoalPlanningJob(
            core,
            problems=problems,
            proposals=proposals,
            waiting=self._waiting_goals,
            worker=self._worker,
            limits=limits,
            approval=self.plans,
            tenders=self.tenders,
            requests=self._requests,
        )
        self._joint_goals = JointGoals(
            core,
            worlds=self._files,
            problems=problems,
            proposals=proposals,
            approval=self.plans,
            worker=self._worker,
            limits=limits,
            at_most=settings.joint_goals,
        )
        self._recovery = RecoveryJob(
            core,
            tasks=repairs,
            proposals=proposals,
            worker=self._worker,
            clocks=self.clocks,
            requests=self._requests,
            approval=self.plans,
            out_of_service=self.out_of_service,
            peripherals=lambda world: [one.name for one in self._files[world].peripherals],
            waiting=self._waiting_goals,
            tenders=self.tenders,
        )
        self.alternatives = Alternatives(core, problems=problems)
        self._alternatives_job = AlternativesJob(
            core, problems=problems, proposals=proposals, worker=self._worker, limits=limits
        )
        self.missions = MissionService(core)
        self.explanations = Explanations(core, problems=problems, worker=self._worker, limits=limits)
        self.export = PlanExport(core, problems=problems)
        self.plan_bids = PlanBids(core, speech=self.speech, worlds=self._files, calls=calls)
        self.goals = GoalService(
            core,
            world=self.worlds.world,
            clocks=self.clocks,
            limits=limits,
            open_goals=settings.open_goals,
            verbs=self.packs.verbs(),
            requests=self._requests,
            holds=self.holds,
            paces=self._paces,
            tenders=self.tenders,
        )
        self._hold_watch = HoldWatch(core, worlds=self._files, goals=self.goals)
        self._files.removed.append(self._hold_watch.forget)
        self._charge_watch = ChargeWatch(
            core, worlds=self._files, goals=self.goals, low_battery=settings.low_battery
        )
        self._files.removed.append(self._charge_watch.forget)

    def _wire_missions(self) -> None:
        """From an approved plan to the mission's end."""
        core = self.core
        self.lost_robots = LostRobots(core, clocks=self.clocks, board=self.board, waiting=self._waiting_goals)
        self.world_changes = WorldChanges(
            core,
            worlds=self._files,
            clocks=self.clocks,
            waiting=self._waiting_goals,
            checks=self._file_checks,
            is_connected=self.board.is_connected,
            perceives=self._perceives,
        )
        self.roles = RoleService(
            core,
            worlds=self._files,
            rules=self.rules,
            changes=self.world_changes,
            waiting=self._waiting_goals,
        )
        self.embodiments = EmbodimentService(
            core,
            worlds=self._files,
            clocks=self.clocks,
            changes=self.world_changes,
            is_connected=self.board.is_connected,
            is_simulated=self._is_simulated,
        )
        self.factsheets = Factsheets(
            core,
            worlds=self._files,
            clocks=self.clocks,
            changes=self.world_changes,
            admits_all=self.settings.admission == "all",
        )
        plausibility = Plausibility(
            core,
            worlds=self._files,
            clocks=self.clocks,
            lags_s=self._running.each(lambda world: world.lag_s),
            board=self.board,
        )
        self.reports = MissionReports(
            core,
            waiting=self._waiting_goals,
            plausibility=plausibility,
            changes=self.world_changes,
            factsheets=self.factsheets,
        )
        self.dialogues = DialogueService(
            core,
            worlds=self._files,
            robots=self.robots,
            board=self.board,
            missions=self.missions,
            speech=self.speech,
            repertoire=self.packs.repertoire(),
        )
        repertoires = self._files.each(lambda file: {one.name: one.repertoire for one in file.agents})
        senses = self._files.each(lambda file: restricted_senses(file, core.knowledge_base, self._perceives))
        dispatcher = ScriptDispatcher(
            core,
            library=self.packs.library(),
            repertoires=repertoires,
            senses=senses,
            clearing=self._files.each(lambda file: file.clearing),
            delegating=self._files.each(lambda file: file.delegating),
        )
        self._mission_life = MissionLife(
            core,
            dispatcher=dispatcher,
            times=self._running.each(WorldTime.of),
            patience_s=self.settings.answer_patience_s,
            recovery=RecoverySteps(self.events, requests=self._requests),
            waiting=self._waiting_goals,
            silent_in_s=self.contact.silent_in_s,
            tenders=self.tenders,
            stands=self.breakpoints.stands,
        )

    def _wire_recordings(self) -> None:
        self.recordings = RecordingStore.of(self.settings)
        self._recorder = Recorder(
            self.core,
            recordings=self.recordings,
            board=self.board,
            clocks=self.clocks,
            bodies=recorded_bodies(self.worlds, self.plans),
            executors=self.executors,
            minds=MindSampler(self.questions, is_cheap=self._answers_cheaply),
        )

    def _answers_cheaply(self, robot: str) -> bool:
        """True of a robot whose radio is always in contact and takes a second at most there and back."""
        for file in self._files.values():
            if robot in file.robots_by_name:
                link = file.link_of(file.robot(robot))
                return not link.contacts and link.round_trip_s <= CHEAP_ROUND_TRIP_S
        return False

    def _listen(self, world: RunningWorld) -> None:
        """Receive from a world's fleet; what others publish in robots' names is noticed before."""
        name = world.file.name
        watch = self.impersonations.watch(name, self.board, self._counters.load(name))
        self._watches[name] = watch
        world.listen(watch, watch, self._order_signer)

    def _agents_of(self, world: RunningWorld) -> AgentModels:
        name = world.file.name
        drives_world = partial(self.executors.holds_lease, name)
        each_turn = partial(
            _call_all,
            (
                partial(self._waiting_goals.handle_availability, name),
                partial(self._better_plans.follow, name),
                partial(self._follow_record, name),
                partial(self._record_impersonations, name),
            ),
        )
        if world.driver is not None:
            late = world.late
            run = FleetRun(
                self.core,
                self._files,
                name,
                world.driver,
                waiting=self._waiting_goals,
                holds_lease=drives_world,
                new_run_reason=lambda: "" if late is None else late.new_run_reason,
            )
            each_turn = partial(_call_all, (run.follow, each_turn))
        announcer: RunAnnouncer | None = None
        if isinstance(world.fleet, AnnouncesWorld):
            announcer = RunAnnouncer(
                self.core,
                self._files,
                name,
                world.fleet,
                clock=world.clock,
                holds_lease=drives_world,
                start_new=world.start_new,
            )
            self._announcers[name] = announcer
            each_turn = partial(_call_all, (announcer.follow, each_turn))
        return AgentModels(
            robots=lambda: self._files[name].links,
            link=world.link,
            clock=world.clock,
            database=self.database,
            reports=self.reports,
            board=self.board,
            questions=self.questions,
            teleoperation=self.teleoperation,
            tunings=self.tunings,
            rules=self.rules,
            speech=self.speech,
            readmit=partial(self.lost_robots.restore_in_contact, name),
            record_batteries=BatteryRecord(
                self.core,
                world=name,
                board=self.board,
                clock=world.clock,
                low_battery=self.settings.low_battery,
                bounds=charging_range(self.core.knowledge_base, self.settings.low_battery),
                release=self._waiting_goals.release,
                robots=lambda: self._files[name].robots_by_name,
            ).record,
            world=name,
            has_lease=drives_world,
            each_turn=partial(_call_all, (self._files.follow, each_turn)),
            factsheets=self.factsheets,
            embodiments=self.embodiments,
            foreign=ForeignStates(self.core, worlds=self._files, board=self.board, world=name).due,
            editions=EditionDelivery(
                self.core,
                self._files,
                name,
                run=lambda: _run_of(world),
                is_simulated=partial(self._is_simulated, name),
                clock=world.clock,
                minds=partial(self.embodiments.minds, name),
            ),
        )

    def _is_simulated(self, world: str) -> bool:
        """Whether there is a simulation of the world, or is to be."""
        announcer = self._announcers.get(world)
        return announcer is None or not announcer.is_announcing

    def _record_impersonations(self, world: str) -> None:
        if self.impersonations.has_news(world) and self.executors.holds_lease(world):
            self.impersonations.record(self.database, world)
        if (watch := self._watches.get(world)) is not None and self.executors.holds_lease(world):
            self._counters.save(world, watch.accepted)

    def _follow_record(self, world: str) -> None:
        if self.executors.holds_lease(world):
            self.holds.follow(world)
            self._hold_watch.follow(world)
            self._charge_watch.follow(world)

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
            holds=self.holds,
            alternatives=self.alternatives,
            plans=self.plans,
            explanations=self.explanations,
            plan_bids=self.plan_bids,
            tenders=self.tenders,
            export=self.export,
            missions=self.missions,
            replanning=self.replanning,
            worlds=self.worlds,
            world_set=self.world_set,
            world_changes=self.world_changes,
            roles=self.roles,
            embodiments=self.embodiments,
            sensor_sources=SensorSources(worlds=self._files, changes=self.world_changes),
            factsheets=self.factsheets,
            robots=self.robots,
            questions=self.questions,
            tunings=self.tunings,
            rules=self.rules,
            breakpoints=self.breakpoints,
            speech=self.speech,
            dialogues=self.dialogues,
            lost_robots=self.lost_robots,
            out_of_service=self.out_of_service,
            teleoperation=self.teleoperation,
            recordings=self.recordings,
            executors=self.executors,
            packs=[contents_of(pack) for pack in self.packs.packs],
            waits_for=self._waits_for,
            compilation=self._stage,
            other_packs=self._other_packs,
            invalid_messages=self._invalid_messages,
            link_faults=self._link_faults,
        )
        return build_api(services, viewer=self._viewer, static=WEB)

    def _stage(self) -> Stage:
        return Stage.COMPILED if self._compilation is None else self._compilation.stage

    def _planning_status(self) -> Mapping[str, Any] | None:
        return self._worker.status().model_dump(mode="json") if self.settings.planning_processes else None

    def _other_packs(self, executors: Sequence[Executor]) -> Sequence[str]:
        """Which executors and fleets run other domain packs than this process, in words."""
        theirs = {f"executor {one.id} on {one.host}": one.packs for one in executors}
        for name, world in self._running.items():
            if isinstance(fleet := world.fleet, DeclaresPacks):
                theirs[f"the fleet of {name}"] = fleet.packs
        found = ((who, difference(self._pack_digests, packs)) for who, packs in theirs.items() if packs)
        return [f"{who}: {words}" for who, words in found if words]

    def _link_faults(self) -> Mapping[str, tuple[str, str]]:
        return {
            name: (fault.value, world.fault_words())
            for name, world in sorted(self._running.items())
            if (fault := world.fault) is not None
        }

    def _invalid_messages(self) -> Mapping[str, Rejected]:
        found: dict[str, Rejected] = {}
        for name, world in sorted(self._running.items()):
            link = world.fleet
            if isinstance(link, RejectsMessages) and link.rejected is not None:
                found[name] = link.rejected
        return found

    def _waits_for(self) -> str:
        return "" if self.planner_ready.done() else f"the planner is starting: {self._worker.doing}"

    def start(self) -> None:
        """Start or resume the worlds, start the workflows, and connect to the robots.

        The planner warms up in the background: missions do not need it, and goals wait for it.
        """
        self.planner_ready = self._worker.warm_up()
        self.world_set.restore()
        simulated = [name for name, world in self._running.items() if world.fleet is None]
        self.executors.register(simulated if self._drives_robots else ())
        for words in self._other_packs([one for one in self.executors.executors() if one.alive]):
            logger.error("give every process the same packs (--pack, MACTA_PACKS): %s", words)
        # Also worlds that another process drives: it may end before it has recorded them.
        driven = list(self._running.values()) if self._drives_robots else []
        with self.database.write() as session:
            for world in driven:
                start_world(session, self.core, world, self._files[world.file.name])
            if not self.database.shared:
                end_missions_of_absent_worlds(session, self.core, self._files.keys())
        self._start_workflows()
        self.executors.start()
        self._notifications.start()
        for name in self._given:
            self._running.start(name)
        self.world_set.start()
        with self.database.write() as session:
            for world in driven:
                self._waiting_goals.release(session, world.file.name)
        self._retention.start()
        self._recorder.start()
        for name in self._given:
            self._running.resume(name)

    def _start_workflows(self) -> None:
        workflows = self.core.workflows
        workflows.register(PLAN_GOAL, self._goal_planning.run)
        workflows.register(FIND_ALTERNATIVES, self._alternatives_job.run)
        workflows.register(RECOVER_MISSION, self._recovery.run)
        workflows.register(SEEK_BETTER_PLANS, self._better_plans.run)
        plan_waiting = partial(
            self._waiting_goals.run, plan=self._goal_planning.run, together=self._joint_goals.plan
        )
        workflows.register(PLAN_WAITING, plan_waiting)
        workflows.register(MISSION_LIFE, self._mission_life.run)
        workflows.launch()

    def close(self) -> None:
        self.stopping.set()
        self._retention.close()
        self._recorder.close()
        self.world_set.close()
        self._running.close()
        self._notifications.close()
        self.executors.stop()
        self.core.workflows.close()
        self.executors.close()
        self._running.end()
        if self._owns_worker:
            self._worker.close()
        self.database.close()
        if self._lock is not None:
            self._lock.close()

    def __enter__(self) -> "Service":
        try:
            self.start()
        except BaseException:
            self.close()  # also after KeyboardInterrupt, so that no process is left behind
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _run_of(world: RunningWorld) -> str | None:
    """The run that messages are exchanged with now."""
    return world.run if world.driver is None else world.driver.taken_up


def _call_all(functions: Sequence[Callable[[], None]]) -> None:
    for function in functions:
        function()
