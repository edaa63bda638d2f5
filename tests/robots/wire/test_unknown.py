"""Messages of a newer version: unknown fields are kept, unknown kinds are read and answered with not-understood."""

import json
from typing import Any

import pytest
from pydantic import ValidationError

from robots.wire import (
    Factsheet,
    Message,
    NotUnderstood,
    Performative,
    Receipt,
    ScriptRequest,
    Telemetry,
    UnknownBody,
    UnknownKinds,
)
from robots.wire.unknown_kinds import PER_S, REMEMBERED


def envelope(body: dict[str, Any], message_id: str = "m1", **fields: Any) -> str:
    plain = {
        "id": message_id,
        "performative": "inform",
        "sender": "fred",
        "receiver": "service",
        "sent_at_s": 1.0,
        "body": body,
    }
    return json.dumps(plain | fields)


def unknown(message_id: str) -> Message:
    return Message.model_validate_json(envelope({"kind": "dance"}, message_id))


POSE = {"kind": "telemetry", "at_s": 1.0, "x_m": 1.0, "y_m": 2.0, "heading_rad": 0.0}
PACKET = {
    "id": "a1",
    "tag": "NAVIGATE",
    "arguments": {},
    "achieves": [{"predicate": "near", "args": ["fred", "door"], "since_s": 3}],
    "expected_start_s": 0,
    "expected_duration_s": 1,
    "timeout_s": 1,
    "wait_timeout_s": 1,
    "urgency": {"level": 2},
}


def test_unknown_fields_are_kept_at_every_depth() -> None:
    script = {"id": "s", "mission_id": "m", "robot": "fred", "packets": [PACKET], "colour": None}
    text = envelope({"kind": "script_request", "script": script}, hop=[1, {"deep": True}])
    message = Message.model_validate_json(text)
    assert isinstance(message.body, ScriptRequest)
    again = json.loads(Message.model_validate_json(message.model_dump_json()).model_dump_json())
    assert again["hop"] == [1, {"deep": True}]
    assert again["body"]["script"]["colour"] is None
    packet = again["body"]["script"]["packets"][0]
    assert (packet["urgency"], packet["achieves"][0]["since_s"]) == ({"level": 2}, 3)


def test_telemetry_and_factsheets_with_a_field_more_are_read() -> None:
    telemetry = Telemetry.model_validate_json(json.dumps(POSE | {"firmware": "4.2"}))
    assert json.loads(telemetry.model_dump_json(exclude_defaults=True))["firmware"] == "4.2"
    sheet = {"repertoire": ["NAVIGATE"], "speed_m_s": 0.4, "turn_rad_s": 1.0}
    old, new = (Factsheet.model_validate(sheet | {"firmware": one}) for one in ("4.2", "4.3"))
    assert old.content != new.content


@pytest.mark.parametrize("value", ["1e999", '{"a": [NaN]}'])
def test_an_unknown_field_with_a_number_that_json_cannot_hold_is_refused(value: str) -> None:
    text = envelope(POSE).replace('"x_m": 1.0', f'"x_m": 1.0, "q": {value}')
    with pytest.raises(ValidationError, match="numbers are finite"):
        Message.model_validate_json(text)


def test_a_message_of_an_unknown_kind_is_read_and_written_as_it_is() -> None:
    body = {"kind": "dance", "steps": [1, 2], "with": {"name": "ginger"}}
    message = Message.model_validate_json(envelope(body))
    assert isinstance(message.body, UnknownBody)
    assert json.loads(message.model_dump_json())["body"] == body


@pytest.mark.parametrize("body", [{"kind": "telemetry", "at_s": 1.0}, {"steps": 1}, {"kind": ""}, "dance"])
def test_a_malformed_body_is_not_of_an_unknown_kind(body: Any) -> None:
    with pytest.raises(ValidationError):
        Message.model_validate_json(envelope(body))


def test_a_message_of_an_unknown_kind_is_answered_once() -> None:
    kinds = UnknownKinds()
    assert kinds.answer(unknown("m1"), 0.0) == NotUnderstood(reason="unknown kind dance")
    assert kinds.answer(unknown("m1"), 9.0) is None


@pytest.mark.parametrize("body", [NotUnderstood(reason="unknown kind dance"), Receipt()])
def test_known_kinds_are_not_answered_with_not_understood(body: NotUnderstood | Receipt) -> None:
    message = Message(
        performative=Performative.CONFIRM, sender="service", receiver="fred", sent_at_s=0, body=body
    )
    assert UnknownKinds().answer(message, 0.0) is None


def test_many_messages_of_unknown_kinds_are_answered_at_a_bounded_rate() -> None:
    kinds = UnknownKinds()
    at_once = [kinds.answer(unknown(f"m{number}"), 5.0) for number in range(50)]
    assert sum(answer is not None for answer in at_once) == PER_S
    assert kinds.unanswered == 50 - PER_S
    later = [kinds.answer(unknown(f"n{number}"), 5.5) for number in range(50)]
    assert sum(answer is not None for answer in later) == PER_S / 2
    assert kinds.answer(unknown("again"), 1.0) is not None  # the clock of a new run began at 0


def test_what_was_answered_is_forgotten_in_the_end() -> None:
    kinds = UnknownKinds()
    for number in range(REMEMBERED + 1):
        assert kinds.answer(unknown(f"m{number}"), float(number)) is not None
    assert kinds.answer(unknown("m0"), 1000.0) is not None
    assert kinds.answer(unknown(f"m{REMEMBERED}"), 1001.0) is None
