"""A stand-in for the browser's half of the view: connects as viser's page does, and clicks."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import msgspec
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

SECRET = "what-only-the-relay-knows"
PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (0.0, 1.0, 0.0, 0.0),  # straight down
    "position": (4.0, 3.0, 12.0),
    "fov": 0.8,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": (4.0, 3.0, 0.0),
    "up_direction": (0.0, 1.0, 0.0),
}


class FakeBrowser:
    """One connected frame; what it is sent is counted and thrown away."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self.frames = 0
        threading.Thread(target=self._take, daemon=True).start()
        self.say(**CAMERA)

    def say(self, **message: Any) -> None:
        self._socket.send(msgspec.msgpack.encode(message))

    def click(self, node: str, instance: int | None = None, owner: str = "") -> None:
        self.say(
            type="SceneNodeClickMessage",
            name=node,
            instance_index=instance,
            ray_origin=(0.0, 0.0, 5.0),
            ray_direction=(0.0, 0.0, -1.0),
            screen_pos=(0.5, 0.5),
            modifier=None,
            owner=owner,
        )

    def _take(self) -> None:
        with suppress(ConnectionClosed):  # however the view ends
            for _ in self._socket:
                self.frames += 1


@contextmanager
def browsing(port: int, page: str = "") -> Iterator[FakeBrowser]:
    """A frame of `page` at the view's own port, as the service relays it, open for the length of the block."""
    address = f"ws://relay:{SECRET}@127.0.0.1:{port}/{page}"
    with connect(address, subprotocols=[PROTOCOL], compression=None, max_size=None, proxy=None) as socket:
        yield FakeBrowser(socket)
