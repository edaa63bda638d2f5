"""A TCP relay before the broker, on whose connections a robot can be cut off."""

import asyncio
import threading
from contextlib import suppress

from app.domain.errors import Unavailable
from robots.link.mqtt.broker import Broker

CHUNK_BYTES = 65536


class TcpRelay:
    """Implements `app.cli.trials.conformance.check.Relay`. Bytes pass as they are, so that TLS is the broker's."""

    def __init__(self, host: str, port: int, broker: Broker) -> None:
        """:raises Unavailable: if it cannot listen there."""
        self._broker = broker
        self._is_cut = False
        self._connections: dict[asyncio.StreamWriter, asyncio.StreamWriter] = {}
        """By the robot's end the broker's."""
        self._loop = asyncio.new_event_loop()
        try:
            self._server = self._loop.run_until_complete(asyncio.start_server(self._serve, host, port))
        except OSError as error:
            self._loop.close()
            raise Unavailable(f"--relay: cannot listen at {host}:{port}: {error.strerror}") from error
        port = self._server.sockets[0].getsockname()[1]
        self.address = f"{host}:{port}"
        self._thread = threading.Thread(target=self._loop.run_forever, name="relay", daemon=True)
        self._thread.start()

    def cut(self) -> int:
        async def cut() -> int:
            self._is_cut = True
            return self._abort()

        return asyncio.run_coroutine_threadsafe(cut(), self._loop).result()

    def restore(self) -> None:
        self._is_cut = False

    def close(self) -> None:
        """End all connections, and listen no longer."""

        async def close() -> None:
            self._server.close()
            self._abort()
            tasks = asyncio.all_tasks() - {asyncio.current_task()}
            await asyncio.gather(*tasks, return_exceptions=True)

        asyncio.run_coroutine_threadsafe(close(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _abort(self) -> int:
        """End all connections without a word, as a lost radio does."""
        for pair in self._connections.items():
            for writer in pair:
                writer.transport.abort()
        return len(self._connections)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._is_cut:
            writer.transport.abort()
            return
        try:
            from_broker, to_broker = await asyncio.open_connection(self._broker.host, self._broker.port)
        except OSError:
            writer.transport.abort()
            return
        if self._is_cut:
            writer.transport.abort()
            to_broker.transport.abort()
            return
        self._connections[writer] = to_broker
        try:
            await asyncio.gather(_pass_on(reader, to_broker), _pass_on(from_broker, writer))
        finally:
            del self._connections[writer]


async def _pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Pass bytes on until the connection ends, and end the other one."""
    with suppress(OSError):
        while chunk := await reader.read(CHUNK_BYTES):
            writer.write(chunk)
            await writer.drain()
    writer.close()
