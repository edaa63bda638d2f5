"""A client that reads what its socket has in one go.

paho asks the socket for each packet's first byte, then for its length byte by byte, then for the rest: four calls of
the system and a look whether there is more, for every word of telemetry.
"""

from typing import Any

from paho.mqtt.client import Client

CHUNK = 65536


class ReadingClient(Client):
    """NOTE: `_sock_recv` is not part of paho's interface, which is why its version is bounded."""

    _chunk = b""
    _at = 0

    @property
    def has_more(self) -> bool:
        """True while something is read and not handled."""
        return self._at < len(self._chunk)

    def reconnect(self) -> Any:
        self._chunk, self._at = b"", 0
        return super().reconnect()

    def _sock_recv(self, bufsize: int) -> bytes:
        if not self.has_more:
            self._chunk, self._at = super()._sock_recv(CHUNK), 0
        part = self._chunk[self._at : self._at + bufsize]
        self._at += len(part)
        return part
