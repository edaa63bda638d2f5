"""The link over an MQTT 5 broker, for production: the robots' end, the service's end, and the service's world clock.

Topics and connection semantics are VDA 5050's, payloads our wire types. Messages sent while the broker is unreachable
are lost, as by radio; both ends repeat what matters, so nothing depends on the broker's memory.
"""

from robots.link.mqtt.broker import Broker, BrokerError
from robots.link.mqtt.fleet import FleetLink
from robots.link.mqtt.following_clock import FollowingClock
from robots.link.mqtt.robot import RobotLink
from robots.link.mqtt.service import ServiceLink
from robots.link.mqtt.topics import ConnectionState, Presence, WorldAnnouncement

__all__ = [
    "Broker",
    "BrokerError",
    "ConnectionState",
    "FleetLink",
    "FollowingClock",
    "Presence",
    "RobotLink",
    "ServiceLink",
    "WorldAnnouncement",
]
