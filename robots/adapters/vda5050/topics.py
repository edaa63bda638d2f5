"""The topics of VDA 5050, `{interface}/{major version}/{manufacturer}/{serial number}/{topic}` (§4.2)."""

import re
from dataclasses import dataclass

from typing_extensions import Self

from robots.data import StrEnum

INTERFACE = "uagv"
"""The usual first level; an installation may have another."""
LEVEL = re.compile(r"[^/+#$]+")
SERIAL = re.compile(r"[A-Za-z0-9_.:-]+")


class Topic(StrEnum):
    """The topics that are used."""

    ORDER = "order"
    """Master to vehicle."""
    INSTANT_ACTIONS = "instantActions"
    """Master to vehicle."""
    STATE = "state"
    """Vehicle to master."""
    VISUALIZATION = "visualization"
    """Vehicle to master, often."""
    CONNECTION = "connection"
    """Vehicle to master, retained; the broker publishes the last will."""
    FACTSHEET = "factsheet"
    """Vehicle to master."""

    @property
    def qos(self) -> int:
        """At least once for connections, at most once for all others (§4.1)."""
        return 1 if self is Topic.CONNECTION else 0

    @property
    def is_for_vehicles(self) -> bool:
        return self in (Topic.ORDER, Topic.INSTANT_ACTIONS)


OF_VEHICLES = tuple(topic for topic in Topic if not topic.is_for_vehicles)
OF_MASTERS = tuple(topic for topic in Topic if topic.is_for_vehicles)


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class VehicleId:
    """A vehicle by its manufacturer and serial number, and the major version that it speaks, 2 or 3."""

    manufacturer: str
    serial_number: str
    major: int = 3

    @property
    def version(self) -> str:
        """The version that messages to and from it state."""
        return "3.0.0" if self.major >= 3 else "2.1.0"

    def topic(self, interface: str, topic: Topic) -> str:
        return f"{interface}/v{self.major}/{self.manufacturer}/{self.serial_number}/{topic}"

    @classmethod
    def of_topic(cls, address: str) -> tuple[Self, Topic] | None:
        """The vehicle and topic of an MQTT topic; None if it is none of VDA 5050's, 2 or 3."""
        parts = address.split("/")
        if len(parts) != 5 or parts[1] not in ("v2", "v3") or parts[4] not in Topic.__members__.values():
            return None
        vehicle = cls(manufacturer=parts[2], serial_number=parts[3], major=int(parts[1][1:]))
        return vehicle, Topic(parts[4])

    def __str__(self) -> str:
        return f"{self.manufacturer}/{self.serial_number}"


def subscription(interface: str, major: int, topic: Topic) -> str:
    """The topic filter for all vehicles of one major version."""
    return f"{interface}/v{major}/+/+/{topic}"
