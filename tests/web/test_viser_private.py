"""The contract with viser's private names, one test for each: what it says fails when viser changes it."""

import warnings

import pytest
import viser

from tests.ports import free_port
from tests.waiting import awaited, until
from tests.web.fake_browser import browsing
from web.viser_private import ignore_closed_connections, request_path


@pytest.fixture
def server() -> viser.ViserServer:
    return viser.ViserServer(host="127.0.0.1", port=free_port(), verbose=False)


def test_live_connections_tell_the_path_that_each_browser_asked_for(server: viser.ViserServer) -> None:
    with browsing(server.get_port(), "page-one"):
        (client,) = awaited(server.get_clients, len)
        assert request_path(server, client) == "/page-one"
    until(lambda: request_path(server, client) == "")
    server.stop()


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
    server.stop()
