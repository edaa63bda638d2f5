"""`macta worker`: plans goals for the services on the same database."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from app.cli.background import background_compilation, groups_for
from app.cli.long_running import (
    FleetHost,
    end_signal,
    enter_all,
    log_warnings,
    warn_of_broker,
    world_over_broker,
)
from app.cli.settings import settings_of
from app.cli.start_progress import StartProgress
from app.composition import Service
from app.domain.errors import Invalid
from app.settings import Settings
from app.workflows import LARGE_PLANNING, PLANNING, WAITING
from robots.world import WorldFile


def worker(worlds: Sequence[WorldFile], given: Mapping[str, Any]) -> None:
    """Run until SIGINT or SIGTERM.

    :raises Invalid: if the database is not shared, or no broker is set.
    """
    settings = settings_of(given, keeps_folder=False)
    broker = settings.broker()
    _refuse_unshared(settings)
    if broker is None:
        raise Invalid("--broker: set the address of the robots' broker, mqtt://HOST[:PORT]")
    log_warnings()
    warn_of_broker(broker)
    serves = (PLANNING, LARGE_PLANNING, WAITING)
    with (
        end_signal() as ending,
        enter_all(world_over_broker(broker, world) for world in worlds) as running,
        background_compilation(groups_for(())) as compilation,
        StartProgress(Console(stderr=True)) as progress,
        Service(
            settings,
            running,
            serves=serves,
            host=FleetHost(broker),
            tell=progress.tell,
            compilation=compilation,
        ) as service,
    ):
        service.planner_ready.result()
        progress.end()
        names = ", ".join(world.name for world in worlds)
        # NOTE: plain print: rich would break the line at the terminal's width.
        print(
            f"The planning worker of {names} is ready: {settings.planning_processes} goals in parallel",
            flush=True,
        )
        compilation.start()
        ending.wait()


def _refuse_unshared(settings: Settings) -> None:
    if not settings.database_is_shared:
        raise Invalid(
            "MACTA_DATABASE_URL: a worker needs a PostgreSQL database that it shares with services; "
            "without one, `macta serve` plans by itself"
        )
    if settings.planning_processes == 0:
        raise Invalid("MACTA_PLANNING_PROCESSES: a worker needs at least one")
