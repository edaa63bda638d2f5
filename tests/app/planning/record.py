"""A record of the sample store without a service: what the jobs of planning read and write."""

from collections.abc import Callable, Mapping
from typing import Any

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.ids import new_id
from app.domain.lifecycles.goal import GoalState
from app.planning.problem_builder import ProblemBuilder
from app.store import Database, GoalRow, WorldRow
from app.store.editions import WorldDirectory
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from robots.clock import ManualClock
from tests.app.sample_store import Store, said

STORE = Store()
WORLD = "sample_store"


class RecordedWorkflows:
    """Records which workflows are started, and runs none."""

    def __init__(self) -> None:
        self.started: list[tuple[str, str]] = []
        self.has_all_ended = False

    def has_ended(self, workflow_id: str) -> bool:
        return self.has_all_ended

    def start(
        self,
        session: Session,
        queue: object,
        name: str,
        workflow_id: str,
        subject: str,
        *,
        rank: int | None = None,
    ) -> None:
        self.started.append((name, subject))


class StoreRecord:
    """The sample store at 100 s of its time."""

    def __init__(
        self,
        database: Database,
        *,
        unavailable: Callable[[str], Mapping[str, str]],
        reservations: Reservations | None = None,
    ) -> None:
        self.database = database
        self.events = EventLog(database)
        self.workflows = RecordedWorkflows()
        nets = PlanNets(STORE.base)
        self.core = Core(
            database=database,
            events=self.events,
            facts=FactStore(self.events, STORE.base),
            workflows=self.workflows,  # type: ignore[arg-type]
            knowledge_base=STORE.base,
            plan_nets=nets,
            reservations=reservations or Reservations(nets),
        )
        clock = ManualClock()
        clock.advance(100.0)
        self.clocks = {WORLD: clock}
        self.problems = ProblemBuilder(
            self.core,
            worlds=WorldDirectory(database, {WORLD: STORE.world}),
            clocks=self.clocks,
            points=lambda _: {},
            unavailable=unavailable,
        )

    def add_world(self, session: Session) -> None:
        session.add(WorldRow(id=WORLD, title="Store", layout={}, releases=7))
        session.flush()
        self.core.facts.change(session, WORLD, add=STORE.facts, source="file", at_s=0.0)

    def add_goal(self, text: str = "in(sample_1, bay_7)", **more: Any) -> str:
        """Record a submitted goal; its id."""
        usual = {
            "id": new_id("goal"),
            "world": WORLD,
            "text": text,
            "goal": [said(text).model_dump()],
            "priority": 0,
            "auto_approve": False,
            "state": GoalState.SUBMITTED,
            "created_by": "me",
        }
        with self.database.write() as session:
            goal = GoalRow(**{**usual, **more})
            session.add(goal)
            session.flush()
            return goal.id

    def goal(self, goal_id: str) -> GoalRow:
        with self.database.read() as session:
            return session.get_one(GoalRow, goal_id)
