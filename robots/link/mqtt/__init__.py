"""The link over an MQTT 5 broker, for production: the robots' end, the service's end, and a clock that follows.

Topics and connection semantics are VDA 5050's, the payloads our wire types. What an end sends while the broker is away
is lost, as by radio; robots and service send again what matters, so nothing rests on the broker's memory.
"""

from robots.link.mqtt.broker import Broker, BrokerError
from robots.link.mqtt.fleet import FleetLink
from robots.link.mqtt.following_clock import FollowingClock
from robots.link.mqtt.service import ServiceLink
from robots.link.mqtt.topics import ConnectionState, Presence, Proclamation

__all__ = [
    "Broker",
    "BrokerError",
    "ConnectionState",
    "FleetLink",
    "FollowingClock",
    "Presence",
    "Proclamation",
    "ServiceLink",
]
