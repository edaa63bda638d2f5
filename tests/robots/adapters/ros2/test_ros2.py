"""A robot that is driven by ROS 2 actions keeps the contract; faults of action servers fail packets with reasons."""

import argparse
from math import cos, nan, pi, sin
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.adapters import ContractRobot
from robots.adapters.command_line import main
from robots.adapters.ros2.command import run
from robots.adapters.ros2.driver import Ros2Driver
from robots.adapters.ros2.frames import PlanePose, heading_of, turned, turned_back
from robots.adapters.ros2.goal_messages import facts_of
from robots.adapters.ros2.parameters import ParameterError, PoseFrame, Ros2Parameters, read_parameters
from robots.adapters.ros2.ros import RosError, load_ros
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.wire import (
    BehaviourPacket,
    Control,
    ControlVerb,
    FailureCategory,
    PacketState,
    Performative,
    ScriptRequest,
    ScriptState,
)
from tests.robots.adapters.foreign_robot import STEP_S, Flash, Service, fact, packet, script
from tests.robots.adapters.ros2.definitions import (
    CARRY_OUT,
    CARRYING,
    Distribution,
    message,
)
from tests.robots.adapters.ros2.definitions import (
    DOCK as DOCKS,
)
from tests.robots.adapters.ros2.definitions import (
    NAVIGATE as NAVIGATES,
)
from tests.robots.adapters.ros2.fake_ros import Server, fake_ros, pose

EXAMPLE = Path(__file__).parents[4] / "examples" / "ros2" / "robot.yaml"
PARAMETERS = read_parameters(EXAMPLE)
NAVIGATE = packet("a1", "NAVIGATE", ref2="bay_1", achieves=("near(carl, bay_1)",))
DOCK = packet("a2", "DOCK", object="sample_1", ref1="bay_1")
RELEASE = packet("a3", "RELEASE2", object="sample_1", ref2="bay_1")


class Stage:
    """The adapter beside three action servers, which outlive it."""

    def __init__(
        self, parameters: Ros2Parameters = PARAMETERS, distribution: Distribution = Distribution.JAZZY
    ) -> None:
        self.clock = ManualClock()
        self.parameters = parameters
        self.servers = {
            "navigate_to_pose": Server(NAVIGATES, distribution),
            "dock_robot": Server(DOCKS[distribution], distribution),
            "carry_out_packet": Server(CARRY_OUT, distribution),
        }
        self.navigation = self.servers["navigate_to_pose"]
        self.docking = self.servers["dock_robot"]
        self.own = self.servers["carry_out_packet"]
        self.flash = Flash()
        ours, self._theirs = InMemoryLink.pair()
        self.service = Service(ours, self.clock)
        self.restart()

    def restart(self) -> None:
        self.ros, self.node = fake_ros(self.servers, self.clock.now_s)
        self.robot = ContractRobot(
            "carl",
            driver=Ros2Driver(self.ros, self.parameters, self.clock),
            packets=self.parameters.forms,
            link=self._theirs,
            clock=self.clock,
            store=self.flash,
            run="run-1",
        )

    def run_for(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            self.robot.tick()
            self.service.step()
            self.clock.advance(STEP_S)

    def order(self, *packets: BehaviourPacket) -> None:
        self.service.send(ScriptRequest(script=script(*packets)), repeat=True)
        self.run_for(2)

    def control(self, verb: ControlVerb, number: int = 0) -> None:
        performative = Performative.CANCEL if verb is ControlVerb.CANCEL else Performative.REQUEST
        self.service.send(Control(script_id="s1", verb=verb, number=number), performative, repeat=True)
        self.run_for(1)

    @property
    def failure(self) -> str:
        """Why the script failed."""
        (end,) = self.service.ends
        assert (end.state, end.category) == (ScriptState.FAILED, FailureCategory.ROBOT)
        return end.detail


def parameters_for(distribution: Distribution) -> Ros2Parameters:
    """The example's, with the type that DockRobot has there."""
    dock = PARAMETERS.packets["DOCK"].model_copy(update={"type": DOCKS[distribution]})
    return PARAMETERS.model_copy(update={"packets": PARAMETERS.packets | {"DOCK": dock}})


@pytest.mark.parametrize("distribution", list(Distribution))
def test_packets_are_carried_out_by_the_actions_of_the_parameter_file(distribution: Distribution) -> None:
    stage = Stage(parameters_for(distribution), distribution)
    stage.order(NAVIGATE, DOCK, RELEASE)
    (goal,) = stage.navigation.begun
    assert goal.pose.header.frame_id == "map"
    stage.navigation.end(4)
    stage.run_for(2)
    (dock,) = stage.docking.begun
    assert (dock.use_dock_id, dock.dock_id, dock.dock_type) == (True, "bay_1_dock", "shelf")
    stage.docking.end(4)
    stage.run_for(2)
    (release,) = stage.own.begun
    assert (release.packet_id, release.tag, release.timeout_s) == ("s1/a3", "RELEASE2", 60.0)
    assert dict(zip(release.argument_names, release.argument_values, strict=True)) == RELEASE.arguments
    stage.own.feed_back(events=["opened"])
    stage.run_for(1)
    stage.own.end(4, perceived=["in(sample_1, bay_1)"])
    stage.run_for(2)
    assert [end.state for end in stage.service.ends] == [ScriptState.FINISHED]
    finished = {one.packet_id: one for one in stage.service.reports if one.state is PacketState.FINISHED}
    assert finished["a1"].perceived == (fact("near(carl, bay_1)"),)
    assert finished["a3"].perceived == (fact("in(sample_1, bay_1)"),)
    assert [one.packet_id for one in stage.service.reports if one.events == ("opened",)] == ["a3"]


def test_a_goal_is_in_the_frame_of_the_map() -> None:
    stage = Stage()
    stage.order(NAVIGATE)
    (goal,) = stage.navigation.begun
    at = goal.pose.pose
    # bay_1 at (1.2, 2.0), 180 degrees; the map's origin at (1.5, -2.0), turned by 90 degrees.
    assert (at.position.x, at.position.y) == pytest.approx((4.0, 0.3))
    assert heading_of(at.orientation) == pytest.approx(pi / 2)


@pytest.mark.parametrize(
    ("end", "why"),
    [
        ({"status": 6}, "NAVIGATE was aborted by navigate_to_pose"),
        (
            {"status": 6, "error_code": 104, "error_msg": "no valid path"},
            "NAVIGATE was aborted by navigate_to_pose: no valid path, error 104",
        ),
        ({"status": 5}, "NAVIGATE was cancelled by another client"),
    ],
)
def test_a_goal_that_ends_badly_fails_its_packet(end: dict[str, Any], why: str) -> None:
    stage = Stage()
    stage.order(NAVIGATE)
    stage.navigation.end(**end)
    stage.run_for(2)
    assert stage.failure == why


def test_a_result_without_success_fails_its_packet() -> None:
    stage = Stage()
    stage.order(DOCK)
    stage.docking.end(4, success=False, error_code=904)
    stage.run_for(2)
    assert stage.failure == "DOCK did not succeed: error 904"


def test_a_rejected_goal_fails_its_packet() -> None:
    stage = Stage()
    stage.navigation.accepts = False
    stage.order(NAVIGATE)
    assert stage.failure == "NAVIGATE was rejected by the action server navigate_to_pose"


def test_a_server_that_is_not_there_is_awaited_for_a_time() -> None:
    stage = Stage()
    stage.navigation.available = False
    stage.order(NAVIGATE)
    stage.run_for(5)
    assert not stage.service.ends
    stage.navigation.available = True
    stage.run_for(1)
    assert len(stage.navigation.begun) == 1
    stage.navigation.end(4)
    stage.run_for(2)
    assert stage.service.ends[0].state is ScriptState.FINISHED


@pytest.mark.parametrize(
    ("fault", "why"),
    [
        ("available", "the action server navigate_to_pose is not available for 10 s"),
        ("answers", "the action server navigate_to_pose does not answer for 10 s"),
    ],
)
def test_a_server_that_stays_away_fails_the_packet(fault: str, why: str) -> None:
    stage = Stage()
    setattr(stage.navigation, fault, False)
    stage.order(NAVIGATE)
    stage.run_for(15)
    assert stage.failure == f"NAVIGATE {why}"


def test_a_server_that_dies_under_way_fails_the_packet() -> None:
    stage = Stage()
    stage.order(DOCK)
    stage.docking.available = False
    stage.run_for(15)
    assert stage.failure == "DOCK the action server dock_robot is not available for 10 s"


def test_what_a_server_forgets_by_its_restart_is_not_done_again_unless_it_is_repeatable() -> None:
    stage = Stage()
    stage.order(DOCK)
    stage.docking.available = False
    stage.run_for(2)
    stage.docking.restart()
    stage.run_for(2)
    assert "unknown outcome" in stage.failure
    assert len(stage.docking.begun) == 1

    stage = Stage()
    stage.order(NAVIGATE)
    stage.navigation.available = False
    stage.run_for(2)
    stage.navigation.restart()
    stage.run_for(2)
    assert len(stage.navigation.begun) == 2
    stage.navigation.end(4)
    stage.run_for(2)
    assert stage.service.ends[0].state is ScriptState.FINISHED


def test_a_cancel_ends_the_goal_before_it_is_reported() -> None:
    stage = Stage()
    stage.order(NAVIGATE)
    stage.control(ControlVerb.CANCEL)
    assert stage.navigation.cancels == 1
    assert stage.service.ends[0].state is ScriptState.CANCELLED


def test_a_pause_ends_the_goal_of_a_repeatable_action_and_sends_another_later() -> None:
    stage = Stage()
    stage.order(NAVIGATE)
    stage.control(ControlVerb.PAUSE, 1)
    stage.run_for(30)
    assert (len(stage.navigation.begun), stage.navigation.cancels) == (1, 1)
    assert not stage.service.ends
    stage.control(ControlVerb.RESUME, 2)
    assert len(stage.navigation.begun) == 2
    stage.navigation.end(4)
    stage.run_for(2)
    assert stage.service.ends[0].state is ScriptState.FINISHED


@pytest.mark.parametrize("steps", range(30))
def test_a_restart_at_any_step_repeats_nothing_and_loses_nothing(steps: int) -> None:
    """A goal that was about to be sent is sent, but for one that may not be repeated, whose packet then fails."""
    stage = Stage()
    stage.service.send(ScriptRequest(script=script(NAVIGATE, DOCK, RELEASE)), repeat=True)
    for step in range(60):
        if step == steps:
            stage.restart()
        for server in stage.servers.values():
            if server.goals and list(server.goals)[-1] not in server.results and step % 4 == 3:
                server.end(4)
        stage.run_for(STEP_S)
    begun = [len(server.begun) for server in stage.servers.values()]
    if stage.service.ends[0].state is ScriptState.FAILED:
        assert stage.failure.startswith("DOCK has an unknown outcome")
        assert begun == [1, 0, 0]
    else:
        assert [end.state for end in stage.service.ends] == [ScriptState.FINISHED]
        assert begun == [1, 1, 1]


def test_what_ended_while_the_adapter_was_away_is_reported() -> None:
    stage = Stage()
    stage.order(NAVIGATE)
    stage.navigation.end(4)
    stage.restart()
    stage.run_for(2)
    assert stage.service.ends[0].state is ScriptState.FINISHED
    assert len(stage.navigation.begun) == 1


def test_pose_and_battery_become_telemetry_in_the_worlds_frame() -> None:
    stage = Stage()
    stage.run_for(1)
    assert stage.service.telemetry == []
    quarter = pose(x=4.0, y=0.3, z=sin(pi / 4), w=cos(pi / 4))
    estimated = message("geometry_msgs/msg/PoseWithCovariance", pose=quarter)
    stage.node.subscriptions["amcl_pose"](
        message("geometry_msgs/msg/PoseWithCovarianceStamped", pose=estimated)
    )
    stage.node.subscriptions["battery_state"](
        message("sensor_msgs/msg/BatteryState", percentage=0.4, power_supply_status=1)
    )
    stage.order(NAVIGATE)
    stage.navigation.feed_back(distance_remaining=2.5)
    stage.run_for(1)
    told = stage.service.telemetry[-1]
    assert (told.x_m, told.y_m) == pytest.approx((1.2, 2.0))
    assert abs(told.heading_rad) == pytest.approx(pi)
    assert (told.battery, told.charging, told.goal_m, told.packet_tag) == (0.4, True, 2.5, "NAVIGATE")


def test_a_charge_that_the_battery_does_not_measure_counts_as_full() -> None:
    stage = Stage()
    found = message("geometry_msgs/msg/PoseWithCovariance", pose=pose(x=4.0, y=0.3))
    stage.node.subscriptions["amcl_pose"](message("geometry_msgs/msg/PoseWithCovarianceStamped", pose=found))
    stage.node.subscriptions["battery_state"](
        message("sensor_msgs/msg/BatteryState", percentage=nan, power_supply_status=2)
    )
    stage.run_for(1)
    told = stage.service.telemetry[-1]
    assert (told.battery, told.charging) == (1.0, False)


def told_pose(stage: Stage, *, stamp_s: int) -> list[tuple[float, float]]:
    """The positions that are told in a second with this transform in `/tf`."""
    stamp = message("builtin_interfaces/msg/Time", sec=stamp_s)
    at = message("geometry_msgs/msg/Vector3", x=4.0, y=0.3)
    found = message(
        "geometry_msgs/msg/TransformStamped",
        header=message("std_msgs/msg/Header", stamp=stamp, frame_id="map"),
        transform=message("geometry_msgs/msg/Transform", translation=at),
    )
    stage.ros.buffer.known["map", "base_link"] = found
    before = len(stage.service.telemetry)
    stage.run_for(1)
    return [(one.x_m, one.y_m) for one in stage.service.telemetry[before:]]


def test_the_pose_can_be_looked_up_in_tf() -> None:
    stage = Stage(PARAMETERS.model_copy(update={"pose": PoseFrame(frame="base_link", max_age_s=2.0)}))
    assert "amcl_pose" not in stage.node.subscriptions
    stage.clock.advance(100.0)
    stage.run_for(1)
    assert stage.service.telemetry == []  # the frames are not connected yet
    assert told_pose(stage, stamp_s=50) == []  # nor is where it was long ago
    assert told_pose(stage, stamp_s=102)[-1] == pytest.approx((1.2, 2.0))
    stage.run_for(10)
    assert told_pose(stage, stamp_s=102) == []


def test_a_static_transform_does_not_age() -> None:
    stage = Stage(PARAMETERS.model_copy(update={"pose": PoseFrame()}))
    stage.clock.advance(100.0)
    assert told_pose(stage, stamp_s=0)[-1] == pytest.approx((1.2, 2.0))


@pytest.mark.parametrize(
    ("name", "value", "error"),
    [("target", 1.0, AttributeError), ("x", 1, TypeError), ("x", "1", TypeError)],
)
def test_the_fake_refuses_fields_and_types_that_ros_has_not(
    name: str, value: object, error: type[Exception]
) -> None:
    with pytest.raises(error):
        setattr(message("geometry_msgs/msg/Point"), name, value)


def test_the_fakes_own_action_is_that_of_the_example() -> None:
    parts = EXAMPLE.with_name("CarryOutPacket.action").read_text().split("---")
    basic = {"string": "str", "float64": "float", "bool": "bool"}
    for part, fields in zip(parts, CARRYING.values(), strict=True):
        lines = [line.split() for line in part.splitlines() if line and not line.startswith("#")]
        found = {name: basic[kind.removesuffix("[]")] + "[]" * kind.endswith("[]") for kind, name in lines}
        assert found == fields


METRES = st.floats(-100, 100)


def test_facts_are_read_from_text_and_what_is_no_fact_is_left_out() -> None:
    said = [" in(sample_1, bay_7) ", "gripper", "(sample_1)", "in(sample_1", "bay_7)"]
    assert [str(fact) for fact in facts_of(said)] == ["in(sample_1, bay_7)"]


@given(METRES, METRES, st.floats(-3, 3), METRES, METRES, st.floats(-3, 3))
def test_the_offset_of_frames_is_undone(
    x: float, y: float, h: float, ox: float, oy: float, oh: float
) -> None:
    offset = PlanePose(ox, oy, oh)
    assert turned_back(turned(PlanePose(x, y, h), offset), offset) == pytest.approx((x, y, h), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("world: w", ["robot", "memory", "places", "packets"]),
        (EXAMPLE.read_text().replace("form: navigate", "form: fly"), ["packets.NAVIGATE.form"]),
        (EXAMPLE.read_text().replace(", place: ref1", ""), ["the form dock needs the packet's argument"]),
    ],
)
def test_a_parameter_file_that_is_not_valid_is_an_error_that_names_line_and_slot(
    tmp_path: Path, text: str, faults: list[str]
) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(text)
    with pytest.raises(ParameterError) as caught:
        read_parameters(file)
    assert all(one in str(caught.value) for one in ("line", *faults)), caught.value


def test_without_ros_the_command_says_what_to_do(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(RosError, match=r"setup\.bash"):
        load_ros("macta_carl")
    assert main(["ros2", str(EXAMPLE), "--broker", "mqtt://127.0.0.1:1"]) == 2
    assert "rclpy cannot be imported" in capsys.readouterr().err


def test_a_file_that_is_not_there_ends_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = argparse.Namespace(parameters=Path("nowhere.yaml"), broker="mqtt://127.0.0.1:1")
    assert run(arguments) == 2
    assert "nowhere.yaml cannot be read" in capsys.readouterr().err


def test_the_command_tells_its_subcommands(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "ros2" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["--version"])
    assert capsys.readouterr().out.startswith("macta-robots ")
    with pytest.raises(SystemExit):
        main(["fly"])
    assert "fly" in capsys.readouterr().err
