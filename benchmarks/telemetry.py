"""Telemetry of many light robots into one service process on one core, over a real Mosquitto.

    uv run python -m benchmarks.telemetry [ROBOTS [HZ [SECONDS [foreign]]]]

Another process publishes in the robots' names, each at its own instant of the period, which the message holds.
The service's process is pinned to one core and has the link and the board as `macta serve` has them, and a reader that
looks at all views five times a second, as the operator's page does. The delay is from publishing to the board. With
`foreign` each robot has a connection of its own, with a last will, and its messages have fields that we do not know.
"""

import multiprocessing
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from robots.link.mqtt import Broker, ConnectionState, ServiceLink
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.session import Publication, Session
from robots.link.mqtt.topics import Channel, Presence, robot_topic
from robots.wire import Telemetry

WORLD = "plain"
CLIENTS = 20
"""Connections that publish for all robots of ours; their number affects the broker, not the service."""
UNKNOWN_FIELDS = b'"firmware":"2.4.1","wheels":{"left_a":0.4,"right_a":0.5},'
SETTLE_S = 2.0


if TYPE_CHECKING:
    from app.agents import RobotBoard


class TimedBoard:
    """A board that records each message's age on arrival. `at_s` is the publisher's monotonic clock, shared."""

    def __init__(self, board: "RobotBoard") -> None:
        self._board = board
        self.delays_s: list[float] = []

    def heard(self, robot: str, telemetry: Telemetry) -> None:
        self._board.heard(robot, telemetry)
        self.delays_s.append(time.monotonic() - telemetry.at_s)

    def connected(self, robot: str, state: ConnectionState, *, now: bool) -> None:
        self._board.connected(robot, state, now=now)


def main() -> None:
    robots, hz, seconds = _given(1, 1000), _given(2, 5), _given(3, 20)
    foreign = sys.argv[4:5] == ["foreign"]
    names = [f"robot_{number}" for number in range(robots)]
    with tempfile.TemporaryDirectory() as folder:
        port, broker = _mosquitto(Path(folder))
        try:
            os.sched_setaffinity(0, {0})
            _measure(names, hz, seconds, port, foreign=foreign)
        finally:
            broker.terminate()
            broker.wait()


def _measure(names: list[str], hz: int, seconds: int, port: int, *, foreign: bool) -> None:
    from app.agents import RobotBoard  # not for the publisher, which imports this module, too

    link = ServiceLink(WORLD, names, Broker.at(f"mqtt://127.0.0.1:{port}"))
    board = TimedBoard(RobotBoard(((name, WORLD) for name in names), clocks={WORLD: link.clock}))
    link.listen(board)
    link.start()
    done = threading.Event()
    threading.Thread(target=_read, args=(board._board, done), daemon=True).start()
    sent = multiprocessing.get_context("spawn").Value("l", 0)
    publisher = multiprocessing.get_context("spawn").Process(
        target=_publish, args=(names, hz, seconds, port, sent, foreign)
    )
    publisher.start()
    cpu_s, wall_s = time.process_time(), time.monotonic()
    while not board.delays_s:
        time.sleep(0.05)
        cpu_s, wall_s = time.process_time(), time.monotonic()
    publisher.join()
    took_s, count = time.monotonic() - wall_s, -1
    while count < (count := len(board.delays_s)):
        cpu_used_s = time.process_time() - cpu_s
        time.sleep(SETTLE_S)
    done.set()
    link.close()
    _tell(np.array(board.delays_s) * 1000, sent.value, cpu_used_s, took_s)


def _tell(delays_ms: "np.typing.NDArray[np.float64]", sent: int, cpu_s: float, wall_s: float) -> None:
    p50, p99, p999 = np.percentile(delays_ms, [50, 99, 99.9])
    print(f"{sent} sent in {wall_s:.1f} s, {sent / wall_s:.0f} a second; {len(delays_ms)} on the board")
    print(f"p50 {p50:.1f} ms, p99 {p99:.1f} ms, p99.9 {p999:.1f} ms, most {delays_ms.max():.1f} ms")
    each_us = cpu_s / max(len(delays_ms), 1) * 1e6
    print(
        f"{each_us:.0f} µs of CPU time a message, {each_us * sent / wall_s / 1e6:.0%} of a core at that pace"
    )
    print(f"load of the machine {os.getloadavg()[0]:.1f}: its processes share the core with the service")


def _read(board: "RobotBoard", done: threading.Event) -> None:
    while not done.wait(0.2):
        board.views(WORLD)


def _publish(names: list[str], hz: int, seconds: int, port: int, sent: Any, foreign: bool) -> None:
    """Publish for each robot in turn, evenly over the period."""
    os.sched_setaffinity(0, set(range(1, os.cpu_count() or 2)) or {0})
    broker = Broker.at(f"mqtt://127.0.0.1:{port}")
    sessions = [
        Session(broker, f"publisher-{number}", will=_will(names[number]) if foreign else None)
        for number in range(len(names) if foreign else CLIENTS)
    ]
    reactor = Reactor(sessions, broker=str(broker))
    reactor.start()
    while not all(session.connected for session in sessions):
        time.sleep(0.05)
    begun_s, gap_s = time.monotonic() + 0.5, 1 / (hz * len(names))
    for number in range(hz * seconds * len(names)):
        while (wait_s := begun_s + number * gap_s - time.monotonic()) > 0:
            time.sleep(max(wait_s, 0.001))
        name = names[number % len(names)]
        said = Telemetry(at_s=time.monotonic(), x_m=1.25, y_m=2.5, heading_rad=0.5, battery=0.9)
        payload = said.model_dump_json(exclude_defaults=True).encode()
        publication = Publication(
            topic=robot_topic(WORLD, name, Channel.VISUALIZATION),
            payload=payload[:1] + UNKNOWN_FIELDS + payload[1:] if foreign else payload,
            qos=0,
        )
        session = sessions[number % len(sessions)]
        while not session.publish(publication):
            time.sleep(0.0005)  # the last message is still queued; a robot would drop this one
        sent.value += 1
    reactor.close()


def _will(robot: str) -> Publication:
    payload = Presence(state=ConnectionState.CONNECTION_BROKEN).model_dump_json().encode()
    return Publication(topic=robot_topic(WORLD, robot, Channel.CONNECTION), payload=payload, retain=True)


def _mosquitto(folder: Path) -> tuple[int, "subprocess.Popen[bytes]"]:
    binary = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin")
    if binary is None:
        sys.exit("no mosquitto: apt-get install mosquitto")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    config = folder / "mosquitto.conf"
    config.write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\n")
    process = subprocess.Popen(
        [binary, "-c", str(config)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    time.sleep(1.0)
    return port, process


def _given(place: int, otherwise: int) -> int:
    return int(sys.argv[place]) if len(sys.argv) > place else otherwise


if __name__ == "__main__":
    main()
