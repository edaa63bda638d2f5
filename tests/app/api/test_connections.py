"""Connections are bounded before any token is shown, and a client that only holds them gives way."""

import logging
import os
import resource
import socket
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import replace

import pytest

from app.api.connections import (
    FEWEST,
    GRACE_S,
    RESERVED_DESCRIPTORS,
    AcceptedSocket,
    BoundedListener,
    ConnectionLimits,
    Connections,
    Throttle,
)
from app.domain.errors import Invalid
from app.settings import Settings
from tests.app.api.bounded_server import LAST_CHUNK, LIMITS, REQUEST, bounded, read_to, rest
from tests.app.stepped_clock import SteppedClock
from tests.waiting import until

ELSEWHERE = "127.0.0.2"


def test_the_connection_that_has_waited_longest_gives_way_to_a_new_one() -> None:
    with bounded(total=3) as server, ExitStack() as clients:
        waiting = [clients.enter_context(server.connect()) for _ in range(3)]
        until(lambda: server.connections.waits == 3)
        server.advance(GRACE_S)
        assert server.answer().startswith(b"HTTP/1.1 200 ")
        assert rest(waiting[0]) == b""
        waiting[2].sendall(REQUEST)
        assert read_to(waiting[2], LAST_CHUNK).startswith(b"HTTP/1.1 200 ")
        assert server.connections.count <= 3


def test_a_new_connection_has_the_time_to_send_its_request() -> None:
    with bounded(total=1) as server, server.connect() as client:
        until(lambda: server.connections.waits == 1)
        server.advance(GRACE_S * 0.9)
        assert server.answer().startswith(b"HTTP/1.1 503 ")
        client.sendall(REQUEST)
        assert read_to(client, LAST_CHUNK).startswith(b"HTTP/1.1 200 ")


def test_requests_under_way_do_not_give_way_and_one_more_is_told_to_come_later() -> None:
    with bounded(total=2) as server, server.stream() as first:
        with server.stream():
            refused = server.answer()
            assert refused.startswith(b"HTTP/1.1 503 ")
            head, _, body = refused.partition(b"\r\n\r\n")
            assert b"retry-after: " in head
            assert f"content-length: {len(body)}\r\n".encode() in head + b"\r\n"
        until(lambda: server.connections.count == 1)
        assert server.answer().startswith(b"HTTP/1.1 200 ")
        server.end_streams()
        read_to(first, b"ended")


def test_one_address_leaves_places_for_others() -> None:
    with bounded(per_address=2) as server, server.stream(ELSEWHERE), server.stream(ELSEWHERE):
        assert server.answer(ELSEWHERE).startswith(b"HTTP/1.1 503 ")
        assert server.answer().startswith(b"HTTP/1.1 200 ")


def test_an_address_takes_the_place_of_its_own_waiting_connections() -> None:
    with bounded(per_address=1) as server, server.connect() as other, server.connect(source=ELSEWHERE) as own:
        until(lambda: server.connections.waits == 2)
        server.advance(GRACE_S)
        assert server.answer(ELSEWHERE).startswith(b"HTTP/1.1 200 ")
        assert rest(own) == b""
        other.sendall(REQUEST)
        assert read_to(other, LAST_CHUNK).startswith(b"HTTP/1.1 200 ")


def test_the_address_with_the_most_waiting_connections_gives_way_first() -> None:
    with bounded(total=3) as server, ExitStack() as clients:
        own = clients.enter_context(server.connect())
        flood = [clients.enter_context(server.connect(source=ELSEWHERE)) for _ in range(2)]
        until(lambda: server.connections.waits == 3)
        server.advance(GRACE_S)
        assert server.answer().startswith(b"HTTP/1.1 200 ")
        assert rest(flood[0]) == b""
        own.sendall(REQUEST)
        assert read_to(own, LAST_CHUNK).startswith(b"HTTP/1.1 200 ")


@pytest.fixture
def no_descriptor() -> Iterator[None]:
    """Every descriptor of this process is taken, but for those that it gives back."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    taken = [os.open(os.devnull, os.O_RDONLY)]
    resource.setrlimit(resource.RLIMIT_NOFILE, (taken[0] + 20, hard))
    with suppress(OSError):
        while True:
            taken.append(os.open(os.devnull, os.O_RDONLY))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    for one in taken:
        os.close(one)


@pytest.fixture
def clients() -> Iterator[list[socket.socket]]:
    """Sockets that were made while there were descriptors."""
    made = [socket.socket() for _ in range(3)]
    yield made
    for client in made:
        client.close()


@pytest.fixture
def listener() -> Iterator[BoundedListener]:
    with BoundedListener(socket.AF_INET, Connections(LIMITS)) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        listener.setblocking(False)
        yield listener


def test_a_connection_that_gives_way_frees_its_descriptor_at_once(clients: list[socket.socket]) -> None:
    clock = SteppedClock()
    connections = Connections(replace(LIMITS, total=1), clock)
    with BoundedListener(socket.AF_INET, connections) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        for client in clients[:2]:
            client.connect(listener.getsockname())
        first, peer = listener.accept()
        connections.wait(peer, lambda: None)
        clock.advance(GRACE_S)
        second, _ = listener.accept()
        assert (first.fileno(), connections.count) == (-1, 1)
        second.close()
        assert connections.count == 0


def test_closing_a_connection_again_does_not_free_the_place_of_the_next_from_the_same_port(
    clients: list[socket.socket], listener: BoundedListener
) -> None:
    clients[0].connect(listener.getsockname())
    first, peer = listener.accept()
    first.close()
    with AcceptedSocket(socket.socket(), lambda: None) as second:
        assert listener.connections.admit(second, peer)
        first.close()  # as the event loop does, later
        assert listener.connections.count == 1


def test_without_a_descriptor_connections_are_taken_off_the_backlog_and_refused(
    clients: list[socket.socket], listener: BoundedListener, no_descriptor: None
) -> None:
    # One after the other: the spare descriptor serves again and again.
    for client in clients:
        client.connect(listener.getsockname())
        with pytest.raises(BlockingIOError):
            listener.accept()
        assert client.recv(1000).startswith(b"HTTP/1.1 503 ")
    assert listener.connections.count == 0


def test_a_peer_that_reads_nothing_is_dropped_by_the_kernel(
    clients: list[socket.socket], listener: BoundedListener
) -> None:
    clients[0].connect(listener.getsockname())
    accepted, _ = listener.accept()
    with accepted:
        assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) > 0


def limited(monkeypatch: pytest.MonkeyPatch, soft: int, hard: int) -> list[tuple[int, int]]:
    """Let the process have these limits of open files; notes the limits that it sets."""
    changes: list[tuple[int, int]] = []
    monkeypatch.setattr(resource, "getrlimit", lambda _: (soft, hard))
    monkeypatch.setattr(resource, "setrlimit", lambda _, limits: changes.append(limits))
    return changes


def test_the_limit_of_open_files_is_raised_to_what_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = Settings(connections=1000, open_streams=300)
    needed = 1000 + 300 + RESERVED_DESCRIPTORS
    changes = limited(monkeypatch, 300, 5000)
    assert ConnectionLimits.of(settings).total == 1000
    assert changes == [(needed, 5000)]
    assert limited(monkeypatch, needed, needed) == []
    assert ConnectionLimits.of(settings).total == 1000


def test_where_few_files_may_be_open_the_database_keeps_its_share(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    limited(monkeypatch, 300, 300)
    # Each connection may have a second one, to the 3D view.
    assert 2 * ConnectionLimits.of(Settings()).total + RESERVED_DESCRIPTORS <= 300
    assert "MACTA_CONNECTIONS" in caplog.text


def test_where_too_few_files_may_be_open_the_error_says_how_many_are_needed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    least = RESERVED_DESCRIPTORS + 2 * FEWEST
    limited(monkeypatch, least - 1, least - 1)
    with pytest.raises(Invalid, match=f"ulimit -n {least}"):
        ConnectionLimits.of(Settings())
    limited(monkeypatch, least, least)
    assert ConnectionLimits.of(Settings()).total == FEWEST


def warnings_passed(throttle: Throttle, *messages: str) -> list[str]:
    records = [
        logging.LogRecord("some.logger", logging.WARNING, "", 0, message, (n,), None)
        for n, message in enumerate(messages)
    ]
    return [record.getMessage() for record in records if throttle.filter(record)]


def test_a_warning_is_logged_once_a_minute_with_the_count_of_the_others() -> None:
    clock = SteppedClock()
    throttle = Throttle(clock)
    assert warnings_passed(throttle, "full, %d", "full, %d", "full, %d") == ["full, 0"]
    assert warnings_passed(throttle, "other, %d") == ["other, 0"]
    clock.advance(59.9)
    assert warnings_passed(throttle, "full, %d") == []
    clock.advance(0.1)
    assert warnings_passed(throttle, "full, %d") == ["full, 0; 3 more like it since the last line"]
    clock.advance(60)
    assert warnings_passed(throttle, "full, %d") == ["full, 0"]


def test_errors_are_never_kept_back() -> None:
    throttle = Throttle(SteppedClock())
    error = logging.LogRecord("some.logger", logging.ERROR, "", 0, "a defect", (), None)
    assert [throttle.filter(error) for _ in range(3)] == [True] * 3
