"""One MQTT 5 client: its subscriptions, what it publishes on connecting, and its last will."""

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
from paho.mqtt.subscribeoptions import SubscribeOptions

from robots.link.mqtt.broker import Broker
from robots.link.mqtt.buffered_client import BufferedClient

KEEPALIVE_S = 10
"""The broker publishes the last will of a client that is silent for one and a half times this."""
CONNECT_TIMEOUT_S = 3.0
DISCONNECT_TIMEOUT_S = 1.0
MAX_QUEUED = 1000
"""Messages of one client without the broker's receipt. More are dropped; their senders send them again."""
MAX_PACKET_BYTES = 4 * 2**20
"""The broker is told not to forward larger messages."""
RUN_PROPERTY = "run"
COUNTER_PROPERTY = "counter"
SIGNATURE_PROPERTY = "signature"

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Publication:
    """A message at the broker. `run`: the run of the world that it belongs to; empty if that does not matter.

    `waits`: it waits for its turn at any QoS; telemetry does not. `counter`, `signature`: of a robot that signs
    (`robots.link.mqtt.signature`).
    """

    topic: str
    payload: bytes
    qos: int = 1
    retain: bool = False
    run: str = ""
    waits: bool = False
    counter: str = ""
    signature: str = ""


class Session:
    """A client of the broker. It is served by a `Reactor`'s thread; `publish` may be called from any."""

    def __init__(
        self,
        broker: Broker,
        client_id: str,
        *,
        subscriptions: Sequence[tuple[str, int | SubscribeOptions]] = (),
        will: Publication | None = None,
        on_connected: Callable[[], Publication | None] = lambda: None,
        on_arrival: Callable[[Publication], None] = lambda publication: None,
        queued: int = MAX_QUEUED,
        sign: Callable[[Publication], Publication] | None = None,
    ) -> None:
        """
        :param subscriptions: topics with their QoS, or further options.
        :param on_connected: returns what to publish each time it is connected.
        :param on_arrival: called with each arrival, by the reactor's thread.
        :param sign: signs what is published; None: nothing is signed.
        """
        self._sign = sign
        self._will = will
        self.name = client_id
        self.dropped = 0
        self.refused = ""
        """Why the broker refused the connection; empty if it did not, or is unreachable."""
        self.closed_early = False
        """The broker closed the connection before it accepted or refused it."""
        self.disconnecting = False
        self.retired = False
        """It must not connect again."""
        self.connected = False
        self.wake: Callable[[Session], None] = lambda session: None
        self._subscriptions = [
            (topic, options if isinstance(options, SubscribeOptions) else SubscribeOptions(qos=options))
            for topic, options in subscriptions
        ]
        self._on_connected = on_connected
        self._on_arrival = on_arrival
        self.client = self._client(broker, client_id, queued)
        if will is not None:
            self.set_will(will)

    def set_will(self, will: Publication) -> None:
        """Have the broker publish this when the connection is lost; from the next connection on."""
        self._will = will
        self._renew_will()

    def before_connecting(self) -> None:
        """To be called before each connection: a will that is signed is of that connection."""
        if self._sign is not None:
            self._renew_will()

    def _renew_will(self) -> None:
        if self._will is None:
            return
        will = self._will if self._sign is None else self._sign(self._will)
        properties = _properties(will, PacketTypes.WILLMESSAGE)
        self.client.will_set(will.topic, will.payload, will.qos, will.retain, properties)

    def publish(self, publication: Publication) -> bool:
        """Queue it for the broker; False, and lost, if the broker is unreachable or the queue is full."""
        # NOTE: outdated telemetry is useless, so it does not queue behind telemetry.
        late = publication.qos == 0 and not publication.waits and self.client.want_write()
        if not self.connected or late or not self._queued(publication):
            self.dropped += 1
            return False
        self.wake(self)
        return True

    def _queued(self, publication: Publication) -> bool:
        if self._sign is not None:
            publication = self._sign(publication)
        info = self.client.publish(
            publication.topic,
            publication.payload,
            publication.qos,
            publication.retain,
            _properties(publication),
        )
        return info.rc == MQTTErrorCode.MQTT_ERR_SUCCESS

    def _client(self, broker: Broker, client_id: str, queued: int) -> BufferedClient:
        client = BufferedClient(CallbackAPIVersion.VERSION2, client_id, protocol=MQTTProtocolVersion.MQTTv5)
        client.connect_timeout = CONNECT_TIMEOUT_S
        client.max_queued_messages_set(queued)
        if broker.username is not None:
            password = broker.password.get_secret_value() if broker.password is not None else None
            client.username_pw_set(broker.username, password)
        if broker.tls is not None:
            client.tls_set_context(broker.tls)
        client.on_connect = self._on_connect
        client.on_disconnect = self._on_disconnect
        client.on_message = self._on_message
        # NOTE: with this set, paho leaves all writing to the reactor; otherwise `publish` writes itself.
        client.on_socket_register_write = lambda client, data, socket: None
        bounds = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]
        bounds.MaximumPacketSize = MAX_PACKET_BYTES
        client.connect_async(broker.host, broker.port, KEEPALIVE_S, clean_start=True, properties=bounds)
        return client

    def _on_connect(
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
        self.refused = ""
        if self.disconnecting:  # it was removed while it connected
            client.disconnect()
            return
        if self._subscriptions:
            client.subscribe(self._subscriptions)
        first = self._on_connected()
        if first is not None:
            self._queued(first)
        self.connected = True  # last, for other threads publish and disconnect from now on

    def _on_disconnect(
        self,
        client: Client,
        data: Any,
        flags: DisconnectFlags,
        reason: ReasonCode,
        properties: Properties | None,
    ) -> None:
        self.closed_early = not (self.connected or self.refused or self.disconnecting)
        self.connected = False
        if self.disconnecting and (sock := client.socket()) is not None:
            _drain(sock)

    def _on_message(self, client: Client, data: Any, message: MQTTMessage) -> None:
        pairs = dict(getattr(message.properties, "UserProperty", ()))
        publication = Publication(
            topic=message.topic,
            payload=bytes(message.payload),
            qos=message.qos,
            retain=message.retain,
            run=pairs.get(RUN_PROPERTY, ""),
            counter=pairs.get(COUNTER_PROPERTY, ""),
            signature=pairs.get(SIGNATURE_PROPERTY, ""),
        )
        try:
            self._on_arrival(publication)
        except Exception:  # one arrival must not end the reactor's thread
            logger.exception("%s: a message on %s could not be handled", self.name, message.topic)


def _drain(sock: Any) -> None:
    """Wait until the broker has read our DISCONNECT and closed.

    NOTE: closing with unread arrivals resets the connection, and the broker may lose our last messages.
    """
    with suppress(OSError):
        sock.settimeout(DISCONNECT_TIMEOUT_S)
        sock.shutdown(socket.SHUT_WR)
        while sock.recv(65536):
            pass


def _properties(publication: Publication, packet: int = PacketTypes.PUBLISH) -> Properties | None:
    pairs = [
        (name, value)
        for name, value in (
            (RUN_PROPERTY, publication.run),
            (COUNTER_PROPERTY, publication.counter),
            (SIGNATURE_PROPERTY, publication.signature),
        )
        if value
    ]
    if not pairs:
        return None
    properties = Properties(packet)  # type: ignore[no-untyped-call]
    properties.UserProperty = pairs
    return properties
