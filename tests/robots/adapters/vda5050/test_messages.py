"""What goes out is valid by the published schemas, in both versions; what comes in is kept, translated or refused."""

import json

import pytest

from robots.adapters.vda5050.codec import Encoder, MessageError, decode
from robots.adapters.vda5050.messages import (
    Connection,
    ErrorLevel,
    State,
    VehicleConnection,
    VehicleFactsheet,
    Visualization,
)
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.adapters.vda5050.version2 import from_version2, to_version2
from tests.robots.adapters.vda5050.driven import ERRAND, Driven
from tests.robots.adapters.vda5050.published_schemas import MAJORS, faults

V2 = VehicleId(manufacturer="ACME", serial_number="AGV-1", major=2)
V3 = VehicleId(manufacturer="ACME", serial_number="AGV-1", major=3)


@pytest.mark.parametrize("major", MAJORS)
def test_all_messages_of_an_errand_are_valid_by_the_published_schemas(major: int) -> None:
    driven = Driven(major)
    driven.vehicle.fails = frozenset({"drop"})
    driven.carry_out(ERRAND)
    driven.driver.pause()
    driven.step(3.0)
    driven.driver.resume()
    driven.step(3.0)
    driven.vehicle.show()
    kinds = {topic for topic, _ in (*driven.sent, *driven.told)}
    assert kinds == set(Topic)
    assert [
        fault for topic, payload in (*driven.sent, *driven.told) for fault in faults(major, topic, payload)
    ] == []


@pytest.mark.parametrize("major", MAJORS)
def test_the_schemas_find_fault_with_a_message_that_lacks_something(major: int) -> None:
    vehicle = V2 if major == 2 else V3
    message = Connection(connection_state=VehicleConnection.CONNECTION_BROKEN)
    data = json.loads(Encoder().encode(vehicle, Topic.CONNECTION, message))
    assert faults(major, Topic.CONNECTION, json.dumps(data).encode()) == []
    del data["serialNumber"]
    assert faults(major, Topic.CONNECTION, json.dumps(data).encode()) != []


def test_headers_count_each_topic_and_carry_utc() -> None:
    encoder = Encoder()
    sent = [json.loads(encoder.encode(V3, Topic.VISUALIZATION, Visualization())) for _ in range(2)]
    other = json.loads(encoder.encode(V3, Topic.STATE, State()))
    assert [one["headerId"] for one in (*sent, other)] == [0, 1, 0]
    assert sent[0]["timestamp"][-5] == "."
    assert sent[0]["timestamp"].endswith("Z")
    assert (sent[0]["version"], sent[0]["manufacturer"], sent[0]["serialNumber"]) == (
        "3.0.0",
        "ACME",
        "AGV-1",
    )


def test_a_vehicle_is_spoken_to_in_its_own_version() -> None:
    encoder = Encoder()
    encoder.speak(V2, "2.0.0")
    encoder.speak(V3, "2.0.0")
    assert json.loads(encoder.encode(V2, Topic.STATE, State()))["version"] == "2.0.0"
    assert json.loads(encoder.encode(V3, Topic.STATE, State()))["version"] == "3.0.0"


def test_unknown_fields_are_kept() -> None:
    said = {"orderId": "", "headerId": 7, "vendorSecret": {"a": 1}, "loads": [{"loadId": "x", "hue": 3}]}
    state = decode(V3, Topic.STATE, json.dumps(said).encode())
    again = json.loads(Encoder().encode(V3, Topic.STATE, state))
    assert again["vendorSecret"] == {"a": 1}
    assert again["loads"] == [{"loadId": "x", "hue": 3}]


@pytest.mark.parametrize(
    "payload", [b"", b"[]", b"{", b'{"orderUpdateId": "x"}', b'{"errors": [{"errorLevel": "LOUD"}]}']
)
def test_what_is_no_message_is_refused_with_a_reason(payload: bytes) -> None:
    with pytest.raises(MessageError, match=r".+"):
        decode(V3, Topic.STATE, payload)


def test_a_state_of_version_2_is_read_as_one_of_3() -> None:
    said = {
        "orderId": "o",
        "orderUpdateId": 1,
        "agvPosition": {"x": 1, "y": 2, "theta": 0.5, "mapId": "m", "positionInitialized": True},
        "batteryState": {"batteryCharge": 55, "charging": True, "reach": 100},
        "safetyState": {"eStop": "AUTOACK", "fieldViolation": False},
        "operatingMode": "TEACHIN",
        "actionStates": [
            {"actionId": "1", "actionType": "pick", "actionStatus": "FINISHED", "resultDescription": "ok"},
            {"actionId": "2", "actionType": "startPause", "actionStatus": "RUNNING"},
        ],
        "errors": [{"errorType": "t", "errorLevel": "FATAL"}],
    }
    state = decode(V2, Topic.STATE, json.dumps(said).encode())
    assert isinstance(state, State)
    assert state.mobile_robot_position is not None
    assert state.mobile_robot_position.localized
    assert (state.power_supply.state_of_charge, state.power_supply.charging) == (55, True)
    assert state.safety_state.active_emergency_stop == "MANUAL"
    assert state.operating_mode == "TEACH_IN"
    assert [one.action_id for one in state.action_states] == ["1"]
    assert [one.action_id for one in state.instant_action_states] == ["2"]
    assert state.errors[0].error_level is ErrorLevel.FATAL


@pytest.mark.parametrize("topic", list(Topic))
def test_what_both_versions_have_survives_the_way_to_2_and_back(topic: Topic) -> None:
    driven = Driven(3)
    driven.carry_out(ERRAND)
    driven.vehicle.show()
    payload = next(one for kind, one in reversed([*driven.sent, *driven.told]) if kind is topic)
    original = json.loads(payload)
    back = from_version2(topic, to_version2(topic, original))
    lost = {"referenceStateHeaderId"}
    first = decode(V3, topic, json.dumps({k: v for k, v in original.items() if k not in lost}).encode())
    second = decode(V3, topic, json.dumps(back).encode())
    if isinstance(first, VehicleFactsheet) and isinstance(second, VehicleFactsheet):
        assert first.physical_parameters == second.physical_parameters
        assert [one.action_type for one in first.protocol_features.mobile_robot_actions] == [
            one.action_type for one in second.protocol_features.mobile_robot_actions
        ]
    elif topic is not Topic.ORDER:  # whose edges name their nodes in 2.x
        assert first == second


def test_topics_name_vehicles_of_both_versions_and_nothing_else() -> None:
    assert VehicleId.of_topic("uagv/v3/ACME/AGV-1/state") == (V3, Topic.STATE)
    assert VehicleId.of_topic("uagv/v2/ACME/AGV-1/order") == (V2, Topic.ORDER)
    assert VehicleId.of_topic("uagv/v1/ACME/AGV-1/state") is None
    assert VehicleId.of_topic("uagv/v3/ACME/AGV-1/zoneSet") is None
    assert VehicleId.of_topic("macta/v1/hall/agv/state") is None
