"""A goal's tender among simulated robots: they answer the service's calls in stepped time."""

from collections.abc import Collection

from app.agents.speech import Speech, SpeechService
from app.core import Core
from app.domain.mission_organiser import load_library
from app.domain.tender_document import TenderBody
from app.planning.tenders import tender_of
from app.store import ConversationRow, GoalRow, ScriptRow
from planner import PlanningEngine
from robots.clock import ManualClock
from robots.wire import BehaviourScript, Message, Performative, ScriptRequest, SpeechAct
from robots.world import WorldFile
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation
from tests.app.missions.mission_services import WORLD, MissionServices
from tests.app.planning.store_engine import StoreEngine
from tests.app.sample_store import Store, said
from tests.app.scripted import InProcessWorker
from tests.app.stepped_clock import SteppedClock

GOAL = "goal-1"
LOOKS_EVERY = 5
"""Control cycles between two looks of the service at what it is to say."""


class Tendering:
    """The sample store's robots in simulation, and a service that plans by rule and speaks with them."""

    def __init__(
        self, database_url: str, world: WorldFile, *, engine: PlanningEngine | None = None, seed: int = 0
    ) -> None:
        """:param engine: plans; None: by rule."""
        self._worker = InProcessWorker(engine or StoreEngine())
        self.world = world
        self.store = Store(world)
        self.database_url = database_url
        self.simulation = Simulation(world, make_agent=behavioural_agent, seed=seed, jitter_m=0.0)
        self.clock = ManualClock()
        """By which the service plans."""
        self.wall_clock = SteppedClock()
        self.heard: dict[str, tuple[str, str]] = {}
        """What robots were told, by the message: the robot, and the performative."""
        self.services = self._start()
        self.services.start_world()

    def _start(self) -> MissionServices:
        return MissionServices(
            self.database_url,
            store=self.store,
            plan_net=self.store.store_sample_1(),
            library=load_library(self.store.base),
            clock=self.clock,
            wall_clock=self.wall_clock,
            silent={},
            worker=self._worker,
            speech=self._speech,
        )

    def _speech(self, core: Core) -> SpeechService:
        self.speech = SpeechService(core, worlds={WORLD: self.world}, clocks={WORLD: self.simulation.clock})
        return self.speech

    def restart(self) -> None:
        """The service ends and starts again; the robots go on."""
        self.services.database.close()
        self.services = self._start()

    def submit(self, *facts: str, id: str = GOAL, **more: object) -> GoalRow:
        """State a goal and make its first plan; the goal."""
        usual = {
            "id": id,
            "world": WORLD,
            "text": " and ".join(facts),
            "goal": [said(one).model_dump() for one in facts],
            "priority": 0,
            "auto_approve": False,
            "recovery": "auto",
            "state": "submitted",
            "created_by": "operator",
            "allocation": "contract_net",
        }
        with self.services.database.write() as session:
            session.add(GoalRow(**{**usual, **more}))
        return self.services.plan_once(id)

    def goal(self, goal_id: str = GOAL) -> GoalRow:
        return self.services.read(lambda session: session.get_one(GoalRow, goal_id))  # type: ignore[no-any-return]

    @property
    def tender(self) -> TenderBody:
        tender = tender_of(self.goal())
        assert tender is not None
        return tender

    def plan(self, *facts: str, deaf: Collection[str] = ()) -> TenderBody:
        """State a goal, have robots bid for it and plan it; its tender."""
        self.submit(*facts)
        self.run(1.0, deaf=deaf)
        self.services.plan_once(GOAL)
        return self.tender

    def approve(self) -> str:
        """Approve the goal's plan; the mission, once its scripts are made."""
        plan_id = self.goal().plan_id
        assert plan_id is not None
        _, mission_id = self.services.plans.approve(plan_id, actor="operator")
        self.services.life.monitor(mission_id)
        return mission_id

    def run(self, seconds: float, *, deaf: Collection[str] = (), mute: Collection[str] = ()) -> None:
        """Let the world's time pass. :param deaf: robots that hear nothing. :param mute: robots that are not heard."""
        for cycle in range(round(20 * seconds)):
            for one in self.speech.due(WORLD) if cycle % LOOKS_EVERY == 0 else ():
                if one.robot not in deaf:
                    self._say(one)
                if one.ends:
                    self.speech.was_said(one)
            self.simulation.step_control_cycle()
            for message in self.simulation.link.receive():
                if isinstance(message.body, SpeechAct) and message.sender not in mute:
                    for answer in self.speech.hear(WORLD, message, message.body):
                        self._say(answer)

    def give(self, scripts: Collection[ScriptRow]) -> None:
        """Send robots their scripts."""
        for row in scripts:
            body = ScriptRequest(script=BehaviourScript.model_validate(row.body))
            self._send(row.robot, Performative.REQUEST, body, f"{row.id}:request", None)

    def _say(self, one: Speech) -> None:
        self.heard[one.message_id] = (one.robot, one.performative.value)
        self._send(one.robot, one.performative, one.act, one.message_id, one.in_reply_to)

    def _send(
        self,
        robot: str,
        performative: Performative,
        body: SpeechAct | ScriptRequest,
        message_id: str,
        in_reply_to: str | None,
    ) -> None:
        self.simulation.link.send(
            Message(
                id=message_id,
                performative=performative,
                sender="service",
                receiver=robot,
                sent_at_s=self.simulation.clock.now_s(),
                in_reply_to=in_reply_to,
                body=body,
            )
        )

    def conversations(self, *, about: str = GOAL) -> list[ConversationRow]:
        """What was said about the goal, or the mission."""
        return self.services.read(  # type: ignore[no-any-return]
            lambda session: (
                session.query(ConversationRow)
                .filter_by(about=about)
                .order_by(ConversationRow.opened_at)
                .all()
            )
        )

    def close(self) -> None:
        self.simulation.close()
        self.services.database.close()
