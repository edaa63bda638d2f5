"""Messages to and from bytes: headers, numbers and timestamps on the way out, both versions' forms either way."""

import json
import logging
from collections import Counter
from collections.abc import Callable
from datetime import datetime, timezone
from typing import Any

from pydantic import ValidationError

from robots.adapters.vda5050.messages import (
    Connection,
    Headed,
    InstantActions,
    Order,
    State,
    VehicleFactsheet,
    Visualization,
    json_of,
)
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.adapters.vda5050.version2 import from_version2, to_version2
from robots.errors import RobotError
from robots.link.mqtt.session import Publication

MAX_BYTES = 1024 * 1024
TYPES: dict[Topic, type[Headed]] = {
    Topic.ORDER: Order,
    Topic.INSTANT_ACTIONS: InstantActions,
    Topic.STATE: State,
    Topic.VISUALIZATION: Visualization,
    Topic.CONNECTION: Connection,
    Topic.FACTSHEET: VehicleFactsheet,
}


logger = logging.getLogger(__name__)


class MessageError(RobotError):
    """Raised when what has arrived is no message of its topic; says what is wrong with it."""


def utc_now() -> datetime:
    return datetime.now(timezone.utc)


class Encoder:
    """Fills in headers: a number for each topic of each vehicle, counted from 0 (§7.2)."""

    def __init__(self, now: Callable[[], datetime] = utc_now) -> None:
        self._now = now
        self._numbers: Counter[tuple[VehicleId, Topic]] = Counter()
        self._versions: dict[VehicleId, str] = {}

    def speak(self, vehicle: VehicleId, version: str) -> None:
        """State this version of the standard to a vehicle from now on: some take no other than their own."""
        if version.partition(".")[0] == str(vehicle.major):
            self._versions[vehicle] = version[:20]

    def encode(self, vehicle: VehicleId, topic: Topic, message: Headed) -> bytes:
        """The message as the vehicle's version of the standard has it."""
        number = self._numbers[vehicle, topic]
        self._numbers[vehicle, topic] += 1
        header = {
            "header_id": number,
            "timestamp": timestamp(self._now()),
            "version": self._versions.get(vehicle, vehicle.version),
            "manufacturer": vehicle.manufacturer,
            "serial_number": vehicle.serial_number,
        }
        data = json_of(message.model_copy(update=header))
        if vehicle.major == 2:
            data = to_version2(topic, data)
        return json.dumps(data, separators=(",", ":")).encode()


def timestamp(at: datetime) -> str:
    """ISO 8601 in UTC, with milliseconds: `1991-03-11T11:40:03.123Z`."""
    return f"{at.astimezone(timezone.utc):%Y-%m-%dT%H:%M:%S}.{at.microsecond // 1000:03d}Z"


def decode(vehicle: VehicleId, topic: Topic, payload: bytes) -> Headed:
    """What has arrived on a vehicle's topic.

    :raises MessageError: if it is no such message.
    """
    if len(payload) > MAX_BYTES:
        raise MessageError(f"{len(payload)} bytes; at most {MAX_BYTES} are taken")
    try:
        data: Any = json.loads(payload)
    except ValueError as error:
        raise MessageError(f"not JSON: {error}") from error
    if not isinstance(data, dict):
        raise MessageError("not a JSON object")
    if vehicle.major == 2:
        data = from_version2(topic, data)
    try:
        return TYPES[topic].model_validate(data)
    except ValidationError as error:
        fault = error.errors()[0]
        raise MessageError(f"{'.'.join(map(str, fault['loc']))}: {fault['msg']}") from error


class Reader:
    """Reads what arrives on vehicles' topics; what is no message is dropped and counted."""

    def __init__(
        self, on_malformed: Callable[[VehicleId, Topic], None] = lambda vehicle, topic: None
    ) -> None:
        """:param on_malformed: called for each that is dropped."""
        self._malformed = 0
        self._on_malformed = on_malformed

    def read(self, publication: Publication) -> tuple[VehicleId, Headed] | None:
        """The vehicle and its message; None for what is dropped, and for what was taken back."""
        found = VehicleId.of_topic(publication.topic)
        if found is None or not publication.payload:
            return None
        vehicle, topic = found
        try:
            return vehicle, decode(vehicle, topic, publication.payload)
        except MessageError as error:
            self._malformed += 1
            self._on_malformed(vehicle, topic)
            if str(self._malformed).strip("0") == "1":  # the first, the tenth, the hundredth …
                logger.warning(
                    "dropped an invalid message on %s (%d so far): %s",
                    publication.topic,
                    self._malformed,
                    error,
                )
            return None
