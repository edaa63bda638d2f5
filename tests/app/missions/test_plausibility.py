"""Reports that cannot be so: they complete nothing, the mission says why, and an honest robot gets through."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from app.agents.agent_models import Reception
from app.domain.contradictions import CLOCKS_S
from app.domain.plan_document import PlanBody
from app.domain.world_model.beliefs import Facts
from app.store import PlanRow, ScriptRow
from app.store.migrate import migrate
from robots.clock import ManualClock
from robots.wire import (
    Acknowledgement,
    Body,
    FailureCategory,
    FaultLevel,
    FaultReport,
    Message,
    PacketReport,
    PacketState,
    Performative,
    RobotFault,
    ScriptReport,
    ScriptState,
    StatusReport,
    SymbolicFact,
    Telemetry,
    UpkeepReport,
)
from tests.app.missions.mission_services import WORLD, at_home, services
from tests.app.sample_store import Store

STORE = Store()
ROBOTS = ("yard_1", "store_2")
DELIVERED = SymbolicFact(predicate="in", args=("sample_1", "bay_7"))


class Mission:
    """The main job under way: two robots have agreed to their scripts."""

    def __init__(self, folder: Path, *, as_needed: str | None = None) -> None:
        """:param as_needed: a robot whose actions last as long as a number needs."""
        self.clock = ManualClock()
        self.clock.advance(1000.0)
        self.services = services(folder, store=STORE, clock=self.clock)
        migrate(self.services.database)
        self.services.start_world()
        plan_id = self.services.plan()
        with self.services.database.write() as session:
            plan = session.get_one(PlanRow, plan_id)
            actions = [
                {**one, "level": 0.9} if as_needed in one["agents"] else one for one in plan.body["actions"]
            ]
            plan.body = {**plan.body, "actions": actions}
            net = PlanBody.model_validate(plan.body).to_plan_net(STORE.base)
            self.services.core.plan_nets.keep(plan_id, net)
        _, self.id = self.services.plans.approve(plan_id, actor="operator")
        self.monitor()
        for robot in ROBOTS:
            script = self.script(robot)
            self.say(robot, Acknowledgement(script_id=script.id), f"{script.id}:request")

    def monitor(self) -> None:
        self.services.life.monitor(self.id)

    @property
    def stands(self) -> tuple[str, str]:
        self.monitor()
        mission = self.services.mission(self.id)
        return mission.state, mission.reason

    @property
    def facts(self) -> Facts:
        return self.services.read(lambda session: self.services.core.facts.facts(session, WORLD))

    def script(self, robot: str) -> ScriptRow:
        (script,) = (one for one in self.services.scripts(self.id) if one.robot == robot)
        return script

    def packets(self, robot: str) -> Sequence[str]:
        return [packet["id"] for packet in self.script(robot).body["packets"]]

    def expected_s(self, robot: str) -> float:
        return float(sum(packet["expected_duration_s"] for packet in self.script(robot).body["packets"]))

    def message(self, robot: str, body: Body, in_reply_to: str | None = None) -> Message:
        return Message(
            performative=Performative.INFORM,
            sender=robot,
            receiver="service",
            sent_at_s=self.clock.now_s(),
            in_reply_to=in_reply_to,
            body=body,
        )

    def say(self, robot: str, body: Body, in_reply_to: str | None = None) -> Reception:
        return self.services.reports.record(self.message(robot, body, in_reply_to), WORLD)

    def packet(self, robot: str, index: int, state: PacketState = PacketState.FINISHED) -> PacketReport:
        return PacketReport(
            script_id=self.script(robot).id,
            packet_id=self.packets(robot)[index],
            state=state,
            at_s=self.clock.now_s(),
        )

    def end(
        self,
        robot: str,
        state: ScriptState = ScriptState.FINISHED,
        *,
        at_s: float | None = None,
        perceived: Sequence[SymbolicFact] = (),
    ) -> ScriptReport:
        return ScriptReport(
            script_id=self.script(robot).id,
            state=state,
            at_s=self.clock.now_s() if at_s is None else at_s,
            category=None if state is ScriptState.FINISHED else FailureCategory.ROBOT,
            perceived=tuple(perceived),
        )

    def tell(self, robot: str, place: str, packet: int | None = None, *, holding: str | None = None) -> None:
        """The robot's telemetry arrives.

        :param packet: the one of its script that is under way.
        """
        x_m, y_m = STORE.world.location(place).at
        told = Telemetry(at_s=self.clock.now_s(), x_m=x_m, y_m=y_m, heading_rad=0.0, holding=holding)
        if packet is not None:
            under_way = {
                "script_id": self.script(robot).id,
                "script_state": ScriptState.RUNNING,
                "packet_id": self.packets(robot)[packet],
                "packet_state": PacketState.RUNNING,
            }
            told = told.model_copy(update=under_way)
        self.services.board.heard(robot, told)


@pytest.fixture
def mission(tmp_path: Path) -> Iterator[Mission]:
    made = Mission(tmp_path)
    yield made
    made.services.close()


def test_a_forged_end_completes_nothing(mission: Mission) -> None:
    before = mission.facts
    mission.clock.advance(2.2)
    for robot in ROBOTS:
        assert mission.say(robot, mission.end(robot)) is Reception.HELD_BACK
    state, reason = mission.stands
    assert state == "unknown"
    assert "yard_1 reports that" in reason
    assert "store_2 reports that" in reason
    assert "after 2.2 s, which takes" in reason
    assert mission.facts == before
    assert all(mission.script(robot).question for robot in ROBOTS), "they are asked"


def test_a_robot_that_says_that_it_is_at_work_has_the_mission_go_on(mission: Mission) -> None:
    mission.say("yard_1", mission.end("yard_1"))
    assert mission.stands[0] == "unknown"
    script = mission.script("yard_1")
    at_work = StatusReport(script_id=script.id, state=ScriptState.RUNNING, at_s=mission.clock.now_s())
    assert mission.say("yard_1", at_work, script.question) is Reception.RECORDED
    assert mission.stands[0] == "running"
    mission.say("yard_1", mission.end("yard_1"))
    assert mission.stands[0] == "unknown", "to be forged again"


def test_a_robot_that_says_that_it_has_ended_is_still_not_believed(mission: Mission) -> None:
    mission.say("yard_1", mission.end("yard_1"))
    _, why = mission.stands
    script = mission.script("yard_1")
    ended = StatusReport(script_id=script.id, state=ScriptState.FINISHED, at_s=mission.clock.now_s())
    mission.say("yard_1", ended, script.question)
    assert mission.stands == ("unknown", why)


def test_an_honest_end_that_came_too_early_counts_when_it_is_repeated(mission: Mission) -> None:
    mission.clock.advance(1.0)
    repeated = {robot: mission.message(robot, mission.end(robot)) for robot in ROBOTS}
    for message in repeated.values():
        assert mission.services.reports.record(message, WORLD) is Reception.HELD_BACK
    assert mission.stands[0] == "unknown"
    mission.clock.advance(max(mission.expected_s(robot) for robot in ROBOTS))
    for message in repeated.values():
        assert mission.services.reports.record(message, WORLD) is Reception.RECORDED
    assert mission.stands == ("completed", "")


@pytest.mark.parametrize(
    ("as_needed", "reception"), [(None, Reception.HELD_BACK), ("yard_1", Reception.RECORDED)]
)
def test_what_lasts_as_long_as_a_number_needs_may_be_over_at_once(
    tmp_path: Path, as_needed: str | None, reception: Reception
) -> None:
    mission = Mission(tmp_path, as_needed=as_needed)
    assert mission.say("yard_1", mission.packet("yard_1", 0, PacketState.RUNNING)) is Reception.RECORDED
    mission.clock.advance(0.1)
    assert mission.say("yard_1", mission.packet("yard_1", 0)) is reception
    mission.services.close()


def test_a_mission_whose_robots_take_their_time_is_never_doubted(mission: Mission) -> None:
    for robot in ROBOTS:
        for index, packet in enumerate(mission.script(robot).body["packets"]):
            assert mission.say(robot, mission.packet(robot, index, PacketState.RUNNING)) is Reception.RECORDED
            mission.clock.advance(0.5 * packet["expected_duration_s"])
            assert mission.say(robot, mission.packet(robot, index)) is Reception.RECORDED
        assert mission.say(robot, mission.end(robot)) is Reception.RECORDED
    assert mission.stands == ("completed", "")


def test_a_packet_has_not_finished_whose_robot_is_far_from_where_it_ends(mission: Mission) -> None:
    last = len(mission.packets("store_2")) - 1
    mission.clock.advance(500.0)
    mission.tell("store_2", "home_store_2")
    claim = mission.message("store_2", mission.packet("store_2", last - 1))
    assert mission.services.reports.record(claim, WORLD) is Reception.HELD_BACK
    state, reason = mission.stands
    assert state == "unknown"
    assert "reports to be at bay_7, but its telemetry shows it 3.6 m away" in reason
    mission.tell("store_2", "bay_7")
    assert mission.services.reports.record(claim, WORLD) is Reception.RECORDED
    assert mission.script("store_2").doubt == ""


def test_a_script_has_not_ended_whose_robot_shows_that_it_is_still_at_a_packet(mission: Mission) -> None:
    mission.clock.advance(500.0)
    claim = mission.message("store_2", mission.end("store_2"))
    mission.clock.advance(0.1)
    mission.tell("store_2", "bay_7", packet=1)
    assert mission.services.reports.record(claim, WORLD) is Reception.HELD_BACK
    assert "its telemetry still shows" in mission.stands[1]
    mission.tell("store_2", "bay_7")
    assert mission.services.reports.record(claim, WORLD) is Reception.RECORDED


@pytest.mark.parametrize("state", [ScriptState.FAILED, ScriptState.CANCELLED])
def test_a_robot_that_fails_has_not_seen_what_is_far_away(mission: Mission, state: ScriptState) -> None:
    """Or a forged failure would complete the mission: all its goals are believed true."""
    mission.clock.advance(500.0)
    mission.tell("yard_1", "home_yard_1")
    before = mission.facts
    forged = mission.end("yard_1", state, perceived=[DELIVERED])
    assert mission.say("yard_1", forged) is Reception.HELD_BACK
    assert mission.facts == before
    assert mission.stands[0] == "unknown"
    honest = mission.end("yard_1", state, perceived=at_home("yard_1"))
    assert mission.say("yard_1", honest) is Reception.RECORDED


def test_upkeep_does_not_tell_of_what_is_far_away(mission: Mission) -> None:
    mission.tell("yard_2", "home_yard_2")
    before = mission.facts

    def upkeep(*perceived: SymbolicFact) -> Reception:
        at_s = mission.clock.now_s()
        report = UpkeepReport(tag="CHARGE", state=PacketState.FINISHED, at_s=at_s, perceived=perceived)
        return mission.say("yard_2", report)

    assert upkeep(DELIVERED) is Reception.HELD_BACK
    assert mission.facts == before
    assert upkeep(*at_home("yard_2")) is Reception.RECORDED


def test_faults_are_an_event_in_the_robots_words_and_change_nothing_else(mission: Mission) -> None:
    before = mission.facts, mission.stands
    fault = RobotFault(level=FaultLevel.FATAL, type="lidar", text="dirty <b>window</b>")
    assert mission.say("yard_2", FaultReport(at_s=5.0, faults=(fault,))) is Reception.RECORDED
    (event,) = [one for one in mission.services.core.events.since(0) if one.type == "robot.faults_reported"]
    assert event.subject == "yard_2"
    assert event.data["faults"] == [{"level": "fatal", "type": "lidar", "text": "dirty <b>window</b>"}]
    assert (mission.facts, mission.stands) == before


def test_a_report_of_the_future_does_not_make_those_of_now_outdated(mission: Mission) -> None:
    script = mission.script("yard_1")
    later = StatusReport(script_id=script.id, state=ScriptState.PAUSED, at_s=1e9)
    assert mission.say("yard_1", later, script.question) is Reception.HELD_BACK
    assert mission.stands[0] == "unknown"
    running = mission.packet("yard_1", 0, PacketState.RUNNING)
    assert mission.say("yard_1", running) is Reception.RECORDED
    assert mission.script("yard_1").state == ScriptState.RUNNING


def test_a_claim_that_is_repeated_is_told_once(mission: Mission, caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(5):
        mission.say("yard_1", mission.end("yard_1"))
        mission.monitor()
    assert len([one for one in caplog.records if "held back as implausible" in one.getMessage()]) == 1


def test_what_a_mission_that_is_paused_is_told_is_looked_into_when_it_goes_on(mission: Mission) -> None:
    mission.say("yard_1", mission.packet("yard_1", 0, PacketState.RUNNING))
    mission.services.missions.pause(mission.id, "operator", "")
    mission.say("yard_1", mission.end("yard_1"))
    assert mission.stands[0] == "paused"
    mission.services.missions.resume(mission.id, "operator", "")
    assert mission.stands[0] == "unknown"


@pytest.mark.parametrize("held_on_s", [0.0, 1.0, 3.0])
def test_two_robots_do_not_hold_one_sample(mission: Mission, held_on_s: float) -> None:
    """The one that reports to have gripped it, while the other's telemetry still shows it: for long, or just now."""
    mission.clock.advance(500.0)
    for index in range(4):
        mission.say("yard_1", mission.packet("yard_1", index, PacketState.RUNNING))
    claim = mission.message("store_2", mission.packet("store_2", 1))
    mission.clock.advance(held_on_s)
    mission.tell("yard_1", "interchange_2", packet=3, holding="sample_1")
    held_back = mission.services.reports.record(claim, WORLD) is Reception.HELD_BACK
    assert held_back == (held_on_s > 0)
    state, reason = mission.stands
    shown = mission.services.mission(mission.id).contradictions
    if held_on_s <= CLOCKS_S:
        assert state == ("unknown" if held_back else "running")
        assert shown == []
        mission.tell("yard_1", "interchange_2", packet=3)
        assert held_back <= (mission.services.reports.record(claim, WORLD) is Reception.RECORDED)
        return
    assert state == "recovering"
    assert (
        "store_2 reports to have ended a6 DOCK at 1500.0 s, but yard_1 holds sample_1 by its telemetry"
        in reason
    )
    assert [one["things"] for one in shown] == [["sample_1"]]
    assert not any(
        fact.args[0] == "sample_1" for fact in mission.facts if fact.predicate == "object_position"
    )
