"""paho's private method `_sock_recv`, which the client's read buffer replaces."""

import socket
from collections.abc import Iterator

import pytest
from paho.mqtt.client import MQTTMessage
from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion

from robots.link.mqtt.buffered_client import BufferedClient

CONNACK = bytes([0x20, 3, 0, 0, 0])


def publication(topic: str, payload: bytes) -> bytes:
    """A PUBLISH packet of MQTT 5, QoS 0, without properties."""
    content = len(topic).to_bytes(2, "big") + topic.encode() + b"\0" + payload
    return bytes([0x30, len(content)]) + content


@pytest.fixture
def connected() -> Iterator[tuple[BufferedClient, socket.socket]]:
    """A client and the broker's end of its connection."""
    client = BufferedClient(CallbackAPIVersion.VERSION2, "test", protocol=MQTTProtocolVersion.MQTTv5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        client.connect("127.0.0.1", server.getsockname()[1])
        broker, _ = server.accept()
        with broker:
            yield client, broker
            client.disconnect()


def test_paho_reads_through_sock_recv(connected: tuple[BufferedClient, socket.socket]) -> None:
    """If this fails, paho no longer reads by `_sock_recv(bufsize)`: use its plain client. All works as before, at four
    system calls a message more.
    """
    client, broker = connected
    arrived: list[bytes] = []

    def on_message(client: object, data: object, message: MQTTMessage) -> None:
        arrived.append(message.payload)

    client.on_message = on_message
    payloads = [b"one", b"two", b"three"]
    broker.sendall(CONNACK + b"".join(publication("a", payload) for payload in payloads))
    client.loop_read()
    assert client.has_more, "the first packet was read alone"
    while client.has_more:
        client.loop_read()
    assert arrived == payloads


def test_a_new_connection_starts_with_an_empty_buffer(
    connected: tuple[BufferedClient, socket.socket],
) -> None:
    client, broker = connected
    broker.sendall(CONNACK + publication("a", b"x"))
    client.loop_read()
    assert client.has_more
    client.reconnect()
    assert not client.has_more
