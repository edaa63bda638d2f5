"""The event stream in the API's reference: a schema for every event, from the classes of `app.domain.events`."""

from collections.abc import Mapping
from dataclasses import dataclass
from inspect import getdoc
from typing import Any

from pydantic import BaseModel, TypeAdapter

from app.api.bodies import GoalBody
from app.api.mission_bodies import MissionBody
from app.domain.events import event_classes
from app.domain.plan_document import PlanBody

REF = "#/components/schemas/{model}"
ANY_EVENT = "Event"
GOAL_STATE = "goal.state"
PLAN_STATE = "plan.state"
MISSION_STATE = "mission.state"
RESET = "stream.reset"


@dataclass(frozen=True, slots=True, kw_only=True)
class EventReference:
    """The documentation of a class of events.

    :param data: the JSON schema of the event's data.
    :param definitions: the schemas that `data` refers to, by name.
    """

    name: str
    types: tuple[str, ...]
    summary: str
    data: Mapping[str, Any]
    definitions: Mapping[str, Any]

    @property
    def envelope(self) -> dict[str, Any]:
        """The JSON schema of the event as the stream sends it."""
        return {
            "title": self.name,
            "description": self.summary,
            "type": "object",
            "required": ["seq", "time", "type", "subject", "data"],
            "properties": {
                "seq": {"type": "integer", "description": "resume after it by `Last-Event-ID`"},
                "time": {
                    "type": ["string", "null"],
                    "description": "ISO 8601; null in the initial state",
                },
                "type": {"type": "string", "enum": list(self.types)},
                "subject": {"type": "string"},
                "data": dict(self.data),
            },
        }


def references() -> list[EventReference]:
    """Every event of the log, then those that exist only in the stream."""
    return [*_logged(), *_of_the_stream()]


def event_schemas() -> dict[str, Any]:
    """The schemas of all events by name, and of an event as one of them."""
    schemas: dict[str, Any] = {}
    mapping: dict[str, str] = {}
    for one in references():
        schemas |= one.definitions
        schemas[one.name] = one.envelope
        mapping |= dict.fromkeys(one.types, REF.format(model=one.name))
    schemas[ANY_EVENT] = {
        "title": ANY_EVENT,
        "description": "A message of `GET /v1/events`.",
        "oneOf": [{"$ref": ref} for ref in dict.fromkeys(mapping.values())],
        "discriminator": {"propertyName": "type", "mapping": mapping},
    }
    return schemas


def event_table() -> str:
    """The events as a table in Markdown: type, meaning, fields of the data."""
    lines = ["| Type | Meaning | Data |", "|---|---|---|"]
    for one in references():
        types = ", ".join(f"`{type_}`" for type_ in one.types)
        lines.append(f"| {types} | {one.summary} | {_fields(one.data)} |")
    return "\n".join(lines) + "\n"


def _fields(data: Mapping[str, Any]) -> str:
    if "$ref" in data:
        return f"as `{data['$ref'].rpartition('/')[2]}`"
    return ", ".join(f"`{name}`" for name in data["properties"])


def _logged() -> list[EventReference]:
    found = []
    for event in event_classes():
        schema = TypeAdapter(event).json_schema(ref_template=REF, mode="serialization")
        fields = {name: body for name, body in schema["properties"].items() if name != "subject"}
        found.append(
            EventReference(
                name=event.__name__,
                types=event.types(),
                summary=" ".join((getdoc(event) or "").split()),
                data={"type": "object", "properties": fields, "required": list(fields)},
                definitions=schema.get("$defs", {}),
            )
        )
    return found


def _snapshot(name: str, type_: str, summary: str, body: type[BaseModel]) -> EventReference:
    return EventReference(
        name=name,
        types=(type_,),
        summary=summary,
        data={"$ref": REF.format(model=body.__name__)},
        definitions={},
    )


def _of_the_stream() -> list[EventReference]:
    open_plan = "A plan that waits for a decision, as the stream begins."
    return [
        _snapshot("GoalSnapshot", GOAL_STATE, "A goal as the stream begins.", GoalBody),
        _snapshot("PlanSnapshot", PLAN_STATE, open_plan, PlanBody),
        _snapshot("MissionSnapshot", MISSION_STATE, "A mission as the stream begins.", MissionBody),
        EventReference(
            name="StreamReset",
            types=(RESET,),
            summary="What followed the event `seen` is no longer kept; the current state follows.",
            data={"type": "object", "properties": {"seen": {"type": "integer"}}, "required": ["seen"]},
            definitions={},
        ),
    ]
