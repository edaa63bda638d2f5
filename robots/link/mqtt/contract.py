"""The contract between the service and robots as documents, made from the wire types: AsyncAPI and JSON Schemas."""

from collections.abc import Mapping, Sequence
from typing import Any, get_args

import yaml
from pydantic.json_schema import models_json_schema

from robots.link.mqtt.contract_examples import example, examples
from robots.link.mqtt.topics import (
    ROOT,
    SERVICE,
    Channel,
    Presence,
    WorldAnnouncement,
    channel_of,
)
from robots.wire import CONTRACT, ForeignState, Message, NotUnderstood, Telemetry, WorldChange, WorldEdition
from robots.wire.messages import KnownBody

DRAFT = "http://json-schema.org/draft-07/schema#"
OF_FLEETS = (ForeignState, WorldChange, WorldEdition)
"""Bodies between the service and what simulates a world; no robot's."""
WORLD_TOPIC = "world"
HEARD = "heard"
"""The channel of the speech that the robot hears."""
RETAINED = {Channel.CONNECTION: "presence", Channel.FACTSHEET: "factsheet"}
"""The channels whose last message the broker keeps, with its name."""
SUMMARIES = {
    Channel.ORDER: "Scripts for the robot.",
    Channel.INSTANT_ACTIONS: "Everything else to the robot: orders on scripts, clearances, queries, receipts.",
    Channel.STATE: "Reports and answers of the robot.",
    Channel.VISUALIZATION: "The robot's telemetry, about once a second or faster while it moves; without an envelope.",
    Channel.CONNECTION: "Whether the robot is connected. Retained; `connection_broken` is its last will.",
    Channel.FACTSHEET: "What the robot is. Retained.",
    Channel.SPEECH: "What the robot says to another one; only the robot may publish here.",
}
ABOUT = """\
How a robot works with a Macta service over an MQTT 5 broker. This document describes the robot: it receives what the
service sends, and sends what the service receives.

Messages are JSON. Receivers keep fields that they do not know, and answer messages of kinds that they do not know with
`not_understood`. Every message but telemetry and presence carries the MQTT user property `run`, the world's run as it
was last announced; messages of another run are ignored. Times are the world's, in seconds since its run began.

docs/robots.md explains the contract with sequence diagrams. A minor version adds optional fields and kinds; only a
major one removes or requires more.
"""

Schema = dict[str, Any]


def bodies() -> Mapping[str, type[Any]]:
    """The bodies of messages to and from robots, by their kind."""
    known: Sequence[type[Any]] = [body for body in get_args(get_args(KnownBody)[0]) if body not in OF_FLEETS]
    return {body.model_fields["kind"].default: body for body in known}


def schemas() -> Mapping[str, Schema]:
    """A schema that stands alone for each body, by its kind, for the envelope (`message`) and for what is retained."""
    models: Mapping[str, type[Any]] = {**_models(), "message": Message}
    return {name: _alone(models[name]) for name in sorted(models)}


def asyncapi() -> Schema:
    """The AsyncAPI 3.0 document of a robot."""
    return {
        "asyncapi": "3.0.0",
        "info": {
            "title": "Macta robot",
            "version": CONTRACT,
            "description": ABOUT,
            "license": {"name": "Apache-2.0", "url": "https://www.apache.org/licenses/LICENSE-2.0"},
        },
        "defaultContentType": "application/json",
        "servers": {
            "broker": {
                "host": "broker:1883",
                "protocol": "mqtt",
                "protocolVersion": "5.0",
                "description": "The broker between service and robots; with TLS on port 8883 (mqtts).",
            }
        },
        "channels": {
            **{channel.value: _channel(channel) for channel in Channel},
            HEARD: _heard(),
            WORLD_TOPIC: _world(),
        },
        "operations": _operations(),
        "components": {
            "parameters": {
                "world": {"description": "The world's name."},
                "robot": {
                    "description": "The robot's name: a small letter, then small letters, digits and _."
                },
                "other": {"description": "Another robot's name."},
            },
            "messages": {name: _message(name) for name in examples()},
            "schemas": _components(),
        },
    }


def asyncapi_text() -> str:
    """The document as YAML."""
    _Dumper.add_representer(str, _text)
    return yaml.dump(asyncapi(), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110)


class _Dumper(yaml.SafeDumper):
    """Writes texts of several lines as blocks, and what is used twice twice."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style="|" if "\n" in text else None)


def _models() -> Mapping[str, type[Any]]:
    return {**bodies(), "presence": Presence, "world_announcement": WorldAnnouncement}


def _kinds_of(channel: Channel) -> Sequence[str]:
    """The names of the messages on a channel."""
    if channel is Channel.CONNECTION:
        return [RETAINED[channel]]
    to_service = channel not in (Channel.ORDER, Channel.INSTANT_ACTIONS)
    found = []
    for name, said in examples().items():
        if isinstance(said, Telemetry):
            matches = channel is Channel.VISUALIZATION
        elif channel is Channel.SPEECH:
            matches = isinstance(said, Message) and channel_of(said) is channel
        elif isinstance(said, Message):
            matches = channel_of(said) is channel and (said.receiver == SERVICE) is to_service
        else:
            matches = False
        if matches or (name == NotUnderstood.model_fields["kind"].default and _takes_answers(channel)):
            found.append(name)
    return sorted(found)


def _takes_answers(channel: Channel) -> bool:
    return channel in (Channel.INSTANT_ACTIONS, Channel.STATE)


def _channel(channel: Channel) -> Schema:
    names = ("world", "robot", "other") if channel is Channel.SPEECH else ("world", "robot")
    parameters = {name: {"$ref": f"#/components/parameters/{name}"} for name in names}
    return {
        "address": f"{ROOT}/{{world}}/{{robot}}/{channel.value}" + "/{other}" * (channel is Channel.SPEECH),
        "description": SUMMARIES[channel],
        "parameters": parameters,
        "messages": _references(_kinds_of(channel)),
    }


def _heard() -> Schema:
    parameters = {name: {"$ref": f"#/components/parameters/{name}"} for name in ("world", "robot", "other")}
    return {
        "address": f"{ROOT}/{{world}}/{{other}}/{Channel.SPEECH.value}/{{robot}}",
        "description": "What another robot says to this one; only the other may publish here.",
        "parameters": parameters,
        "messages": _references(_kinds_of(Channel.SPEECH)),
    }


def _world() -> Schema:
    return {
        "address": f"{ROOT}/{{world}}/{WORLD_TOPIC}",
        "description": "The world's run and time, announced every second. Retained.",
        "parameters": {"world": {"$ref": "#/components/parameters/world"}},
        "messages": _references(["world_announcement"]),
    }


def _references(names: Sequence[str]) -> Schema:
    return {name: {"$ref": f"#/components/messages/{name}"} for name in names}


def _operations() -> Schema:
    to_robot = (Channel.ORDER, Channel.INSTANT_ACTIONS)
    found = {
        f"receive_{channel.value}" if channel in to_robot else f"send_{channel.value}": _operation(
            channel.value,
            action="receive" if channel in to_robot else "send",
            qos=channel.qos,
            retain=channel in RETAINED,
        )
        for channel in Channel
    }
    heard = _operation(HEARD, action="receive", qos=Channel.SPEECH.qos, retain=False)
    return found | {
        f"receive_{HEARD}": heard,
        "receive_world": _operation(WORLD_TOPIC, action="receive", qos=1, retain=True),
    }


def _operation(channel: str, *, action: str, qos: int, retain: bool) -> Schema:
    return {
        "action": action,
        "channel": {"$ref": f"#/channels/{channel}"},
        "bindings": {"mqtt": {"qos": qos, "retain": retain, "bindingVersion": "0.2.0"}},
    }


def _message(name: str) -> Schema:
    """A message with its envelope, if it has one."""
    said = examples()[name]
    model = _models()[name]
    summary = (model.__doc__ or "").strip().splitlines()[0]
    found: Schema = {"name": name, "title": model.__name__, "summary": summary}
    if not isinstance(said, Message):
        return {
            **found,
            "payload": {"$ref": f"#/components/schemas/{model.__name__}"},
            "examples": [{"name": name, "payload": example(name)}],
        }
    return {
        **found,
        "headers": {
            "type": "object",
            "description": "MQTT user properties.",
            "required": ["run"],
            "properties": {"run": {"type": "string", "description": "The world's run."}},
        },
        "payload": {
            "allOf": [
                {"$ref": "#/components/schemas/Message"},
                {
                    "type": "object",
                    "properties": {"body": {"$ref": f"#/components/schemas/{model.__name__}"}},
                },
            ]
        },
        "examples": [{"name": name, "headers": {"run": "run-4f2a"}, "payload": example(name)}],
    }


def _components() -> Mapping[str, Schema]:
    """The schemas of all messages, by their types; the envelope's body may be any."""
    models: Sequence[type[Any]] = [Message, *_models().values()]
    _, defined = models_json_schema(
        [(model, "validation") for model in models], ref_template="#/components/schemas/{model}"
    )
    found = {name: as_draft_07(one) for name, one in defined["$defs"].items()}
    _open_body(found["Message"])
    hidden = {model.__name__ for model in OF_FLEETS} | {"UnknownBody"}
    return {name: found[name] for name in sorted(found.keys() - hidden)}


def _open_body(message: Schema) -> None:
    message["properties"]["body"] = {
        "type": "object",
        "description": "The body of one kind.",
        "required": ["kind"],
        "properties": {"kind": {"type": "string"}},
    }


def _alone(model: type[Any]) -> Schema:
    found, defined = models_json_schema([(model, "validation")], ref_template="#/definitions/{model}")
    definitions = {name: as_draft_07(one) for name, one in defined.get("$defs", {}).items()}
    (reference,) = found.values()
    top = definitions.pop(reference["$ref"].rpartition("/")[2])
    if model is Message:
        _open_body(top)
        definitions = {"Performative": definitions["Performative"]}
    return {"$schema": DRAFT, **top, **({"definitions": definitions} if definitions else {})}


def as_draft_07(schema: Any, *, names: bool = False) -> Any:
    """The schema in the words of the draft that AsyncAPI uses, without OpenAPI's and without generated titles.

    :param names: its keys are names of fields, not words of JSON Schema.
    """
    if isinstance(schema, list):
        return [as_draft_07(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    if names:
        return {name: as_draft_07(one) for name, one in schema.items()}
    found = {
        word: as_draft_07(value, names=word == "properties") if word not in LITERAL else value
        for word, value in schema.items()
        if word not in ("discriminator", "title")
    }
    if "prefixItems" in found:
        found["items"] = found.pop("prefixItems")
    if found.get("additionalProperties") == {}:
        found["additionalProperties"] = True
    constants = [name for name, one in found.get("properties", {}).items() if "const" in one]
    if constants:  # they tell one kind from another
        found["required"] = [*constants, *found.get("required", ())]
    return found


LITERAL = frozenset({"default", "enum", "const", "required", "examples"})
"""Words whose values are data, not schemas."""
