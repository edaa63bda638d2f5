"""The contract with viser's private names, one test for each: what it says fails when viser changes it."""

import warnings
from collections.abc import Iterator

import httpx2
import pytest
import viser
import viser.infra
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from tests.ports import free_port
from tests.waiting import awaited, until
from tests.web.fake_browser import CAMERA, PROTOCOL, SECRET, browsing
from web.viser_private import guarded_server, ignore_closed_connections, move, request_path

MOVED = {name: value for name, value in CAMERA.items() if name != "type"} | {"fov": 0.5}


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = guarded_server(port=free_port(), secret=SECRET)
    yield server
    server.stop()


@pytest.mark.parametrize(
    ("user", "headers", "status"),
    [
        ("", {}, 401),
        ("relay:another-secret@", {}, 401),
        ("relay:sécret@", {}, 401),
        (f"relay:{SECRET}@", {"Origin": "http://evil.example"}, 403),
        (f"relay:{SECRET}@", {"Origin": "http://127.0.0.1"}, 403),
    ],
    ids=["no secret", "a wrong one", "not ascii", "another site", "a page of this host"],
)
def test_the_port_answers_only_the_relay(
    server: viser.ViserServer, user: str, headers: dict[str, str], status: int
) -> None:
    at = f"{user}127.0.0.1:{server.get_port()}/"
    assert httpx2.get(f"http://{at}", headers=headers, trust_env=False).status_code == status
    with pytest.raises(InvalidStatus) as refused:
        connect(f"ws://{at}", subprotocols=[PROTOCOL], additional_headers=headers, proxy=None)
    assert refused.value.response.status_code == status
    assert server.get_clients() == {}


def test_the_relay_gets_the_page(server: viser.ViserServer) -> None:
    answer = httpx2.get(f"http://relay:{SECRET}@127.0.0.1:{server.get_port()}/", trust_env=False)
    assert (answer.status_code, "<html" in answer.text) == (200, True)


def test_other_servers_of_websockets_are_not_guarded() -> None:
    guarded_server(port=free_port(), secret=SECRET).stop()
    other = viser.ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
    assert httpx2.get(f"http://127.0.0.1:{other.get_port()}/", trust_env=False).status_code == 200
    other.stop()


def test_no_message_opens_the_public_tunnel(
    server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    monkeypatch.setattr(server, "request_share_url", lambda: asked.append("open"))
    monkeypatch.setattr(server, "disconnect_share_url", lambda: asked.append("close"))
    with browsing(server.get_port()) as browser:
        (client,) = awaited(server.get_clients, len).values()
        browser.say(type="ShareUrlRequest")
        browser.say(type="ShareUrlDisconnect")
        # Taken after the others.
        browser.say(type="ViewerCameraMessage", **MOVED)
        until(lambda: client.camera.fov == MOVED["fov"])
    assert asked == []


def test_live_connections_tell_the_path_that_each_browser_asked_for(server: viser.ViserServer) -> None:
    with browsing(server.get_port(), "page-one"):
        (client,) = awaited(server.get_clients, len)
        assert request_path(server, client) == "/page-one"
    until(lambda: request_path(server, client) == "")


def test_a_node_is_moved_by_the_messages_of_visers_own_setter(
    server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    label = server.scene.add_label("/moved", "text")
    sent: list[viser.infra.Message] = []
    monkeypatch.setattr(viser.infra.WebsockMessageHandler, "queue_message", lambda _, one: sent.append(one))
    for at in ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)):
        label.position = at
    for at in ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (4.0, 5.0, 6.0)):
        move(label, at)
    assert sent[2:] == sent[:2] != []
    assert tuple(label.position) == (4.0, 5.0, 6.0)


def test_the_warning_of_a_closed_connection_is_recognised_by_its_text(server: viser.ViserServer) -> None:
    with browsing(server.get_port()):
        (client,) = awaited(server.get_clients, len).values()
    until(lambda: not server.get_clients())
    with pytest.warns(UserWarning, match="Queued a .* on a closed connection"):
        client.scene.add_frame("/late")
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        ignore_closed_connections()
        client.scene.add_frame("/later")
    assert heard == []
