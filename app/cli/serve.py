"""`macta serve`: the service with its simulated worlds, and the 3D view on demand."""

import errno
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape

from app.api.connections import BoundedListener, ConnectionLimits, Connections, throttle_warnings
from app.background_compilation import BackgroundCompilation
from app.cli.background import background_compilation, groups_for
from app.cli.http_server import HttpServer
from app.cli.long_running import (
    FleetHost,
    end_signal,
    log_warnings,
    report_new_run,
    warn_of_broker,
    world_over_broker,
)
from app.cli.settings import settings_of
from app.cli.simulation_host import SimulationHost
from app.cli.start_progress import StartProgress
from app.cli.view_process import ViewProcess
from app.domain.errors import Invalid, Unavailable
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.work import make_engine
from app.settings import Settings
from robots.world import WorldFile
from sim import SupervisedWorld

if TYPE_CHECKING:
    from app.agents.running_world import RunningWorld
    from app.composition import Service

READY_POLL_S = 0.05
ALIVE_POLL_S = 1.0


def serve(
    worlds: Sequence[WorldFile],
    speed: float | None,
    seed: int | None,
    given: Mapping[str, Any],
    *,
    start_new: bool = False,
) -> None:
    """Run the service until SIGINT or SIGTERM. The API is served while the planner still warms up.

    :param worlds: one or more.
    :param speed: of the simulated worlds, world seconds per wall-clock second; None: 1.
    :param seed: of the simulations' noise; None: 0.
    :param start_new: start the worlds again instead of from their snapshots.
    :raises Invalid: if a setting is wrong or the address is taken, before anything starts.
    :raises Unavailable: if no planning process starts.
    """
    settings = settings_of(given)
    from app.packs.find import load_packs  # here: `macta serve` counts what it loads before it listens

    packs = load_packs(settings.packs)
    broker = settings.broker()
    if broker is not None and (speed, seed) != (None, None):
        raise Invalid(
            "--speed and --seed are of worlds that are simulated here, and with a broker none is: "
            "give them to `macta fleet`"
        )
    log_warnings()
    warn_of_broker(broker)
    throttle_warnings()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # interrupts the start, as SIGINT does
    with (
        listen(settings) as listener,
        HttpServer(listener) as server,
        background_compilation(groups_for([] if broker else worlds)) as compilation,
        StartProgress(Console(stderr=True)) as progress,
        ExitStack() as parts,
    ):
        worker = PlanningWorker(
            partial(make_engine, knowledge_bases=packs.knowledge_bases),
            processes=settings.planning_processes,
            memory_mb=settings.planning_memory_mb,
            tell=progress.tell,
            compilation=compilation,
        )
        parts.callback(worker.close)
        worker.warm_up()
        threads = ThreadPoolExecutor(len(worlds))
        parts.callback(threads.shutdown, wait=False, cancel_futures=True)
        simulations = SimulationHost(
            settings=settings, packs=packs, speed=speed or 1.0, seed=seed or 0, start_new=start_new
        )
        start = partial(_simulation, simulations, tell=progress.tell)
        starts = [threads.submit(start, world) for world in worlds if broker is None]
        from planner.engines.garbage_collection import loading

        with loading():
            # NOTE: this import takes seconds; meanwhile the server answers and the other processes start.
            from app.composition import Service

            if broker is None:
                running = [
                    parts.enter_context(_embedded(world, simulation.result(), simulations.speed))
                    for world, simulation in zip(worlds, starts, strict=True)
                ]
            else:
                running = [
                    parts.enter_context(world_over_broker(broker, world, start_new=start_new))
                    for world in worlds
                ]
            view = ViewProcess()
            service = parts.enter_context(
                Service(
                    settings,
                    running,
                    viewer=view.address,
                    worker=worker,
                    host=simulations if broker is None else FleetHost(broker),
                    compilation=compilation,
                )
            )
            server.serve(service.api)
        try:
            with end_signal() as ending:
                _attend(ending, server, service, view, progress, compilation)
        finally:
            service.stopping.set()
            view.stop()
            server.stop()


def _simulation(
    simulations: SimulationHost, world: WorldFile, *, tell: Callable[[str], None]
) -> SupervisedWorld:
    """The world's simulation, paused; prints whether it is resumed."""
    simulation = simulations.start(world, tell=tell)
    _report_world(world, simulation)
    return simulation


def _attend(
    ending: threading.Event,
    server: HttpServer,
    service: "Service",
    view: ViewProcess,
    progress: StartProgress,
    compilation: BackgroundCompilation,
) -> None:
    """Once the planner has started, print the address, allow the 3D view and compile; wait for the end.

    :raises Unavailable: if no planning process starts, or the HTTP server has ended by itself.
    """
    while not service.planner_ready.done():
        if ending.wait(READY_POLL_S):
            return
    service.planner_ready.result()
    progress.end()
    host = service.settings.host
    shown = f"[{host}]" if ":" in host else host
    reachable = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(host, shown)
    view.allow(api=f"http://{reachable}:{server.port}", token=service.token)
    # NOTE: plain print: rich would break the address at the terminal's width.
    # A token from the environment is not printed: its owner has it, and the output may be logged.
    shown_token = f"?token={service.token}" if service.settings.token is None else ""
    print(f"Macta is ready: http://{shown}:{server.port}/{shown_token}", flush=True)
    Console(stderr=True).print(
        f"[dim]World {', '.join(service.clocks)}; the record is in {escape(service.settings.database_location)}. "
        "Ctrl-C ends.[/]"
    )
    compilation.start()
    while not ending.wait(ALIVE_POLL_S):
        view.reap()
        if not server.is_alive:
            raise Unavailable("the HTTP server has ended; the log says why")


@contextmanager
def _embedded(world: WorldFile, simulation: SupervisedWorld, speed: float) -> Iterator["RunningWorld"]:
    """A world simulated by the service, which resumes it once it receives messages."""
    from app.agents.running_world import RunningWorld

    with simulation:
        yield RunningWorld(
            file=world,
            link=simulation,
            clock=simulation,
            rate=speed,
            run=simulation.run,
            new_run_reason=simulation.not_resumed_because,
            resume=lambda: simulation.pause(False),
        )


def _report_world(world: WorldFile, simulation: SupervisedWorld) -> None:
    """Print to standard error whether the world resumes from its snapshot."""
    if simulation.not_resumed_because:
        report_new_run(world.name, simulation.not_resumed_because)
    elif simulation.is_resumed:
        Console(stderr=True).print(f"[dim]World {world.name} resumes at {simulation.now_s():.0f} s.[/]")


def listen(settings: Settings) -> BoundedListener:
    """A socket bound to the settings' host and port.

    :raises Invalid: if it cannot be bound there, or the process may open too few files.
    """
    host = settings.host
    port = settings.port
    connections = Connections(ConnectionLimits.of(settings))
    listener = BoundedListener(socket.AF_INET6 if ":" in host else socket.AF_INET, connections)
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
