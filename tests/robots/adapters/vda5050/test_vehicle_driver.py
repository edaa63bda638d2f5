"""One vehicle under the driver: what is ordered, released, followed, stopped and taken up again."""

import pytest

from robots.adapters.driver import ProgressState
from robots.adapters.vda5050.messages import (
    Connection,
    ErrorLevel,
    OperatingMode,
    Reference,
    VehicleConnection,
    VehicleError,
)
from robots.adapters.vda5050.settings import Settings
from robots.adapters.vda5050.vehicle_driver import LOST_S
from robots.wire import FaultLevel, RobotFault
from tests.robots.adapters.vda5050.driven import ERRAND, SETTINGS, Driven, packet


def moving(driven: Driven) -> bool:
    """Whether the vehicle moves within a second."""
    before = driven.vehicle.x, driven.vehicle.y
    driven.step(1.0)
    return (driven.vehicle.x, driven.vehicle.y) != before


@pytest.mark.parametrize("major", [2, 3])
def test_a_script_is_carried_out_packet_by_packet(major: int) -> None:
    driven = Driven(major)
    progresses = driven.carry_out(ERRAND)
    assert [one.state for one in progresses] == [ProgressState.FINISHED] * 4
    assert driven.vehicle.history == ["bay", "bay", "pick", "bay", "door", "door", "drop", "door"]
    assert (driven.vehicle.x, driven.vehicle.y) == (2.0, 3.0)
    assert max(driven.vehicle.deeds.values()) == 1


def test_one_order_has_all_packets_and_each_update_releases_one() -> None:
    driven = Driven()
    driven.carry_out(ERRAND)
    assert len({order.order_id for order in driven.orders}) == 1
    assert [order.order_update_id for order in driven.orders] == [0, 1, 2, 3, 4]
    released = [[node.node_id for node in one.nodes if node.released] for one in driven.orders]
    assert released == [["start"], ["start", "bay"], ["bay", "bay", "bay"], ["bay", "door"], ["door"] * 3]
    ahead = [[node.node_id for node in one.nodes if not node.released] for one in driven.orders]
    assert ahead[0] == ["bay", "bay", "bay", "door", "door", "door"]
    assert ahead[-1] == []


def test_nothing_moves_before_the_first_packet_is_begun() -> None:
    driven = Driven()
    assert driven.driver.objection(ERRAND) is None
    driven.step(10.0)
    assert not driven.orders
    assert not moving(driven)


def test_a_packet_whose_turn_has_not_come_is_horizon_only() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.until_ended()
    assert not moving(driven)
    assert driven.vehicle.history == ["bay"]
    assert not driven.vehicle.is_idle  # it waits for an update of its order


def test_a_decision_point_has_no_actions_since_some_would_carry_them_out_again() -> None:
    driven = Driven()
    driven.carry_out(ERRAND)
    assert all(not order.nodes[0].actions for order in driven.orders)


def test_without_a_horizon_an_order_holds_what_is_released() -> None:
    driven = Driven(settings=SETTINGS.model_copy(update={"horizon": False}))
    driven.carry_out(ERRAND)
    assert all(node.released for order in driven.orders for node in order.nodes)
    assert driven.vehicle.history == ["bay", "bay", "pick", "bay", "door", "door", "drop", "door"]


def test_a_place_without_a_pose_is_an_objection_that_says_what_to_do() -> None:
    driven = Driven(settings=Settings())
    reason = driven.driver.objection(ERRAND)
    assert reason is not None
    assert "the pose of bay is not known; give it under `places`" in reason


def test_an_unknown_packet_is_an_objection_that_names_the_choices() -> None:
    driven = Driven()
    script = ERRAND.model_copy(update={"packets": (packet("a", "JUGGLE"),)})
    reason = driven.driver.objection(script)
    assert reason is not None
    assert "JUGGLE" in reason
    assert "NAVIGATE" in reason


def test_a_restart_at_any_time_does_nothing_twice() -> None:
    driven = Driven()
    for number in range(4):
        driven.begin(ERRAND, number)
        for _ in range(60):
            driven.restart()
            driven.begin(ERRAND, number)
            if driven.step(0.5).state is not ProgressState.RUNNING:
                break
        assert driven.driver.poll().state is ProgressState.FINISHED
    assert driven.vehicle.history == ["bay", "bay", "pick", "bay", "door", "door", "drop", "door"]
    assert driven.driver.holding is None


def test_a_restart_keeps_what_the_vehicle_holds() -> None:
    driven = Driven()
    for number in range(2):
        driven.begin(ERRAND, number)
        driven.until_ended()
    driven.restart()
    driven.step(3.0)
    assert driven.driver.holding == "sample"


def test_a_failed_action_fails_the_packet_with_the_vehicles_reason_once_it_stands() -> None:
    driven = Driven()
    driven.vehicle.fails = frozenset({"pick"})
    driven.begin(ERRAND, 0)
    driven.until_ended()
    driven.begin(ERRAND, 1)
    ended = driven.until_ended()
    assert ended.state is ProgressState.FAILED
    assert ended.detail == "pick failed: pickError: as it was told to fail"
    assert driven.vehicle.is_idle
    assert "cancelOrder" in driven.instant
    facts = {str(fact) for fact in ended.perceived or ()}
    assert facts == {"robot_attribute(agv, gripper, empty)", "near(agv, bay)"}


def test_an_action_that_could_be_tried_again_has_failed_and_the_vehicle_gives_it_up() -> None:
    driven = Driven()
    driven.vehicle.fails = frozenset({"pick"})
    driven.vehicle.holds_failed = True
    driven.begin(ERRAND, 0)
    driven.until_ended()
    driven.begin(ERRAND, 1)
    ended = driven.until_ended()
    assert (ended.state, ended.detail) == (ProgressState.FAILED, "pick failed")
    assert driven.vehicle.is_idle


def test_a_hibernating_vehicle_is_asked_for_nothing_until_it_is_needed() -> None:
    driven = Driven()
    driven.step(1.0)
    driven.vehicle.hibernate()
    sent = len(driven.sent)
    driven.step(200.0)
    assert len(driven.sent) == sent
    assert driven.vehicle.is_hibernating
    driven.begin(ERRAND, 0)
    assert driven.until_ended().state is ProgressState.FINISHED
    assert driven.instant[-1] == "stopHibernation"


def test_a_vehicle_that_hibernates_between_packets_is_given_the_rest_of_its_order_anew() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.until_ended()
    driven.vehicle.hibernate()
    driven.step(60.0)
    for number in (1, 2, 3):
        driven.begin(ERRAND, number)
        assert driven.until_ended().state is ProgressState.FINISHED
    assert driven.vehicle.history == ["bay", "bay", "pick", "bay", "door", "door", "drop", "door"]
    assert [one.order_id for one in driven.orders][-1] == "macta.s1.2"


@pytest.mark.parametrize("level", [ErrorLevel.CRITICAL, ErrorLevel.FATAL])
def test_a_grave_error_ends_the_packet(level: ErrorLevel) -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.step(2.0)
    error = VehicleError(error_type="BLOCKED", error_level=level, error_description="in the way")
    driven.vehicle.raise_error(error)
    ended = driven.until_ended()
    assert (ended.state, ended.detail) == (ProgressState.FAILED, "BLOCKED: in the way")


@pytest.mark.parametrize("level", [ErrorLevel.WARNING, ErrorLevel.URGENT])
def test_a_slight_error_is_shown_and_the_packet_goes_on(level: ErrorLevel) -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.vehicle.raise_error(VehicleError(error_type="DIRTY_SCANNER", error_level=level))
    driven.step(1.0)
    shown = driven.driver.telemetry()
    assert shown is not None
    driven.vehicle.raise_error(VehicleError(error_type="DIRTY_SCANNER", error_level=level))
    driven.step(1.0)
    shown = driven.driver.telemetry()
    assert shown is not None
    assert shown.degraded == (f"{level.lower()}: DIRTY_SCANNER",)
    assert driven.until_ended().state is ProgressState.FINISHED


def test_faults_are_reported_in_the_vehicles_words_once_when_they_change() -> None:
    driven = Driven()
    driven.step(2.0)
    assert driven.driver.changed_faults() is None
    driven.vehicle.raise_error(VehicleError(error_type="DIRTY_SCANNER", error_level=ErrorLevel.WARNING))
    words = "in the way; <b>call</b> somebody"
    driven.vehicle.raise_error(
        VehicleError(error_type="BLOCKED", error_level=ErrorLevel.FATAL, error_description=words)
    )
    driven.step(1.0)
    report = driven.driver.changed_faults()
    assert report is not None
    assert report.faults == (
        RobotFault(level=FaultLevel.FATAL, type="BLOCKED", text=words),
        RobotFault(level=FaultLevel.WARNING, type="DIRTY_SCANNER"),
    )
    driven.step(5.0)
    assert driven.driver.changed_faults() is None
    driven.restart()
    driven.vehicle.clear_errors()
    driven.step(2.0)
    report = driven.driver.changed_faults()
    assert report is not None
    assert report.faults == ()


def test_an_error_about_another_order_does_not_end_this_one() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.step(1.0)
    about = (Reference(reference_key="orderId", reference_value="someone else's"),)
    error = VehicleError(error_type="OLD", error_level=ErrorLevel.CRITICAL, error_references=about)
    driven.vehicle.raise_error(error, stops=False)
    assert driven.until_ended().state is ProgressState.FINISHED


def test_a_cancelled_packet_has_ended_once_the_vehicle_stands() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.step(2.0)
    driven.driver.cancel()
    assert driven.driver.poll().state is ProgressState.RUNNING
    ended = driven.until_ended()
    assert (ended.state, ended.detail) == (ProgressState.FAILED, "was cancelled")
    assert driven.vehicle.is_idle
    assert not moving(driven)


def test_a_packet_that_is_done_when_it_is_cancelled_has_finished() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    while driven.vehicle.history != ["bay"]:
        driven.clock.advance(0.1)
        driven.vehicle.step(0.1)
        driven.driver.advance()
        driven.driver.memory()
        driven.driver.flush(is_saved=True)
    driven.driver.cancel()
    assert driven.until_ended().state is ProgressState.FINISHED


def test_a_new_script_begins_a_new_order_after_a_cancel() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.step(2.0)
    driven.driver.cancel()
    driven.until_ended()
    other = ERRAND.model_copy(update={"id": "s2"})
    assert {one.state for one in driven.carry_out(other)} == {ProgressState.FINISHED}
    assert len({order.order_id for order in driven.orders}) == 2


def test_a_pause_holds_the_vehicle_until_it_is_resumed() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.step(1.0)
    driven.driver.pause()
    driven.step(1.0)
    assert not moving(driven)
    driven.driver.resume()
    driven.step(1.0)
    assert moving(driven)
    assert driven.until_ended().state is ProgressState.FINISHED
    assert driven.instant.count("startPause") == driven.instant.count("stopPause") == 1


def test_a_vehicle_that_somebody_paused_by_hand_is_left_alone() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.step(1.0)
    driven.vehicle.pause_by_hand()
    driven.step(30.0)
    assert not moving(driven)
    assert "stopPause" not in driven.instant


def test_a_vehicle_in_manual_mode_is_given_no_order() -> None:
    driven = Driven()
    driven.vehicle.clear_order(OperatingMode.MANUAL)
    driven.step(1.0)
    driven.begin(ERRAND, 0)
    ended = driven.until_ended()
    assert (ended.state, ended.detail) == (
        ProgressState.FAILED,
        "cannot begin: the vehicle's operating mode is MANUAL",
    )
    assert not driven.orders


def test_an_order_that_a_person_has_cleared_has_failed() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.step(2.0)
    driven.vehicle.clear_order(OperatingMode.MANUAL)
    ended = driven.until_ended()
    assert ended.state is ProgressState.FAILED
    assert ended.detail == "the vehicle has given up its order: its operating mode is MANUAL"


def test_a_vehicle_that_has_lost_its_order_while_driving_gets_a_new_one() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.step(2.0)
    driven.vehicle.forget_orders()
    driven.step(LOST_S - 0.5)
    assert len({order.order_id for order in driven.orders}) == 1, (
        "its state may have been on its way for long"
    )
    assert driven.until_ended().state is ProgressState.FINISHED
    assert len({order.order_id for order in driven.orders}) == 2


def test_a_pick_that_may_have_been_done_is_not_done_again() -> None:
    driven = Driven()
    driven.begin(ERRAND, 0)
    driven.until_ended()
    driven.begin(ERRAND, 1)
    while "pick" not in driven.vehicle.history:
        driven.clock.advance(0.1)
        driven.driver.advance()
        driven.driver.memory()
        driven.driver.flush(is_saved=True)
        driven.vehicle.step(0.1)
        if "pick" in driven.vehicle.history:
            driven.vehicle.forget_orders()
    driven.restart()  # and this process has not heard of it either
    driven.begin(ERRAND, 1)
    ended = driven.until_ended()
    assert ended.state in (ProgressState.FINISHED, ProgressState.FAILED)
    assert driven.vehicle.history.count("pick") == 1
    driven.step(30.0)
    assert driven.vehicle.history.count("pick") == 1


def test_a_charging_vehicle_stops_charging_before_it_is_given_an_order() -> None:
    driven = Driven()
    driven.vehicle.charging = True
    driven.step(1.0)
    driven.begin(ERRAND, 0)
    assert driven.until_ended().state is ProgressState.FINISHED
    assert driven.instant.count("stopCharging") == 1
    assert not driven.vehicle.charging


def test_nothing_is_sent_to_a_vehicle_whose_connection_is_broken() -> None:
    driven = Driven()
    driven.step(1.0)
    driven.driver.heard(Connection(connection_state=VehicleConnection.CONNECTION_BROKEN))
    driven.is_cut = True
    driven.begin(ERRAND, 0)
    driven.step(20.0)
    assert not driven.orders
    assert driven.driver.telemetry() is None
    driven.is_cut = False
    driven.driver.heard(Connection(connection_state=VehicleConnection.ONLINE))
    assert driven.until_ended().state is ProgressState.FINISHED


def test_a_vehicle_that_states_itself_long_after_its_last_will_is_connected() -> None:
    driven = Driven()
    driven.step(1.0)
    driven.driver.heard(Connection(connection_state=VehicleConnection.CONNECTION_BROKEN))
    driven.vehicle.pause_by_hand()
    driven.step(1.0)
    assert driven.driver.connection is VehicleConnection.CONNECTION_BROKEN
    driven.step(40.0)  # the vehicle states itself every 30 s
    assert driven.driver.connection is VehicleConnection.ONLINE


def test_nothing_is_sent_that_is_not_saved() -> None:
    driven = Driven()
    driven.step(1.0)
    driven.begin(ERRAND, 0)
    for _ in range(50):
        driven.clock.advance(0.1)
        driven.driver.advance()
        driven.driver.memory()
        driven.driver.flush(is_saved=False)
    assert not driven.orders


def test_telemetry_tells_pose_battery_and_distance_to_the_goal() -> None:
    driven = Driven()
    driven.vehicle.battery = 40.0
    driven.begin(ERRAND, 0)
    driven.step(1.0)
    driven.vehicle.show()
    told = driven.driver.telemetry()
    assert told is not None
    assert told.battery == 0.4
    assert told.x_m == pytest.approx(driven.vehicle.x)
    assert told.goal_m == pytest.approx(2.0 - driven.vehicle.x)
