"""The contract between the service and robots as documents: JSON Schemas of all messages, made from the wire types."""

from collections.abc import Mapping, Sequence
from typing import Any, get_args

from pydantic.json_schema import models_json_schema

from robots.link.mqtt.topics import Presence, WorldAnnouncement
from robots.wire import Message, WorldChange, WorldEdition
from robots.wire.messages import KnownBody

DRAFT = "http://json-schema.org/draft-07/schema#"
OF_FLEETS = (WorldChange, WorldEdition)
"""Bodies between the service and what simulates a world; no robot's."""

Schema = dict[str, Any]


def bodies() -> Mapping[str, type[Any]]:
    """The bodies of messages to and from robots, by their kind."""
    known: Sequence[type[Any]] = [body for body in get_args(get_args(KnownBody)[0]) if body not in OF_FLEETS]
    return {body.model_fields["kind"].default: body for body in known}


def schemas() -> Mapping[str, Schema]:
    """A schema that stands alone for each body, by its kind, for the envelope (`message`) and for what is retained."""
    models: Mapping[str, type[Any]] = {
        **bodies(),
        "message": Message,
        "presence": Presence,
        "world_announcement": WorldAnnouncement,
    }
    return {name: _alone(model) for name, model in sorted(models.items())}


def _alone(model: type[Any]) -> Schema:
    found, defined = models_json_schema([(model, "validation")], ref_template="#/definitions/{model}")
    definitions = {name: as_draft_07(one) for name, one in defined.get("$defs", {}).items()}
    (reference,) = found.values()
    name = reference["$ref"].rpartition("/")[2]
    top = definitions.pop(name)
    return {"$schema": DRAFT, **top, **({"definitions": definitions} if definitions else {})}


def as_draft_07(schema: Any) -> Any:
    """The schema in the words of the draft that AsyncAPI uses, without OpenAPI's."""
    if isinstance(schema, list):
        return [as_draft_07(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    words = {word: as_draft_07(value) for word, value in schema.items() if word != "discriminator"}
    if "prefixItems" in words:
        words["items"] = words.pop("prefixItems")
    return words
