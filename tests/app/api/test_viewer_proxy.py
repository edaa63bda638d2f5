"""The relay of /viewer/, before a real viser server."""

import asyncio
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import httpx2
import msgspec
import numpy as np
import pytest
import uvicorn
import viser
import viser.infra
from fastapi import FastAPI
from starlette.requests import HTTPConnection
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus
from websockets.typing import Subprotocol

from app.api.viewer_proxy import is_share_request, view_router, viewer_router
from tests.ports import free_port
from web.viser_private import guarded_server

PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")
VIEWS = 3
TOKEN = {"authorization": "Bearer secret"}


def authenticate(connection: HTTPConnection) -> bool:
    return connection.headers.get("authorization") == TOKEN["authorization"]


@dataclass
class Relay:
    host: str
    viser: viser.ViserServer
    upstream: str | None


@pytest.fixture(scope="module")
def relay() -> Iterator[Relay]:
    view = guarded_server(port=free_port(), secret="of-the-view")
    relay = Relay(host="", viser=view, upstream=f"http://relay:of-the-view@127.0.0.1:{view.get_port()}")
    app = FastAPI()
    app.include_router(view_router(lambda: relay.upstream))
    app.include_router(viewer_router(lambda: relay.upstream, authenticate, max_open=VIEWS))
    port = free_port()
    server = uvicorn.Server(
        uvicorn.Config(app, host="127.0.0.1", port=port, log_level="error", lifespan="off")
    )
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    relay.host = f"127.0.0.1:{port}"
    yield relay
    server.should_exit = True
    thread.join(10)
    view.stop()


def get(relay: Relay, path: str, headers: dict[str, str] = TOKEN) -> httpx2.Response:
    return httpx2.get(f"http://{relay.host}{path}", headers=headers, trust_env=False)


def frame(type_: str, **fields: object) -> bytes:
    return msgspec.msgpack.encode({"type": type_, **fields})


async def until(rule: Callable[[], bool], timeout_s: float = 5.0) -> bool:
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        if rule():
            return True
        await asyncio.sleep(0.01)
    return False


def test_the_page_comes_through_whole(relay: Relay) -> None:
    answer = get(relay, "/viewer/")
    direct = httpx2.get(f"{relay.upstream}/", trust_env=False)
    assert answer.status_code == 200
    assert answer.text == direct.text
    assert "frame-ancestors 'self'" in answer.headers["content-security-policy"]


def test_a_page_learns_whether_the_view_can_be_opened(relay: Relay) -> None:
    there = relay.upstream
    assert get(relay, "/v1/view").json() == {"running": True}
    try:
        for upstream in (None, f"http://127.0.0.1:{free_port()}"):
            relay.upstream = upstream
            assert get(relay, "/v1/view").json() == {"running": False}
    finally:
        relay.upstream = there


def test_the_page_is_refused_without_a_token(relay: Relay) -> None:
    answer = get(relay, "/viewer/", headers={})
    assert answer.status_code == 401
    assert answer.headers["content-type"] == "application/problem+json"


def test_the_address_without_its_slash_leads_to_the_page(relay: Relay) -> None:
    answer = get(relay, "/viewer")
    assert (answer.status_code, answer.headers["location"]) == (307, "viewer/")


def test_a_missing_viser_server_is_a_problem_one_can_read(relay: Relay) -> None:
    upstream, relay.upstream = relay.upstream, None
    try:
        assert get(relay, "/viewer/").json()["detail"] == "the view of the world is not running"
        relay.upstream = f"http://127.0.0.1:{free_port()}"
        assert get(relay, "/viewer/").status_code == 503
    finally:
        relay.upstream = upstream


@pytest.mark.parametrize(
    "headers",
    [{}, TOKEN | {"origin": "http://elsewhere.example"}],
    ids=["no token", "another site's page"],
)
def test_the_socket_is_refused_to_strangers(relay: Relay, headers: dict[str, str]) -> None:
    async def knock() -> None:
        async with connect(f"ws://{relay.host}/viewer", additional_headers=headers, proxy=None):
            pass

    with pytest.raises(InvalidStatus):
        asyncio.run(knock())


def test_the_socket_speaks_the_asked_protocol_and_carries_large_frames(relay: Relay) -> None:
    relay.viser.scene.add_point_cloud(
        "/many", np.zeros((1_000_000, 3), dtype=np.float32), colors=(0, 0, 0), precision="float32"
    )

    async def listen() -> tuple[str | None, int]:
        address = f"ws://{relay.host}/viewer"
        async with connect(
            address, subprotocols=[PROTOCOL], additional_headers=TOKEN, proxy=None, max_size=None
        ) as page:
            sizes = [0]
            while max(sizes) < 8_000_000:
                sizes.append(len(await asyncio.wait_for(page.recv(), 20)))
            return page.subprotocol, max(sizes)

    protocol, largest = asyncio.run(listen())
    assert protocol == PROTOCOL
    assert largest >= 8_000_000


def test_a_page_of_another_version_is_refused(relay: Relay) -> None:
    async def listen() -> int | None:
        address = f"ws://{relay.host}/viewer"
        protocols = [Subprotocol("viser-v0.0.1")]
        async with connect(address, subprotocols=protocols, additional_headers=TOKEN, proxy=None) as page:
            await asyncio.wait_for(page.wait_closed(), 10)
            return page.close_code

    assert asyncio.run(listen()) == 1002


def test_share_requests_never_reach_viser_while_other_messages_do(relay: Relay) -> None:
    heard: list[str] = []
    original = viser.infra.WebsockMessageHandler._handle_incoming_message

    async def listen(self: object, client: object, message: object) -> None:
        heard.append(type(message).__name__)
        await original(self, client, message)  # type: ignore[arg-type]

    async def speak() -> bool:
        address = f"ws://{relay.host}/viewer"
        async with connect(
            address, subprotocols=[PROTOCOL], additional_headers=TOKEN, proxy=None, max_size=None
        ) as page:
            await page.send(frame("ShareUrlRequest"))
            await page.send(frame("ShareUrlDisconnect"))
            await page.send("text is no message")
            await page.send(frame("GuiUpdateMessage", uuid="none", updates={"value": 1}))
            return await until(lambda: "GuiUpdateMessage" in heard)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(viser.infra.WebsockMessageHandler, "_handle_incoming_message", listen)
        assert asyncio.run(speak())
    assert not [name for name in heard if name.startswith("Share")]


def test_frames_that_cannot_be_read_count_as_share_requests() -> None:
    assert is_share_request(b"\xc1")
    assert is_share_request(msgspec.msgpack.encode(["ShareUrlRequest"]))
    assert is_share_request(frame("ShareUrlRequest"))
    assert not is_share_request(frame("ViewerCameraMessage", fov=1.0))


def test_of_views_only_so_many_may_be_open_and_one_that_is_closed_makes_room(relay: Relay) -> None:
    address = f"ws://{relay.host}/viewer"

    def view() -> connect:
        return connect(address, subprotocols=[PROTOCOL], additional_headers=TOKEN, proxy=None, max_size=None)

    async def look() -> None:
        opened = [await view() for _ in range(VIEWS)]
        with pytest.raises(InvalidStatus):
            await view()
        for one in opened:
            await one.close()
        async with asyncio.timeout(20):
            while True:
                try:
                    await (await view()).close()
                except InvalidStatus:
                    await asyncio.sleep(0.01)
                else:
                    return

    asyncio.run(look())
