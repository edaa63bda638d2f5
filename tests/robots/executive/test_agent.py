"""A robot carries out its script alone, from sensing only."""

import pytest

from robots.physical.body import RADIUS_M, Pose
from robots.wire import FailureCategory, PacketState, ScriptState
from tests.robots.stories import (
    EAST,
    NORTH,
    SOUTH,
    WEST,
    Service,
    carry,
    fact,
    packet,
    room,
    run,
    run_for,
    script,
)

SEEDS = range(3)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("place", "point"), [("door", 1 + 1.2j), ("hatch", 3 + 2.2j), ("yard", 4.6 + 1.2j)])
def test_navigate_ends_at_the_approach_point_facing_the_beacon(place: str, point: complex, seed: int) -> None:
    world = room(seed=seed)
    service = Service(world, world.add("fred", Pose(x_m=3, y_m=1.2, heading_rad=WEST)), "fred")
    service.order(script("fred", packet("NAVIGATE", ref2=place)))
    assert run(world, [service], lambda: service.report is not None, limit_s=40)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED
    assert fact(f"near(fred, {place})") in service.report.perceived
    assert abs(world.bodies["fred"].at - point) < 0.15


@pytest.mark.parametrize("seed", SEEDS)
def test_a_sample_is_fetched_carried_and_deposited(seed: int) -> None:
    world = room({"sample": 1 + 0.4j}, seed=seed)
    service = Service(world, world.add("fred", Pose(x_m=4, y_m=1.5, heading_rad=NORTH)), "fred")
    service.order(carry("fred", "sample", "door", "yard"))
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED
    assert abs(world.samples["sample"] - (5.4 + 1.2j)) < 0.1
    assert fact("in(sample, yard)") in service.report.perceived
    assert fact("robot_attribute(fred, gripper, empty)") in service.report.perceived
    stages = (PacketState.INITIALIZING, PacketState.RUNNING, PacketState.FINISHED)
    tags = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2")
    assert service.packets == [(tag, state) for tag in tags for state in stages]


@pytest.mark.parametrize("seed", SEEDS)
def test_two_robots_hand_a_sample_over_at_the_hatch_by_sensing_alone(seed: int) -> None:
    world = room({"sample": 1 + 0.4j}, seed=seed)
    fred = Service(world, world.add("fred", Pose(x_m=3, y_m=1.5, heading_rad=EAST), ["ginger"]), "fred")
    ginger = Service(world, world.add("ginger", Pose(x_m=2, y_m=5, heading_rad=EAST), ["fred"]), "ginger")
    fred.order(carry("fred", "sample", "door", "hatch"))
    ginger.order(carry("ginger", "sample", "hatch", "bay", awaits=["in(sample, hatch)"]))
    assert run(world, [fred, ginger], lambda: fred.report is not None and ginger.report is not None)
    assert [service.report and service.report.state for service in (fred, ginger)] == [
        ScriptState.FINISHED
    ] * 2
    assert abs(world.samples["sample"] - (5.5 + 4.6j)) < 0.1
    times = {
        m.body.packet_id: m.body.at_s for m in ginger.heard if getattr(m.body, "state", None) == "running"
    }
    released_at = [m.body.at_s for m in fred.heard if getattr(m.body, "state", None) == "finished"]
    assert times["DOCK-sample-hatch"] > released_at[2], "gripped before the other had come with the sample"


@pytest.mark.parametrize("seed", SEEDS)
def test_robots_that_meet_head_on_pass_each_other(seed: int) -> None:
    world = room(seed=seed)
    fred = Service(world, world.add("fred", Pose(x_m=1.2, y_m=1.4, heading_rad=EAST), ["ginger"]), "fred")
    ginger = Service(world, world.add("ginger", Pose(x_m=5, y_m=1.2, heading_rad=WEST), ["fred"]), "ginger")
    fred.order(script("fred", packet("NAVIGATE", ref2="yard")))
    ginger.order(script("ginger", packet("NAVIGATE", ref2="door")))
    gaps = []

    def both_ended() -> bool:
        gaps.append(abs(world.bodies["fred"].at - world.bodies["ginger"].at) - 2 * RADIUS_M)
        return fred.report is not None and ginger.report is not None

    assert run(world, [fred, ginger], both_ended, limit_s=60)
    assert [service.report and service.report.state for service in (fred, ginger)] == [
        ScriptState.FINISHED
    ] * 2
    assert min(gaps) > 0.02


def test_a_robot_waits_for_a_location_to_be_clear_facing_it() -> None:
    world = room()
    fred = Service(world, world.add("fred", Pose(x_m=3, y_m=1.2, heading_rad=EAST), ["ginger"]), "fred")
    ginger = Service(world, world.add("ginger", Pose(x_m=1, y_m=1.2, heading_rad=SOUTH), ["fred"]), "ginger")
    fred.order(script("fred", packet("NAVIGATE", ref2="door", awaits=["clear(door, hall)"])))
    run_for(world, [fred, ginger], 10)
    assert fred.packets == [("NAVIGATE", PacketState.INITIALIZING)]
    fred_body = world.bodies["fred"]
    assert abs(fred_body.at - (3 + 1.2j)) < 0.02
    assert abs(fred_body.pose.heading_rad) > 2.5
    ginger.order(script("ginger", packet("NAVIGATE", ref2="yard")))
    assert run(world, [fred, ginger], lambda: fred.report is not None, limit_s=60)
    assert fred.report is not None
    assert fred.report.state is ScriptState.FINISHED


def test_dock_fails_in_words_when_the_sample_does_not_come() -> None:
    world = room({"other_sample": 1 + 0.4j})
    service = Service(world, world.add("fred", Pose(x_m=1, y_m=1.2, heading_rad=SOUTH)), "fred")
    service.order(script("fred", packet("DOCK", object="sample", ref1="door", wait_timeout_s=5)))
    assert run(world, [service], lambda: service.report is not None, limit_s=10)
    report = service.report
    assert report is not None
    assert (report.state, report.category) == (ScriptState.FAILED, FailureCategory.WORLD_CHANGED)
    assert "does not see sample (sees other_sample)" in report.detail
    assert fact("in(other_sample, door)") in report.perceived


def test_a_packet_that_does_not_end_in_time_fails() -> None:
    world = room()
    service = Service(world, world.add("fred", Pose(x_m=5, y_m=1.2, heading_rad=EAST)), "fred")
    service.order(script("fred", packet("NAVIGATE", ref2="door", timeout_s=3)))
    assert run(world, [service], lambda: service.report is not None, limit_s=10)
    assert service.report is not None
    assert service.report.category is FailureCategory.DEADLINE
    assert "did not end within 3 s: the robot is" in service.report.detail
    assert world.bodies["fred"].velocity == (0, 0)


def test_a_robot_that_gets_nowhere_tries_again_a_few_times_then_fails() -> None:
    world = room()
    service = Service(world, world.add("fred", Pose(x_m=5, y_m=1.2, heading_rad=WEST)), "fred")
    world.bodies["fred"].stuck = True
    service.order(script("fred", packet("NAVIGATE", ref2="door", timeout_s=200)))
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.category is FailureCategory.ROBOT
    assert "made no progress after 4 retries" in service.report.detail
    tries = {m.id for m in service.heard if "tries again" in getattr(m.body, "detail", "")}
    assert len(tries) == 4


def test_a_sample_lost_on_the_way_fails_the_transport() -> None:
    world = room({"sample": 1 + 0.4j})
    service = Service(world, world.add("fred", Pose(x_m=1, y_m=1.2, heading_rad=SOUTH)), "fred")
    service.order(carry("fred", "sample", "door", "yard"))
    assert run(world, [service], lambda: ("TRANSPORT", PacketState.RUNNING) in service.packets)
    run_for(world, [service], 3)
    world.bodies["fred"].held = None
    assert run(world, [service], lambda: service.report is not None, limit_s=5)
    assert service.report is not None
    assert service.report.category is FailureCategory.WORLD_CHANGED
    assert "holds nothing" in service.report.detail


def test_track_faces_the_other_robot_at_a_distance_for_a_while() -> None:
    world = room()
    fred = Service(world, world.add("fred", Pose(x_m=1, y_m=1.2, heading_rad=NORTH), ["ginger"]), "fred")
    world.add("ginger", Pose(x_m=3.5, y_m=1.2, heading_rad=NORTH), ["fred"])
    fred.order(script("fred", packet("TRACK", robot1="fred", robot2="ginger")))
    assert run(world, [fred], lambda: fred.report is not None, limit_s=20)
    assert fred.report is not None
    assert fred.report.state is ScriptState.FINISHED
    assert abs(world.bodies["fred"].pose.heading_rad) < 0.2
    assert abs(world.bodies["fred"].at - world.bodies["ginger"].at) > 1.0
