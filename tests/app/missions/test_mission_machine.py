"""Random commands, reports, silences and restarts: whatever happens, a mission keeps to its life cycle and ends truly.

Reports arrive late, twice and in any order. The model knows what was said and ordered; it derives from that what may be
recorded, without the service's rules. Time is stepped.
"""

import shutil
from collections import defaultdict
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from sqlalchemy import select

from app.domain.errors import Conflict
from app.domain.recovery_rules import Policy
from app.store import EventRow, FactRow, GoalRow, MissionRow, PlanRow, ScriptRow
from app.store.migrate import migrate
from robots.clock import ManualClock
from robots.wire import (
    Acknowledgement,
    Body,
    ControlVerb,
    FailureCategory,
    Message,
    PacketReport,
    PacketState,
    Performative,
    Refusal,
    ScriptReport,
    ScriptState,
    StatusReport,
)
from tests.app.missions.mission_services import WORLD, MissionServices, at_home, services
from tests.app.sample_store import Store
from tests.app.stepped_clock import SteppedClock

STORE = Store()
ENDED = {"completed", "partially_completed", "failed", "cancelled"}
OVER = {"finished", "failed", "cancelled"}
ROBOTS = ("yard_1", "store_2")
SECONDS = (0.0, 1.0, 30.0, 300.0)


@cache
def template() -> Path:
    """A database with the world and a plan for its main job; copied for each run."""
    folder = Path(mkdtemp(prefix="macta-machine-"))
    made = services(folder, store=STORE)
    migrate(made.database)
    made.start_world()
    made.plan()
    made.close()
    return folder / "record.sqlite"


class MissionMachine(RuleBasedStateMachine):
    """One mission of two robots, its operator and its monitor."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = TemporaryDirectory(prefix="macta-machine-")
        shutil.copy(template(), self.folder.name)
        self.clock = ManualClock()
        self.wall_clock = SteppedClock()
        self.silent: dict[str, bool] = {}
        self.services = self.opened()
        # The model: what was said and ordered.
        self.said: list[Message] = []
        self.recorded: set[str] = set()
        self.packets: dict[str, dict[str, tuple[float, str]]] = defaultdict(dict)
        self.over: dict[str, str] = {}
        self.reached: dict[str, int] = defaultdict(int)
        self.paused = False
        self.cancelled = False
        self.ended: tuple[str, float | None] | None = None
        self.orders: dict[str, int] = defaultdict(int)

    def opened(self) -> MissionServices:
        return services(
            Path(self.folder.name),
            store=STORE,
            clock=self.clock,
            wall_clock=self.wall_clock,
            silent=self.silent,
        )

    # What is recorded

    @property
    def mission(self) -> MissionRow:
        return self.services.mission(self.id)

    @property
    def scripts(self) -> list[ScriptRow]:
        return self.services.scripts(self.id)

    def script(self, robot: str) -> ScriptRow | None:
        """What the robot is to carry out now."""
        plan_id = self.mission.plan_id
        found = (one for one in self.scripts if (one.robot, one.plan_id) == (robot, plan_id))
        return next(found, None)

    def open_plans(self) -> list[str]:
        query = select(PlanRow.id).where(PlanRow.state == "proposed")
        return list(self.services.read(lambda session: session.scalars(query).all()))

    def believed(self) -> set[str]:
        return set(self.services.read(lambda session: session.scalars(select(FactRow.atom)).all()))

    # Operators

    @initialize(policy=st.sampled_from(Policy), deadline_s=st.sampled_from([None, 20.0]))
    def approve_the_plan(self, policy: Policy, deadline_s: float | None) -> None:
        with self.services.database.write() as session:
            goal = session.get_one(GoalRow, "goal-1")
            goal.recovery = policy
            goal.deadline_at_s = deadline_s
        (plan,) = self.open_plans()
        _, self.id = self.services.plans.approve(plan, actor="operator")

    @rule()
    def pause(self) -> None:
        refused = self.refused(lambda: self.services.missions.pause(self.id, "operator", ""))
        assert refused == (self.ended is not None or self.cancelled)
        self.paused = self.paused or not refused

    @rule()
    def resume(self) -> None:
        stuck = self.mission.recovery_step == "stuck"
        refused = self.refused(lambda: self.services.missions.resume(self.id, "operator", ""))
        assert refused == (self.ended is not None or not (self.paused or stuck))
        self.paused = self.paused and refused

    @rule(often=st.sampled_from([False, False, True]))
    def cancel(self, often: bool) -> None:
        if not often:  # most runs are to come further
            return
        refused = self.refused(lambda: self.services.missions.cancel(self.id, "operator", ""))
        assert refused == (self.ended is not None and not self.cancelled)
        self.cancelled = self.cancelled or not refused

    @rule(policy=st.sampled_from(Policy))
    def set_recovery(self, policy: Policy) -> None:
        refused = self.refused(lambda: self.services.missions.set_recovery(self.id, policy, "operator"))
        assert refused == (self.ended is not None)

    @precondition(lambda self: self.open_plans())
    @rule(approves=st.booleans())
    def decide(self, approves: bool) -> None:
        """A repair that waits for a decision is approved, unless the world has changed, or rejected."""
        (plan,) = self.open_plans()
        assert self.mission.recovery_step == "deciding"
        revision = self.mission.revision
        if not approves:
            self.services.plans.reject(plan, actor="operator")
            assert self.mission.recovery_step == "ending"
        elif self.refused(lambda: self.services.plans.approve(plan, actor="operator")):
            assert self.mission.recovery_step != "deciding"
        else:
            assert self.mission.revision == revision + 1
        assert plan not in self.open_plans()

    @rule(there=st.booleans())
    def correct_the_facts(self, there: bool) -> None:
        """The sample lies elsewhere, says the operator, or at the door after all."""
        places = ("door_1", "door_2")
        held = [atom for atom in self.believed() if atom.startswith("object_position(sample_1")]
        if not any(place in atom for atom in held for place in places):
            return
        now, then = places if there else places[::-1]
        self.services.believe(f"in(sample_1, {now})", f"in(sample_1, {then})")

    @rule(robot=st.sampled_from(ROBOTS))
    def lose(self, robot: str) -> None:
        self.services.lost.declare_lost(WORLD, robot, actor="operator", comment="")

    @rule(robot=st.sampled_from(ROBOTS))
    def find(self, robot: str) -> None:
        self.refused(lambda: self.services.lost.declare_found(WORLD, robot, actor="operator", comment=""))

    def refused(self, command: object) -> bool:
        assert callable(command)
        try:
            command()
        except Conflict:
            return True
        return False

    # Robots

    @rule(
        robot=st.sampled_from(ROBOTS),
        agrees=st.sampled_from([True, True, True, False]),
        arrives=st.booleans(),
    )
    def answer_the_script(self, robot: str, agrees: bool, arrives: bool) -> None:
        if (script := self.script(robot)) is not None and script.delivery == "pending":
            self.answer(script, "request", agrees=agrees, arrives=arrives)

    @rule(robot=st.sampled_from(ROBOTS), agrees=st.sampled_from([True, True, False]), arrives=st.booleans())
    def answer_the_order(self, robot: str, agrees: bool, arrives: bool) -> None:
        for script in self.scripts:
            if script.robot == robot and script.control is not None:
                self.answer(
                    script, f"{script.control}:{script.control_number}", agrees=agrees, arrives=arrives
                )
                if script.control == ControlVerb.CANCEL and agrees and script.id not in self.over:
                    self.end(script, ScriptState.CANCELLED, arrives=arrives)

    @rule(robot=st.sampled_from(ROBOTS), arrives=st.booleans())
    def answer_the_question(self, robot: str, arrives: bool) -> None:
        for script in self.scripts:
            if script.robot == robot and script.question is not None:
                state = ScriptState(self.over.get(script.id, "running"))
                status = StatusReport(
                    script_id=script.id, state=state, at_s=self.clock.now_s(), order=script.orders
                )
                self.say(script, status, script.question, arrives=arrives)

    @rule(
        robot=st.sampled_from(ROBOTS), steps=st.integers(1, 4), arrives=st.sampled_from([True, True, False])
    )
    def work(self, robot: str, steps: int, arrives: bool) -> None:
        """The robot begins its next packet, or ends it, or with the last one its script."""
        for _ in range(steps):
            script = self.script(robot)
            if script is None or script.delivery != "acknowledged" or script.id in self.over:
                return
            self.clock.advance(1.0)
            names = [packet["id"] for packet in script.body["packets"]]
            step = self.reached[script.id]
            self.reached[script.id] += 1
            if step == 2 * len(names):
                self.end(script, ScriptState.FINISHED, arrives=arrives)
            else:
                state = PacketState.FINISHED if step % 2 else PacketState.RUNNING
                self.report(script, names[step // 2], state, arrives=arrives)

    @rule(robot=st.sampled_from(ROBOTS), arrives=st.booleans())
    def fail(self, robot: str, arrives: bool) -> None:
        script = self.script(robot)
        if script is not None and script.delivery == "acknowledged" and script.id not in self.over:
            step = min(self.reached[script.id] // 2, len(script.body["packets"]) - 1)
            self.report(script, script.body["packets"][step]["id"], PacketState.FAILED, arrives=arrives)
            self.end(script, ScriptState.FAILED, arrives=arrives)

    @precondition(lambda self: self.said)
    @rule(data=st.data())
    def arrive(self, data: st.DataObject) -> None:
        """Something that was said arrives: late, or again."""
        self.deliver(data.draw(st.sampled_from(self.said)))

    @rule(robot=st.sampled_from(ROBOTS))
    def fall_silent_or_speak_again(self, robot: str) -> None:
        self.silent[robot] = not self.silent.get(robot, False)

    def answer(self, script: ScriptRow, request: str, *, agrees: bool, arrives: bool) -> None:
        answer = Acknowledgement(script_id=script.id) if agrees else Refusal(script_id=script.id, reason="no")
        self.say(script, answer, f"{script.id}:{request}", arrives=arrives)

    def report(self, script: ScriptRow, packet: str, state: PacketState, *, arrives: bool) -> None:
        report = PacketReport(
            script_id=script.id, packet_id=packet, state=state, at_s=self.clock.now_s(), events=(), detail=""
        )
        self.say(script, report, arrives=arrives)

    def end(self, script: ScriptRow, state: ScriptState, *, arrives: bool) -> None:
        category = FailureCategory.ROBOT if state is ScriptState.FAILED else None
        report = ScriptReport(
            script_id=script.id,
            state=state,
            at_s=self.clock.now_s(),
            category=category,
            perceived=at_home(script.robot) if self.reached[script.id] < 2 else (),
        )
        self.say(script, report, arrives=arrives)

    def say(self, script: ScriptRow, body: Body, in_reply_to: str | None = None, *, arrives: bool) -> None:
        message = Message(
            performative=Performative.INFORM,
            sender=script.robot,
            receiver="service",
            sent_at_s=self.clock.now_s(),
            in_reply_to=in_reply_to,
            body=body,
        )
        self.said.append(message)
        if arrives:
            self.deliver(message)

    def deliver(self, message: Message) -> None:
        assert self.services.record(message) == (message.id not in self.recorded)
        if message.id not in self.recorded:
            self.recorded.add(message.id)
            self.expect(message.body)

    def expect(self, body: Body) -> None:
        """What is known after a message that was not heard before."""
        if isinstance(body, PacketReport):
            known_s, known = self.packets[body.script_id].get(body.packet_id, (0.0, ""))
            if known not in ("finished", "failed") and body.at_s >= known_s:
                self.packets[body.script_id][body.packet_id] = (body.at_s, body.state.value)
        if isinstance(body, ScriptReport) and body.script_id not in self.over:
            self.over[body.script_id] = body.state.value
            if body.state is ScriptState.FINISHED:
                (script,) = (one for one in self.scripts if one.id == body.script_id)
                for packet in script.body["packets"]:
                    if self.packets[script.id].get(packet["id"], (0.0, ""))[1] != "finished":
                        self.packets[script.id][packet["id"]] = (body.at_s, "finished")

    # The service

    @rule(after_s=st.sampled_from(SECONDS))
    def monitor(self, after_s: float) -> None:
        self.clock.advance(after_s)
        self.wall_clock.advance(after_s)
        self.services.life.monitor(self.id)

    @precondition(lambda self: self.mission.recovery_step == "planning")
    @rule(finds_plan=st.sampled_from([True, True, False]))
    def plan_the_repair(self, finds_plan: bool) -> None:
        self.services.repair(self.id, finds_plan=finds_plan)

    @rule()
    def restart(self) -> None:
        self.services.close()
        self.services = self.opened()

    # What must hold

    @invariant()
    def what_was_reported_is_known(self) -> None:
        for script in self.scripts:
            known = {name: (one["at_s"], one["state"]) for name, one in script.packets.items()}
            assert known == self.packets[script.id]
            if script.id in self.over:
                assert script.state == self.over[script.id]
            elif script.state in OVER:  # it was told to drop what it had not agreed to
                assert (script.state, script.delivery) == ("cancelled", "withdrawn")
                self.over[script.id] = script.state

    @invariant()
    def a_mission_that_has_ended_stays_as_it_is(self) -> None:
        mission = self.mission
        goal = self.services.read(lambda session: session.get_one(GoalRow, mission.goal_id))
        if self.ended is not None:
            assert (mission.state, mission.ended_at_s) == self.ended
        elif mission.state in ENDED:
            self.ended = (mission.state, mission.ended_at_s)
            if mission.state == "completed":
                assert any("sample_1, in, bay_7" in atom for atom in self.believed())
            if mission.state == "cancelled":
                assert self.cancelled
        else:
            assert goal.state == "committed"
            assert (mission.state == "paused") == self.paused
        if self.ended is not None:
            assert (goal.state, goal.outcome) == ("finished", mission.state)
            assert mission.recovery_step is None
            assert self.open_plans() == []
        assert mission.cancel_requested == self.cancelled

    @invariant()
    def orders_are_numbered_and_the_last_is_to_stop(self) -> None:
        for script in self.scripts:
            assert script.orders >= self.orders[script.id]
            self.orders[script.id] = script.orders
            if script.stopping:
                assert script.control in (None, "cancel")
            if self.ended is not None and not script.abandoned:
                assert (script.control, script.question, script.clearance) == (None, None, None)
                assert script.delivery != "pending"

    @invariant()
    def only_the_last_attempt_at_recovery_is_open(self) -> None:
        mission = self.mission
        outcomes = [attempt["outcome"] for attempt in mission.attempts]
        assert [attempt["number"] for attempt in mission.attempts] == list(range(1, len(outcomes) + 1))
        assert not {"planning", "proposed"} & set(outcomes[:-1])
        assert mission.tries_left >= 0
        if mission.recovery_step == "planning":
            assert outcomes[-1] == "planning"
        if mission.recovery_step == "deciding":
            assert outcomes[-1] == "proposed"
            assert len(self.open_plans()) == 1

    @invariant()
    def the_last_event_has_the_missions_state(self) -> None:
        query = select(EventRow.data).where(EventRow.subject == self.id).order_by(EventRow.seq.desc())
        told = self.services.read(lambda session: session.scalars(query).all())
        assert next(data["state"] for data in told if "state" in data) == self.mission.state

    def teardown(self) -> None:
        """Once every robot answers, a mission that is cancelled ends."""
        if self.ended is None and hasattr(self, "id"):
            self.cancel(often=True)
            for _ in range(6):
                self.monitor(after_s=300.0)
                for robot in ROBOTS:
                    self.answer_the_script(robot, agrees=False, arrives=True)
                    self.answer_the_order(robot, agrees=True, arrives=True)
            assert self.mission.state in ENDED
        self.services.close()
        self.folder.cleanup()


TestMissionMachine = MissionMachine.TestCase
TestMissionMachine.settings = settings(
    max_examples=15,
    stateful_step_count=30,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
