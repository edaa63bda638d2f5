"""A client that reads its socket in large chunks, by paho's private method `_sock_recv`.

paho reads each packet's first byte, its length byte by byte, and then the rest: four system calls and a select() for
every message of telemetry. `tests/robots/link/mqtt/test_buffered_client.py` is its contract test.
"""

from typing import Any

from paho.mqtt.client import Client

CHUNK_BYTES = 65536


class BufferedClient(Client):
    """A paho client with a read buffer. `loop_read` must be called again while `has_more`."""

    _chunk = b""
    _position = 0

    @property
    def has_more(self) -> bool:
        """True while the buffer holds bytes that are not handled."""
        return self._position < len(self._chunk)

    def reconnect(self) -> Any:
        self._chunk = b""
        self._position = 0
        return super().reconnect()

    def _sock_recv(self, bufsize: int) -> bytes:
        if not self.has_more:
            self._chunk = super()._sock_recv(CHUNK_BYTES)
            self._position = 0
        part = self._chunk[self._position : self._position + bufsize]
        self._position += len(part)
        return part
