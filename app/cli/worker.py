"""`macta worker`: plans for the service's processes on the same database. Ends in order when told to."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from app.cli.long_running import end_signal, enter_all, log_warnings, world_over_broker
from app.cli.render import show_startup
from app.cli.settings import settings_of
from app.composition import Service
from app.domain.errors import Invalid
from app.settings import Settings
from app.workflows import PLANNING, WAITING
from robots.world import WorldFile


def worker(worlds: Sequence[WorldFile], given: Mapping[str, Any]) -> None:
    """Run until interrupted or terminated.

    :raises Invalid: if there is nobody to plan for, or no way to hear of the world's robots.
    """
    settings = settings_of(given, keeps_folder=False)
    broker = settings.broker()
    _refuse_alone(settings)
    if broker is None:
        raise Invalid("--broker: say where the broker is that robots are heard over, as mqtt://HOST[:PORT]")
    log_warnings()
    show_startup(Console(stderr=True))
    serves = (PLANNING, WAITING)
    with (
        end_signal() as ending,
        enter_all(world_over_broker(broker, world) for world in worlds) as running,
        Service(settings, running, serves=serves),
    ):
        names = ", ".join(world.name for world in worlds)
        # NOTE: plain print: a terminal's width must not break the line.
        print(
            f"The planning worker of {names} is ready: {settings.planning_processes} goals side by side",
            flush=True,
        )
        ending.wait()


def _refuse_alone(settings: Settings) -> None:
    if not settings.database_is_shared:
        raise Invalid(
            "MACTA_DATABASE_URL: a worker plans for others, on a PostgreSQL that it shares with them; "
            "alone, `macta serve` plans by itself"
        )
    if settings.planning_processes == 0:
        raise Invalid("MACTA_PLANNING_PROCESSES: a worker with none would plan nothing")
