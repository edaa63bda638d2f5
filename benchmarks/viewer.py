"""The three-dimensional view of a world: what it sends to its browsers, and its costs.

    uv run python -m benchmarks.viewer [ROBOTS [BROWSERS [SECONDS]]]

A process serves a world of driving robots with telemetry ten times a second, as the service does; the view runs in a
process of its own, as beside `macta serve`. The browsers are sockets that receive and unpack messages, and draw
nothing. Prints the updates of all robots that each browser gets a second, the longest gap between two, their size, and
the share of a core that the view takes.
"""

import asyncio
import json
import math
import multiprocessing
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator
from itertools import pairwise
from typing import Any

import msgspec
import uvicorn
import viser
import zstandard
from fastapi import FastAPI, WebSocket
from fastapi.responses import StreamingResponse
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from benchmarks.processes import cpu_s

TELEMETRY_S = 0.1
SETTLE_S = 3.0
SECRET = "any"
APART_M = 2.5
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (0.0, 1.0, 0.0, 0.0),
    "position": (20.0, 20.0, 40.0),
    "fov": 0.8,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 900,
    "image_width": 1200,
    "look_at": (20.0, 20.0, 0.0),
    "up_direction": (0.0, 1.0, 0.0),
}


def main() -> None:
    robots, browsers, seconds = _given(1, 256), _given(2, 1), _given(3, 10)
    api, port = _free_port(), _free_port()
    service = multiprocessing.Process(target=_serve, args=(api, robots), daemon=True)
    service.start()
    view = subprocess.Popen(
        [sys.executable, "-m", "web.viewer", "--api", f"http://127.0.0.1:{api}", "--port", str(port)],
        env={**os.environ, "MACTA_TOKEN": "any", "MACTA_VIEWER_SECRET": SECRET},
        stdout=subprocess.DEVNULL,
    )
    try:
        connected = [Browser(port) for _ in range(browsers)]
        for browser in connected:
            browser.wait()
        time.sleep(SETTLE_S)
        used_s = cpu_s(view.pid)
        for browser in connected:
            browser.begin()
        time.sleep(seconds)
        share = (cpu_s(view.pid) - used_s) / seconds
        for browser in connected:
            print(browser.told(seconds))
        print(f"{robots} robots, {browsers} browsers: the view takes {share:.0%} of a core")
    finally:
        view.terminate()
        view.wait()
        service.terminate()


class Browser:
    """Receives what the view sends, and counts the updates of the robots' places."""

    def __init__(self, port: int) -> None:
        self._updates: list[float] = []
        self._bytes = 0
        threading.Thread(target=self._take, args=(port,), daemon=True).start()

    def wait(self) -> None:
        """Wait for the first update."""
        while not self._updates:
            time.sleep(0.1)

    def begin(self) -> None:
        self._updates, self._bytes = [], 0

    def told(self, seconds: float) -> str:
        updates = self._updates
        gaps_s = [later - earlier for earlier, later in pairwise(updates)]
        return (
            f"{len(updates) / seconds:.1f} updates a second, the longest gap {max(gaps_s, default=seconds):.2f} s, "
            f"{self._bytes / seconds / 1e6:.2f} MB a second"
        )

    def _take(self, port: int) -> None:
        unpack = zstandard.ZstdDecompressor()
        protocol = Subprotocol(f"viser-v{viser.__version__}")
        with _open(port, protocol) as stream:
            stream.send(msgspec.msgpack.encode(CAMERA))
            for frame in stream:
                assert isinstance(frame, bytes)
                self._bytes += len(frame)
                packed = int.from_bytes(frame[8:16], "little")
                told = msgspec.msgpack.decode(unpack.decompress(frame[16 : 16 + packed]))
                if any(_moves_robots(message) for message in told["messages"]):
                    self._updates.append(time.monotonic())


def _moves_robots(message: dict[str, Any]) -> bool:
    return message.get("name") == "/robots/hull" and "batched_positions" in message.get("updates", {})


def _open(port: int, protocol: Subprotocol) -> Any:
    """The view's socket, waiting for a view that has just begun."""
    give_up = time.monotonic() + 120
    while True:
        try:
            return connect(
                f"ws://relay:{SECRET}@127.0.0.1:{port}",
                subprotocols=[protocol],
                compression=None,
                max_size=None,
                proxy=None,
            )
        except OSError:
            if time.monotonic() > give_up:
                raise
            time.sleep(0.1)


def _serve(port: int, robots: int) -> None:
    """Serve what the view requests of a service, for one world."""
    app, side = FastAPI(), math.ceil(math.sqrt(robots))
    names = [f"robot_{number}" for number in range(robots)]
    homes = {name: (APART_M * (i % side), APART_M * (i // side)) for i, name in enumerate(names)}
    ground = [-APART_M, APART_M * side]
    layout = {
        "compartments": [{"name": "yard", "x": ground, "y": ground}],
        "robots": [{"name": name, "start": [*homes[name], 0]} for name in names],
    }

    @app.get("/v1/worlds")
    def worlds() -> dict[str, Any]:
        return {"items": [{"id": "plain"}]}

    @app.get("/v1/worlds/plain")
    def world() -> dict[str, Any]:
        return {"title": "plain", "layout": layout}

    @app.get("/v1/worlds/plain/facts")
    def facts() -> dict[str, Any]:
        return {"items": []}

    @app.websocket("/v1/views")
    async def views(view: WebSocket) -> None:
        await view.accept()
        await view.receive()

    @app.get("/v1/telemetry")
    async def telemetry() -> StreamingResponse:
        return StreamingResponse(_lines(homes), media_type="text/event-stream")

    uvicorn.run(app, host="127.0.0.1", port=port, log_level="error")


async def _lines(homes: dict[str, tuple[float, float]]) -> AsyncIterator[str]:
    """Every robot drives in a circle round its home."""
    began = time.monotonic()
    for tick in range(10**9):
        now_s = tick * TELEMETRY_S
        turn = now_s * 0.5
        robots = {
            name: {
                "x_m": x + math.cos(turn),
                "y_m": y + math.sin(turn),
                "heading_rad": turn + math.pi / 2,
                "ranges_m": [None, 1.2] * 8,
                "holding": None,
                "packet_tag": "NAVIGATE",
                "packet_state": "running",
                "at_s": now_s,
            }
            for name, (x, y) in homes.items()
        }
        yield f"data: {json.dumps({'time_s': now_s, 'robots': robots})}\n\n"
        await asyncio.sleep(max(0.0, began + now_s + TELEMETRY_S - time.monotonic()))


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _given(place: int, otherwise: int) -> int:
    return int(sys.argv[place]) if len(sys.argv) > place else otherwise


if __name__ == "__main__":
    main()
