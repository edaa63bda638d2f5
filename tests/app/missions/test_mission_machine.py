"""Random commands, reports, silences and restarts: whatever happens, a mission keeps to its life cycle and ends truly.

Reports arrive late, twice and in any order. The model knows what was said and ordered; it derives from that what may be
recorded, without the service's rules. Time is stepped.
"""

import shutil
from collections import defaultdict
from collections.abc import Sequence
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
from planner.repair import Course
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
        self.stands: dict[str, ScriptState] = defaultdict(lambda: ScriptState.RUNNING)
        self.is_second_run = False
        self.paused = False
        self.cancelled = False
        self.asked_at: int | None = None
        """The revision of which another plan was asked for, until it is carried out or rejected."""
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

    @initialize(
        policy=st.sampled_from(Policy),
        deadline_s=st.sampled_from([None, 20.0]),
        rounds=st.integers(0, 3),
        failing=st.sampled_from([*ROBOTS, None]),
    )
    def begin(self, policy: Policy, deadline_s: float | None, rounds: int, failing: str | None) -> None:
        """Approve the plan, and let the mission run for a while."""
        with self.services.database.write() as session:
            goal = session.get_one(GoalRow, "goal-1")
            goal.recovery = policy
            goal.deadline_at_s = deadline_s
        (plan,) = self.open_plans()
        _, self.id = self.services.plans.approve(plan, actor="operator")
        self.run_for(rounds, steps=1, course=Course.REPLANNED, failing=failing, arrives=True)

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

    @rule()
    def replan(self) -> None:
        """The operator asks for another plan."""
        before = self.mission
        is_asked = self.asked_at == before.revision
        refused = self.refused(lambda: self.services.replanning.replan(self.id, (), "operator", ""))
        is_busy = is_asked or self.paused or before.state == "recovering"
        assert refused == (self.ended is not None or self.cancelled or is_busy)
        if not refused:
            self.asked_at = before.revision
            assert self.mission.tries_left == before.tries_left + 1

    @precondition(lambda self: self.open_plans())
    @rule(approves=st.booleans())
    def decide(self, approves: bool) -> None:
        """A repair that waits for a decision is approved, unless the world has changed, or rejected."""
        (plan,) = self.open_plans()
        assert self.mission.recovery_step == "deciding"
        revision = self.mission.revision
        if not approves:
            is_asked = self.asked_at == revision
            self.services.plans.reject(plan, actor="operator")
            assert self.mission.recovery_step == ("planning" if is_asked else "ending")
            self.asked_at = None
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
                if script.control == ControlVerb.CANCEL and agrees and self.stands[script.id] not in OVER:
                    self.end(script, ScriptState.CANCELLED, arrives=arrives)

    @rule(robot=st.sampled_from(ROBOTS), arrives=st.booleans())
    def answer_the_question(self, robot: str, arrives: bool) -> None:
        for script in self.scripts:
            if script.robot == robot and script.question is not None:
                status = StatusReport(
                    script_id=script.id,
                    state=self.stands[script.id],
                    at_s=self.clock.now_s(),
                    order=script.orders,
                )
                self.say(script, status, script.question, arrives=arrives)

    @rule(
        robot=st.sampled_from(ROBOTS), steps=st.integers(1, 4), arrives=st.sampled_from([True, True, False])
    )
    def work(self, robot: str, steps: int, arrives: bool) -> None:
        """The robot begins its next packet, or ends it, or with the last one its script."""
        for _ in range(steps):
            script = self.script(robot)
            if script is None or script.delivery != "acknowledged" or self.stands[script.id] in OVER:
                return
            packets = script.body["packets"]
            step = self.reached[script.id]
            self.reached[script.id] += 1
            if step == 3 * len(packets):
                self.clock.advance(1.0)
                self.end(script, ScriptState.FINISHED, arrives=arrives)
                continue
            packet = packets[step // 3]
            state = (PacketState.INITIALIZING, PacketState.RUNNING, PacketState.FINISHED)[step % 3]
            # What ends at once is not believed, see `test_plausibility.py`.
            self.clock.advance(packet["expected_duration_s"] if state is PacketState.FINISHED else 1.0)
            self.report(script, packet["id"], state, arrives=arrives)

    @rule(robot=st.sampled_from(ROBOTS), arrives=st.booleans())
    def fail(self, robot: str, arrives: bool) -> None:
        script = self.script(robot)
        if script is not None and script.delivery == "acknowledged" and self.stands[script.id] not in OVER:
            step = min(self.reached[script.id] // 3, len(script.body["packets"]) - 1)
            self.report(script, script.body["packets"][step]["id"], PacketState.FAILED, arrives=arrives)
            self.end(script, ScriptState.FAILED, arrives=arrives)

    @precondition(lambda self: self.said)
    @rule(data=st.data())
    def arrive(self, data: st.DataObject) -> None:
        """Something that was said arrives: late, or again."""
        self.deliver(data.draw(st.sampled_from(self.said)))

    @precondition(lambda self: self.said)
    @rule(count=st.integers(2, 6))
    def arrive_in_reverse(self, count: int) -> None:
        for message in self.said[: -count - 1 : -1]:
            self.deliver(message)

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
        self.stands[script.id] = state
        category = FailureCategory.ROBOT if state is ScriptState.FAILED else None
        report = ScriptReport(
            script_id=script.id,
            state=state,
            at_s=self.clock.now_s(),
            category=category,
            perceived=at_home(script.robot) if self.reached[script.id] < 3 else (),
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
    @rule(course=st.sampled_from([*Course, None]))
    def plan_the_repair(self, course: Course | None) -> None:
        self.services.repair(self.id, course)

    @rule(
        rounds=st.integers(1, 5),
        steps=st.integers(1, 3),
        course=st.sampled_from([Course.KEPT, Course.REPLANNED]),
        failing=st.sampled_from([*ROBOTS, None]),
        arrives=st.sampled_from([True, True, True, False]),
    )
    def go_on(self, rounds: int, steps: int, course: Course, failing: str | None, arrives: bool) -> None:
        """Everybody does as asked for a while, but for a robot that fails."""
        self.run_for(rounds, steps=steps, course=course, failing=failing, arrives=arrives)

    def run_for(self, rounds: int, *, steps: int, course: Course, failing: str | None, arrives: bool) -> None:
        for number in range(rounds):
            self.monitor(after_s=1.0)
            if self.mission.recovery_step == "planning":
                self.plan_the_repair(course)
            for robot in ROBOTS:
                self.answer_the_script(robot, agrees=True, arrives=arrives)
                self.answer_the_order(robot, agrees=True, arrives=arrives)
                self.answer_the_question(robot, arrives=arrives)
                if robot == failing and number == 0:
                    self.fail(robot, arrives=arrives)
                else:
                    self.work(robot, steps=steps, arrives=arrives)

    @precondition(lambda self: not self.is_second_run)
    @rule(starts=st.sampled_from([False, False, True]))
    def start_the_world_again(self, starts: bool) -> None:
        if starts:  # most runs are to come further
            self.is_second_run = True
            self.services.start_world("run-2")
            assert self.mission.state in ENDED

    @rule()
    def restart(self) -> None:
        self.services.close()
        self.services = self.opened()

    # What must hold

    @invariant()
    def the_record_is_as_the_model_expects(self) -> None:
        of_mission = (EventRow.subject == self.id, EventRow.type.startswith("mission."))
        with self.services.database.read() as session:
            mission = session.get_one(MissionRow, self.id)
            goal = session.get_one(GoalRow, mission.goal_id)
            query = select(ScriptRow).where(ScriptRow.mission_id == self.id)
            scripts = session.scalars(query).all()
            plans = session.scalars(select(PlanRow.id).where(PlanRow.state == "proposed")).all()
            told = session.scalars(select(EventRow.data).where(*of_mission).order_by(EventRow.seq.desc()))
            assert next(data["state"] for data in told if "state" in data) == mission.state
        for script in scripts:
            self.check_reports(script)
        self.check_end(mission, goal, plans)
        for script in scripts:
            self.check_orders(script)
        self.check_recovery(mission, plans)

    def check_reports(self, script: ScriptRow) -> None:
        """What was reported is known, and nothing else."""
        known = {name: (one["at_s"], one["state"]) for name, one in script.packets.items()}
        assert known == self.packets[script.id]
        if script.id in self.over:
            assert script.state == self.over[script.id]
        elif script.state in OVER:  # it was told to drop what it had not agreed to
            assert (script.state, script.delivery) == ("cancelled", "withdrawn")
            self.over[script.id] = script.state

    def check_end(self, mission: MissionRow, goal: GoalRow, open_plans: Sequence[str]) -> None:
        """A mission that has ended stays as it is, and ended for what was believed and ordered."""
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
            assert not open_plans
        assert mission.cancel_requested == self.cancelled

    def check_orders(self, script: ScriptRow) -> None:
        """Orders are numbered, the last is to stop, and none outlives the mission."""
        assert script.orders >= self.orders[script.id]
        self.orders[script.id] = script.orders
        if script.stopping:
            assert script.control in (None, "cancel")
        if self.ended is not None and not script.abandoned:
            assert (script.control, script.question, script.clearance) == (None, None, None)
            assert script.delivery != "pending"

    def check_recovery(self, mission: MissionRow, open_plans: Sequence[str]) -> None:
        """Only the last attempt at recovery is open."""
        outcomes = [attempt["outcome"] for attempt in mission.attempts]
        assert [attempt["number"] for attempt in mission.attempts] == list(range(1, len(outcomes) + 1))
        assert not {"planning", "proposed"} & set(outcomes[:-1])
        assert mission.tries_left >= 0
        if mission.recovery_step == "planning":
            assert outcomes[-1] == "planning"
        if mission.recovery_step == "deciding":
            assert outcomes[-1] == "proposed"
            assert len(open_plans) == 1

    def teardown(self) -> None:
        """Once all that was said arrives and every robot answers, a mission that is cancelled ends."""
        if self.ended is None and hasattr(self, "id"):
            self.cancel(often=True)
            for _ in range(6):
                for message in self.said:
                    self.deliver(message)
                self.monitor(after_s=300.0)
                for robot in ROBOTS:
                    self.answer_the_script(robot, agrees=False, arrives=True)
                    self.answer_the_order(robot, agrees=True, arrives=True)
            assert self.mission.state in ENDED
        self.services.close()
        self.folder.cleanup()


TestMissionMachine = MissionMachine.TestCase
TestMissionMachine.settings = settings(
    max_examples=30,
    stateful_step_count=25,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
