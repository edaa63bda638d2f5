"""The contract with uvicorn's HTTP protocol: a request has a time for each part, and it is known which wait."""

import pytest
from websockets.sync.client import connect

from tests.app.api.bounded_server import LAST_CHUNK, LIMITS, REQUEST, STREAM, bounded, read_to, rest
from tests.waiting import until

HEADER_S, BODY_S = LIMITS.header_timeout_s, LIMITS.body_timeout_s
POST = b"POST / HTTP/1.1\r\nhost: x\r\ncontent-length: 10\r\n\r\n"


@pytest.mark.parametrize(
    ("sent", "limit_s"), [(REQUEST[:20], HEADER_S), (POST + b"half", BODY_S)], ids=["header", "body"]
)
def test_a_half_sent_request_ends_after_its_time(sent: bytes, limit_s: float) -> None:
    with bounded() as server, server.connect(sent) as client:
        server.answer()
        server.advance(limit_s)
        answer = rest(client)
    assert answer.startswith(b"HTTP/1.1 408 ")
    head, _, body = answer.partition(b"\r\n\r\n")
    assert f"content-length: {len(body)}\r\n".encode() in head + b"\r\n"


@pytest.mark.parametrize(
    ("halves", "limit_s"),
    [((REQUEST[:20], REQUEST[20:]), HEADER_S), ((POST, b"0123456789"), BODY_S)],
    ids=["header", "body"],
)
def test_a_request_that_is_whole_in_time_is_answered(halves: tuple[bytes, bytes], limit_s: float) -> None:
    with bounded() as server, server.connect(halves[0]) as client:
        server.answer()
        server.advance(limit_s - 1)
        server.answer()
        client.sendall(halves[1])
        assert read_to(client, LAST_CHUNK).startswith(b"HTTP/1.1 200 ")


def test_a_request_that_trickles_gets_no_more_time() -> None:
    with bounded() as server, server.connect() as client:
        for byte in REQUEST[:6]:
            client.sendall(bytes([byte]))
            server.answer()
            server.advance(HEADER_S / 5)
        assert rest(client).startswith(b"HTTP/1.1 408 ")


def test_a_connection_that_sends_nothing_is_closed_without_a_word() -> None:
    with bounded() as server, server.connect() as client:
        server.answer()
        server.advance(HEADER_S)
        assert rest(client) == b""


def test_a_connection_that_sends_nothing_more_is_closed_without_a_word() -> None:
    with bounded(header_timeout_s=2.0) as server, server.connect(REQUEST) as client:
        read_to(client, LAST_CHUNK)
        server.answer()
        server.advance(2.0)
        assert rest(client) == b""


def test_a_response_may_take_its_time() -> None:
    with bounded() as server, server.stream() as client:
        server.advance(100 * BODY_S)
        server.answer()
        server.end_streams()
        read_to(client, b"ended")


def test_a_stream_whose_request_is_never_whole_ends() -> None:
    with bounded() as server, server.connect(STREAM.replace(b"host", b"content-length: 5\r\nhost")) as client:
        read_to(client, b"begun")
        server.advance(BODY_S)
        assert b"ended" not in rest(client)


def test_a_second_request_of_a_connection_has_its_own_time() -> None:
    with bounded() as server, server.connect(POST + b"0123456789") as client:
        assert read_to(client, LAST_CHUNK).startswith(b"HTTP/1.1 200 ")
        client.sendall(POST)
        server.answer()
        server.advance(HEADER_S)
        server.answer()
        client.sendall(b"0123456789")
        assert read_to(client, LAST_CHUNK).startswith(b"HTTP/1.1 200 ")
        client.sendall(REQUEST[:20])
        server.answer()
        server.advance(HEADER_S)
        assert rest(client).startswith(b"HTTP/1.1 408 ")


UPGRADE = (
    b"HTTP/1.1\r\nhost: x\r\nupgrade: websocket\r\nconnection: upgrade\r\n"
    b"sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
)


@pytest.mark.parametrize(
    "request_",
    [
        b"GET / " + UPGRADE + b"".join(b"a%d: b\r\n" % n for n in range(300)),
        b"GET / " + UPGRADE + b"a: " + b"x" * 20_000 + b"\r\n",
        b"GET /" + b"x" * 20_000 + b" " + UPGRADE,
        b"POST / " + UPGRADE + b"content-length: 5\r\n",
    ],
    ids=["many headers", "a long one", "a long path", "not GET"],
)
def test_a_socket_whose_header_cannot_be_read_is_closed(request_: bytes) -> None:
    with bounded() as server, server.connect(request_ + b"\r\n") as client:
        assert rest(client) == b""
        until(lambda: server.connections.count == 0)


def test_a_socket_outlives_the_times_of_its_request() -> None:
    with bounded(total=1) as server, connect(f"ws://127.0.0.1:{server.port}/", proxy=None) as socket:
        server.advance(HEADER_S + BODY_S)
        assert b" 503 " in server.answer()  # it does not give way either
        socket.send("still here")
        assert socket.recv(20) == "still here"
