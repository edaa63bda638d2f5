"""The services behind missions on a real database, without threads, workflows and robots: a test calls each step."""

from collections.abc import Callable, Mapping
from math import inf
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.agents import RobotBoard
from app.agents.agent_models import Reception
from app.agents.speech import SpeechService
from app.core import Core
from app.domain.mission_organiser import Library, Margin, load_library
from app.domain.world_model.senses import restricted_senses
from app.missions.dispatch import ScriptDispatcher
from app.missions.factsheets import Factsheets
from app.missions.life import MissionLife, WorldTime
from app.missions.lost_robots import LostRobots
from app.missions.mission_service import MissionService
from app.missions.out_of_service import OutOfService
from app.missions.plausibility import Plausibility
from app.missions.recovery import RecoveryJob, RecoverySteps
from app.missions.repair_tasks import RepairTasks
from app.missions.replanning import MissionReplanning
from app.missions.reports import MissionReports
from app.missions.world_changes import WorldChanges
from app.missions.world_set import FileChecks
from app.missions.world_start import start_world_run
from app.planning.approval import PlanApproval
from app.planning.goal_planning import GoalPlanningJob
from app.planning.leg_calls import LegCalls
from app.planning.limits import PlanningLimits
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.work import Solution, Solutions, WorkResult
from app.planning.problem_builder import ProblemBuilder
from app.planning.proposals import Proposals
from app.planning.requests import PlanningRequests
from app.planning.tenders import Tenders
from app.planning.waiting_goals import WaitingGoals
from app.store import Database, GoalRow, MissionRow, ScriptRow
from app.store.editions import WorldDirectory
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from app.workflows.mission_wakeups import wake_missions
from planner import UNOBSERVED, PlanNet, PlanningRequest
from planner.repair import Course, Repair
from robots.clock import ManualClock
from robots.wire import Message, SymbolicFact
from tests.app.sample_store import Store
from tests.app.scripted import ScriptedEngine, ScriptedWorker
from tests.app.stepped_clock import SteppedClock

WORLD = "sample_store"
PATIENCE_S = 10.0


def at_home(robot: str) -> tuple[SymbolicFact, ...]:
    """What a robot perceives that stands where it started, with nothing in its gripper."""
    return (
        SymbolicFact(predicate="robot_attribute", args=(robot, "gripper", "empty")),
        SymbolicFact(predicate="near", args=(robot, f"home_{robot}")),
    )


class NoWorkflows:
    """Stands for durable workflows; the test does what they would."""

    def start(self, *_: object, **__: object) -> None: ...

    def wake(self, *_: object, **__: object) -> None: ...


class MissionServices:
    """One process on a database, with the sample store and a plan for its main job."""

    def __init__(
        self,
        database_url: str,
        *,
        store: Store,
        plan_net: PlanNet,
        library: Library,
        clock: ManualClock,
        wall_clock: SteppedClock,
        silent: Mapping[str, bool],
        worker: PlanningWorker | None = None,
        speech: Callable[[Core], SpeechService] | None = None,
    ) -> None:
        """
        :param silent: the robots that are silent for longer than their radio explains.
        :param speech: with it, robots bid for goals with the allocation `contract_net`.
        """
        self._clock = clock
        self.at_breakpoint = False
        """Whether the world stands at a breakpoint."""
        self.database = Database(database_url)
        self.store = store
        events = EventLog(self.database)
        nets = PlanNets(store.base)
        self.core = Core(
            database=self.database,
            events=events,
            facts=FactStore(events, store.base),
            workflows=NoWorkflows(),  # type: ignore[arg-type]
            knowledge_base=store.base,
            plan_nets=nets,
            reservations=Reservations(nets),
        )
        clocks = {WORLD: clock}
        files = WorldDirectory(self.database, {WORLD: store.world})
        self.board = RobotBoard.of(files, clocks=clocks, low_battery=0.1)
        self.waiting = WaitingGoals(self.core, clocks=clocks, wall_clock=wall_clock)
        requests = PlanningRequests(self.core, clocks=clocks)
        self.tenders: Tenders | None = None
        if speech is not None:
            spoken = speech(self.core)
            calls = LegCalls(self.core, speech=spoken, library=library)
            self.tenders = Tenders(
                self.core, speech=spoken, worlds=files, clocks=clocks, calls=calls, requests=requests
            )
        self.plans = PlanApproval(
            self.core, margin=Margin(), requests=requests, worlds=files, clocks=clocks, tenders=self.tenders
        )
        self._engine = ScriptedEngine(plan_net)
        problems = ProblemBuilder(
            self.core,
            worlds=files,
            clocks=clocks,
            points=self.board.points,
            unavailable=self.board.unavailable,
        )
        limits = PlanningLimits()
        planning: dict[str, Any] = {
            "proposals": Proposals(self.core, clocks=clocks),
            "worker": worker or ScriptedWorker(plan_net),
            "approval": self.plans,
            "tenders": self.tenders,
            "waiting": self.waiting,
            "requests": requests,
        }
        tasks = RepairTasks(self.core, problems=problems, limits=limits, clocks=clocks, tenders=self.tenders)
        self._goals = GoalPlanningJob(self.core, problems=problems, limits=limits, **planning)
        self.recovery = RecoveryJob(
            self.core,
            tasks=tasks,
            clocks=clocks,
            clock=wall_clock,
            out_of_service=OutOfService(self.core, clocks=clocks, waiting=self.waiting),
            peripherals=lambda world: (),
            **planning,
        )
        self.missions = MissionService(self.core)
        self.replanning = MissionReplanning(
            self.core,
            problems=problems,
            tasks=tasks,
            worker=planning["worker"],
            waiting=self.waiting,
            clocks=clocks,
        )
        plausibility = Plausibility(
            self.core, worlds=files, clocks=clocks, lags_s={WORLD: lambda: 0.0}, board=self.board
        )
        checks = FileChecks(tags=(), tuning=lambda tuning: None, rules=lambda rules: None)
        self.changes = WorldChanges(
            self.core, worlds=files, clocks=clocks, waiting=self.waiting, checks=checks
        )
        self.reports = MissionReports(
            self.core,
            waiting=self.waiting,
            plausibility=plausibility,
            changes=self.changes,
            factsheets=Factsheets(self.core, worlds=files, clocks=clocks, changes=self.changes),
        )
        self.lost = LostRobots(
            self.core, clocks=clocks, board=self.board, waiting=self.waiting, wall_clock=wall_clock
        )
        self.life = MissionLife(
            self.core,
            dispatcher=ScriptDispatcher(
                self.core,
                library=library,
                repertoires={WORLD: store.repertoires},
                senses={WORLD: restricted_senses(store.world, store.base)},
                clearing={WORLD: store.world.clearing},
                delegating={WORLD: store.world.delegating},
            ),
            times={WORLD: WorldTime(clock=clock, rate=lambda: None)},
            patience_s=PATIENCE_S,
            recovery=RecoverySteps(events, requests=requests),
            waiting=self.waiting,
            silent_in_s=lambda robot: 0.0 if silent.get(robot) else inf,
            tenders=self.tenders,
            stands=lambda world: self.at_breakpoint,
            clock=wall_clock,
        )

    def start_world(self, run: str = "run-1") -> None:
        with self.database.write() as session:
            start_world_run(session, self.core, self.store.world, run)

    def plan_once(self, goal_id: str) -> GoalRow:
        """What the goal's durable job does; the goal after it."""
        self._goals.plan_once(goal_id)
        return self.read(lambda session: session.get_one(GoalRow, goal_id))  # type: ignore[no-any-return]

    def plan(self, goal_id: str = "goal-1", *, recovery: str = "ask", deadline_s: float | None = None) -> str:
        """Submit and plan the main job; the plan's id."""
        with self.database.write() as session:
            goal = GoalRow(
                id=goal_id,
                world=WORLD,
                text="move sample_1 to bay_7",
                goal=[{"predicate": "in", "args": ["sample_1", "bay_7"]}],
                priority=0,
                deadline_at_s=deadline_s,
                auto_approve=False,
                recovery=recovery,
                state="submitted",
                created_by="operator",
            )
            session.add(goal)
            session.flush()
            task = self._goals.begin(session, goal)
            assert task is not None
            self._goals.conclude(session, goal, task, task.work(self._engine, UNOBSERVED))
            assert goal.plan_id is not None, goal.reason
            return goal.plan_id

    def repair(self, mission_id: str, course: Course | None) -> None:
        """Answer the mission's wish for a repair, if it has one, with the main job's plan; without a course with none.

        Nothing is planned: whether the plan fits the world is found out when it is approved.
        """
        with self.database.write() as session:
            mission = self.recovery.load(session, mission_id, lock=True)
            task = self.recovery.begin(session, mission)
            if task is None:
                return
            if course is not None:
                problem = task.problem.problem
                result = self._engine.plan(problem, PlanningRequest(time_limit_s=1.0))
                repair = Repair(course=course, result=result, problem=problem)
                solved = WorkResult[Solutions].solved((Solution(result=result, repair=repair),))
                self.recovery.conclude(session, mission, task, solved)
            else:
                self.recovery.give_up(session, mission, "the planner was unlucky")

    def record(self, message: Message) -> bool:
        """True if it is recorded. It is not heard before it was said: the world's clock goes on until then."""
        said_s = getattr(message.body, "at_s", message.sent_at_s)
        self._clock.advance(max(0.0, said_s - self._clock.now_s()))
        return self.reports.record(message, WORLD) is Reception.RECORDED

    def believe(self, add: str, remove: str = "") -> None:
        """An operator corrects a fact."""
        with self.database.write() as session:
            self.core.facts.change(
                session,
                WORLD,
                add=[self.store.fact(add)],
                remove=[self.store.fact(remove)] if remove else [],
                source="operator",
                at_s=0.0,
                corrects=True,
            )
            wake_missions(session, self.core.workflows, WORLD)

    def stands(self, robot: str, place: str) -> None:
        """A robot that is not at work reports to stand near a place now."""
        with self.database.write() as session:
            self.core.facts.change(
                session,
                WORLD,
                add=[self.store.fact(f"near({robot}, {place})")],
                remove=[self.store.fact(f"near({robot}, home_{robot})")],
                source=f"report of {robot}",
                at_s=self._clock.now_s(),
            )

    def mission(self, mission_id: str) -> MissionRow:
        with self.database.read() as session:
            return session.get_one(MissionRow, mission_id)

    def scripts(self, mission_id: str) -> list[ScriptRow]:
        with self.database.read() as session:
            query = select(ScriptRow).where(ScriptRow.mission_id == mission_id).order_by(ScriptRow.id)
            return list(session.scalars(query))

    def read(self, query: Callable[[Session], Any]) -> Any:
        with self.database.read() as session:
            return query(session)

    def close(self) -> None:
        self.database.close()


def services(
    folder: Path,
    *,
    store: Store,
    clock: ManualClock | None = None,
    wall_clock: SteppedClock | None = None,
    silent: Mapping[str, bool] | None = None,
    worker: PlanningWorker | None = None,
) -> MissionServices:
    """Services on the database in the folder."""
    return MissionServices(
        f"sqlite:///{folder / 'record.sqlite'}",
        store=store,
        plan_net=store.store_sample_1(),
        library=load_library(store.base),
        clock=clock or ManualClock(),
        wall_clock=wall_clock or SteppedClock(),
        silent={} if silent is None else silent,
        worker=worker,
    )
