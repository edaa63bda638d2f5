"""`macta serve`: the service with its simulated worlds and the 3D view."""

import errno
import gc
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

import uvicorn
from rich.console import Console
from rich.markup import escape

from app.cli.long_running import enter_all, log_warnings, report_new_run, world_over_broker
from app.cli.render import show_startup
from app.cli.settings import settings_of
from app.composition import RunningWorld, Service
from app.domain.errors import Invalid
from app.missions.world_start import recorded_run
from app.settings import Settings
from robots.world import WorldFile
from sim import SnapshotSettings, SupervisedWorld

GRACE_S = 3
"""How long open event streams may delay the shutdown."""


class Viewer:
    """The process of the 3D view, a client of the API; ends with the service."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._port = 0

    def address(self) -> str | None:
        running = self._process is not None and self._process.poll() is None
        return f"http://127.0.0.1:{self._port}" if running else None

    def start(self, *, api: str, token: str) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self._port = free.getsockname()[1]
        command = [
            sys.executable,
            "-P",  # a folder "web" in the working directory must not shadow the package
            "-m",
            "web.viewer",
            "--api",
            api,
            "--port",
            str(self._port),
            "--parent",
            str(os.getpid()),
        ]
        self._process = subprocess.Popen(
            command,
            env={**os.environ, "MACTA_TOKEN": token},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            start_new_session=True,
        )

    def stop(self) -> None:
        if self._process is None:
            return
        self._process.terminate()
        try:
            self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


class Server(uvicorn.Server):
    """Shuts down on SIGINT and SIGTERM: open streams end first, and the signal is not raised again."""

    def __init__(self, config: uvicorn.Config, stopping: threading.Event) -> None:
        super().__init__(config)
        self._stopping = stopping

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self._stopping.set()
        self.force_exit = self.should_exit and sig == signal.SIGINT
        self.should_exit = True


def serve(
    worlds: Sequence[WorldFile], speed: float, seed: int, given: Mapping[str, Any], *, afresh: bool = False
) -> None:
    """Run until SIGINT or SIGTERM.

    :param worlds: one or more.
    :param afresh: start the worlds again instead of from their snapshots.
    :raises Invalid: if a setting is wrong or the address is taken, before anything starts.
    """
    settings = settings_of(given)
    broker = settings.broker()
    log_warnings()
    with listen(settings) as listener:
        show_startup(Console(stderr=True))
        viewer = Viewer()
        with (
            enter_all(
                _embedded(world, settings, speed, seed, afresh)
                if broker is None
                else world_over_broker(broker, world)
                for world in worlds
            ) as running,
            Service(settings, running, viewer=viewer.address) as service,
        ):
            config = uvicorn.Config(
                service.api,
                log_level="warning",
                access_log=False,
                timeout_graceful_shutdown=GRACE_S,
                ws_max_size=64 * 2**20,
            )
            server = Server(config, service.stopping)
            announce = threading.Thread(
                target=_announce, args=(server, listener, service, viewer, worlds), daemon=True
            )
            announce.start()
            gc.freeze()  # keeps the collector from scanning the service's objects, 0.1 s each time
            try:
                server.run(sockets=[listener])
            finally:
                viewer.stop()


@contextmanager
def _embedded(
    world: WorldFile, settings: Settings, speed: float, seed: int, afresh: bool
) -> Iterator[RunningWorld]:
    """The world, simulated by a child process from its snapshot in the data folder."""
    snapshots = SnapshotSettings(
        folder=settings.data / "worlds", run=recorded_run(settings, world.name), start_new=afresh
    )
    with SupervisedWorld.start(world, snapshots, seed=seed, speed=speed, jitter_m=0.0) as simulation:
        running = RunningWorld(
            file=world,
            link=simulation,
            clock=simulation,
            rate=speed,
            run=simulation.run,
            why_afresh=simulation.not_resumed_because,
            let_go=lambda: simulation.pause(False),
        )
        _report_world(running)
        simulation.pause()
        yield running


def _report_world(world: RunningWorld) -> None:
    """Say on standard error whether the world goes on from its snapshot."""
    if world.why_afresh:
        report_new_run(world.file.name, world.why_afresh)
    elif world.clock.now_s() > 0:
        Console(stderr=True).print(f"[dim]World {world.file.name} goes on at {world.clock.now_s():.0f} s.[/]")


def listen(settings: Settings) -> socket.socket:
    """A socket bound to the settings' host and port.

    :raises Invalid: if it cannot be bound there.
    """
    host = settings.host
    port = settings.port
    listener = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    # asyncio sets it only on sockets that it makes; without it a response body waits 40 ms for an acknowledgement.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    try:
        listener.bind((host, port))
    except (OSError, UnicodeError) as error:
        listener.close()
        if isinstance(error, OSError) and error.errno in (errno.EADDRINUSE, errno.EACCES):
            raise Invalid(
                f"cannot listen on {host}:{port}: {error.strerror}; choose another --port"
            ) from error
        why = error.strerror if isinstance(error, OSError) else "no host name"
        raise Invalid(f"cannot listen on host {host!r}: {why}; choose an address of this machine") from error
    return listener


def _announce(
    server: uvicorn.Server,
    listener: socket.socket,
    service: Service,
    viewer: Viewer,
    worlds: Sequence[WorldFile],
) -> None:
    """Once the server answers: start the 3D view and print the addresses."""
    waiting = threading.Event()
    while not server.started:
        if server.should_exit or waiting.wait(0.02):
            return
    port = listener.getsockname()[1]
    host = service.settings.host
    shown = f"[{host}]" if ":" in host else host
    reachable = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(host, shown)
    viewer.start(api=f"http://{reachable}:{port}", token=service.token)
    # NOTE: plain print: rich would break the address at the terminal's width.
    print(f"Macta is ready: http://{shown}:{port}/?token={service.token}", flush=True)
    names = ", ".join(world.name for world in worlds)
    Console(stderr=True).print(
        f"[dim]World {names}; the record is in {escape(service.settings.database_location)}. Ctrl-C ends.[/]"
    )
