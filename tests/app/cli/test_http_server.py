"""The server answers before there is an API."""

from collections.abc import Iterator

import httpx2
import pytest
from starlette.responses import PlainTextResponse

from app.cli.http_server import HttpServer
from app.cli.serve import listen
from app.settings import Settings


@pytest.fixture
def server() -> Iterator[HttpServer]:
    with listen(Settings(port=0)) as listener, HttpServer(listener) as server:
        yield server


def test_before_the_api_is_made_the_process_is_alive_and_not_ready(server: HttpServer) -> None:
    with httpx2.Client(base_url=f"http://127.0.0.1:{server.port}") as client:
        assert client.get("/healthz").json() == {"status": "alive"}
        for path in ("/readyz", "/v1/goals", "/"):
            answer = client.get(path)
            assert answer.status_code == 503
            assert answer.headers["content-type"] == "application/problem+json"
            assert answer.json()["type"] == "urn:macta:problem:starting"
            assert answer.headers["retry-after"] == "2"


def test_the_api_answers_once_it_is_made_and_the_server_ends(server: HttpServer) -> None:
    server.serve(PlainTextResponse("here"))
    assert httpx2.get(f"http://127.0.0.1:{server.port}/v1/goals").text == "here"
    server.stop()
    assert not server.is_alive
    with pytest.raises(httpx2.ConnectError):
        httpx2.get(f"http://127.0.0.1:{server.port}/healthz")
