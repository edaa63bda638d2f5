"""One MQTT 5 client: who it is, what it hears, what it says when it comes and what is said when it is lost."""

import logging
import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from paho.mqtt.client import Client, ConnectFlags, DisconnectFlags, MQTTMessage
from paho.mqtt.enums import CallbackAPIVersion, MQTTErrorCode, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.reasoncodes import ReasonCode

from robots.link.mqtt.broker import Broker
from robots.link.mqtt.buffered_client import BufferedClient

KEEPALIVE_S = 10
"""A client that is silent for one and a half times this is taken for lost, and its last will is sent."""
CONNECT_S = 3.0
LEAVE_S = 1.0
QUEUED_AT_MOST = 1000
"""Messages of one client that wait for the broker's receipt. More are dropped: their senders send them again."""
MOST_BYTES = 4 * 2**20
"""Larger messages the broker is told to keep to itself: nobody who is in order sends such."""
RUN = "run"

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Parcel:
    """What goes over the broker. `run` is of which run of the world it speaks; empty if that does not matter."""

    topic: str
    payload: bytes
    qos: int = 1
    retain: bool = False
    run: str = ""


class Session:
    """A client of the broker. It is served by a `Reactor`'s thread; `publish` may be called from any."""

    def __init__(
        self,
        broker: Broker,
        client_id: str,
        *,
        hears: Sequence[tuple[str, int]] = (),
        will: Parcel | None = None,
        greets: Callable[[], Parcel | None] = lambda: None,
        takes: Callable[[Parcel], None] = lambda parcel: None,
        queued: int = QUEUED_AT_MOST,
    ) -> None:
        """
        :param hears: topics to subscribe to, with their QoS.
        :param greets: what to say each time it is connected.
        :param takes: called with each arrival, by the reactor's thread.
        """
        self.name = client_id
        self.dropped = 0
        self.refused = ""
        """Why the broker does not let it in; empty if it does, or is away."""
        self.turned_away = False
        """The connection was closed before it was let in or refused."""
        self.leaving = False
        """It is about to disconnect."""
        self.retired = False
        """It is not to connect again."""
        self.connected = False
        self.wake: Callable[[Session], None] = lambda session: None
        self._hears, self._greets, self._takes = list(hears), greets, takes
        self.client = self._client(broker, client_id, queued)
        if will is not None:
            self.client.will_set(will.topic, will.payload, will.qos, will.retain)

    def publish(self, parcel: Parcel) -> bool:
        """Hand it to the broker; False if that is away, or what waits for it is too much already: it is lost then."""
        # NOTE: telemetry is of worth only while it is new, so it does not queue behind telemetry.
        late = parcel.qos == 0 and self.client.want_write()
        if not self.connected or late or not self._queued(parcel):
            self.dropped += 1
            return False
        self.wake(self)
        return True

    def _queued(self, parcel: Parcel) -> bool:
        info = self.client.publish(
            parcel.topic, parcel.payload, parcel.qos, parcel.retain, _properties(parcel.run)
        )
        return info.rc == MQTTErrorCode.MQTT_ERR_SUCCESS

    def _client(self, broker: Broker, client_id: str, queued: int) -> BufferedClient:
        client = BufferedClient(CallbackAPIVersion.VERSION2, client_id, protocol=MQTTProtocolVersion.MQTTv5)
        client.connect_timeout = CONNECT_S
        client.max_queued_messages_set(queued)
        if broker.username is not None:
            password = broker.password.get_secret_value() if broker.password is not None else None
            client.username_pw_set(broker.username, password)
        if broker.tls is not None:
            client.tls_set_context(broker.tls)
        client.on_connect, client.on_disconnect = self._came, self._went
        client.on_message = self._heard
        # NOTE: with this set paho leaves all writing to the reactor; without, `publish` would write itself.
        client.on_socket_register_write = lambda client, data, socket: None
        bounds = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]
        bounds.MaximumPacketSize = MOST_BYTES
        client.connect_async(broker.host, broker.port, KEEPALIVE_S, clean_start=True, properties=bounds)
        return client

    def _came(
        self,
        client: Client,
        data: Any,
        flags: ConnectFlags,
        reason: ReasonCode,
        properties: Properties | None,
    ) -> None:
        if reason.is_failure:
            self.refused = str(reason)
            return
        self.refused, self.connected = "", True
        if self._hears:
            client.subscribe(self._hears)
        greeting = self._greets()
        if greeting is not None:
            self._queued(greeting)

    def _went(
        self,
        client: Client,
        data: Any,
        flags: DisconnectFlags,
        reason: ReasonCode,
        properties: Properties | None,
    ) -> None:
        self.turned_away = not (self.connected or self.refused or self.leaving)
        self.connected = False
        if self.leaving and (sock := client.socket()) is not None:
            _hear_out(sock)

    def _heard(self, client: Client, data: Any, message: MQTTMessage) -> None:
        pairs = getattr(message.properties, "UserProperty", ())
        run = next((value for name, value in pairs if name == RUN), "")
        parcel = Parcel(
            topic=message.topic,
            payload=bytes(message.payload),
            qos=message.qos,
            retain=message.retain,
            run=run,
        )
        try:
            self._takes(parcel)
        except Exception:  # what cannot be done with one arrival must not end the listening
            logger.exception("%s: what came on %s could not be taken", self.name, message.topic)


def _hear_out(sock: Any) -> None:
    """Wait until the broker has taken our leave and closed.

    NOTE: to close with arrivals unread resets the connection; the broker may then lose our last words, the leave too.
    """
    with suppress(OSError):
        sock.settimeout(LEAVE_S)
        sock.shutdown(socket.SHUT_WR)
        while sock.recv(65536):
            pass


def _properties(run: str) -> Properties | None:
    if not run:
        return None
    properties = Properties(PacketTypes.PUBLISH)  # type: ignore[no-untyped-call]
    properties.UserProperty = [(RUN, run)]
    return properties
