"""The published contract is made from the wire types, its examples are valid, and a minor version breaks nobody."""

import copy
import json
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema_rs
import pytest
import yaml
from typer.testing import CliRunner

from app.cli.main import app
from robots.link.mqtt import contract
from robots.link.mqtt.contract import asyncapi, asyncapi_text, bodies
from robots.link.mqtt.contract_examples import example, examples
from robots.link.mqtt.topics import Channel, channel_of, qos_of
from robots.wire import CONTRACT, Message, ScriptRequest
from tests.robots.link.mqtt.contract_changes import breaking_changes

DOCUMENTS = Path(__file__).parents[4] / "docs" / "contract"
WRITE = "macta robot contract --schemas docs/contract/schemas > docs/contract/asyncapi.yaml"
RELEASED = {
    path.stem: json.loads(path.read_text())
    for path in (DOCUMENTS / "released" / f"{CONTRACT.partition('.')[0]}.0").iterdir()
}
"""The schemas of this major version's first minor version."""
schemas = cache(contract.schemas)


def test_the_committed_documents_are_those_that_the_wire_types_make() -> None:
    assert (DOCUMENTS / "asyncapi.yaml").read_text() == asyncapi_text(), WRITE
    made = {f"{name}.json": json.dumps(one, indent=2) + "\n" for name, one in schemas().items()}
    kept = {path.name: path.read_text() for path in (DOCUMENTS / "schemas").iterdir()}
    assert kept == made, WRITE


def test_the_command_prints_the_document_and_writes_the_schemas(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["robot", "contract", "--schemas", str(tmp_path / "schemas")])
    assert done.exit_code == 0
    assert yaml.safe_load(done.output) == asyncapi()
    assert {path.stem for path in (tmp_path / "schemas").iterdir()} == schemas().keys()


def test_the_document_describes_every_kind_on_its_channel() -> None:
    channels = asyncapi()["channels"]
    described = {name for channel in channels.values() for name in channel["messages"]}
    assert described == {*bodies(), "presence", "world_announcement"}
    for name, said in examples().items():
        if isinstance(said, Message):
            channel = channel_of(said)
            assert name in channels[channel.value]["messages"]
            assert asyncapi()["operations"][
                f"{'receive' if said.receiver == 'fred' else 'send'}_{channel.value}"
            ]["bindings"]["mqtt"]["qos"] == (1 if name == "set_point" else qos_of(said))
    assert asyncapi()["operations"]["send_visualization"]["bindings"]["mqtt"]["qos"] == 0
    assert Channel.FACTSHEET.value in channels


@pytest.mark.parametrize("name", sorted(examples()))
def test_each_example_is_valid_by_the_schemas_and_by_the_wire_types(name: str) -> None:
    said = example(name)
    body = said.get("body", said)
    validator = jsonschema_rs.validator_for(schemas()[name])
    assert validator.is_valid(body)
    for required in schemas()[name]["required"]:
        assert not validator.is_valid({**body, required: {"not": "this"}})
    if "body" in said:
        assert jsonschema_rs.validator_for(schemas()["message"]).is_valid(said)
        assert Message.model_validate(said) == examples()[name]
    else:
        assert type(examples()[name]).model_validate(said) == examples()[name]


@pytest.mark.parametrize("name", sorted(examples()))
def test_unknown_fields_are_valid_by_the_schemas(name: str) -> None:
    said = example(name)
    body = said.get("body", said)
    assert jsonschema_rs.validator_for(schemas()[name]).is_valid({**body, "of_tomorrow": [1]})


def test_this_version_breaks_nobody_who_was_made_for_an_earlier_one_of_the_same_major() -> None:
    assert breaking_changes(RELEASED, schemas()) == []


def packet_of(changed: dict[str, Any]) -> dict[str, Any]:
    return changed["script_request"]["definitions"]["BehaviourPacket"]  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda new: new.pop("clearance"), "clearance is gone"),
        (
            lambda new: packet_of(new)["properties"].pop("after"),
            "script_request: BehaviourPacket.after is gone",
        ),
        (lambda new: new["telemetry"]["required"].append("battery"), "telemetry.battery is required"),
        (
            lambda new: new["control"]["definitions"]["ControlVerb"]["enum"].append("stop"),
            "control: ControlVerb: enum differs",
        ),
        (
            lambda new: new["control"]["properties"]["script_id"].update(type="integer"),
            "control.script_id: type differs",
        ),
        (
            lambda new: new["factsheet"]["properties"]["repertoire"].update(maxItems=9),
            "factsheet.repertoire: maxItems is narrower",
        ),
        (
            lambda new: new["presence"]["definitions"].pop("ConnectionState"),
            "presence: ConnectionState is gone",
        ),
    ],
)
def test_a_change_that_breaks_robots_is_found(change: Any, words: str) -> None:
    new = copy.deepcopy(dict(schemas()))
    change(new)
    assert words in breaking_changes(schemas(), new)


def test_an_optional_field_more_breaks_nobody() -> None:
    new = copy.deepcopy(dict(schemas()))
    new["telemetry"]["properties"]["firmware"] = {"type": "string", "default": ""}
    new["dance"] = {}
    packet_of(new)["properties"]["expected_start_s"].pop("minimum")
    assert breaking_changes(schemas(), new) == []


def test_examples_are_of_this_version() -> None:
    assert example("world_announcement")["contract"] == CONTRACT
    assert isinstance(examples()["script_request"].body, ScriptRequest)  # type: ignore[attr-defined]
