"""The commands of production, where robots are reached over a broker."""

from pathlib import Path
from typing import Annotated

import typer

from app.cli.options import Broker, Speed, World, Worlds, carefully, leave, named_world, named_worlds


def fleet(
    world: World = "sample_store",
    broker: Broker = None,
    speed: Speed = 1.0,
    data: Annotated[Path | None, typer.Option(help="Folder that the world is kept in.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulation's noise.")] = 0,
    afresh: Annotated[bool, typer.Option("--afresh", help="Build the world anew; else it goes on.")] = False,
) -> None:
    """Simulate a world and its robots, to be reached over a broker by `macta serve --broker`."""
    from app.cli.fleet import fleet as run

    given = {"broker_url": broker, "data": data}
    with carefully():
        options = {k: v for k, v in given.items() if v is not None}
        run(named_world(world), speed or 1.0, seed, options, afresh=afresh)
    leave(0)


def worker(world: Worlds = None, broker: Broker = None) -> None:
    """Plan the goals of the service's processes on the same database (MACTA_DATABASE_URL)."""
    from app.cli.worker import worker as run

    given = {} if broker is None else {"broker_url": broker}
    with carefully():
        run(named_worlds(world), given)
    leave(0)


alive = typer.Typer(
    no_args_is_help=True, help="Whether a part of the production shape is well; ends with 2 if not."
)


@alive.command("worker")
def worker_is_alive() -> None:
    """Whether the planning worker on this host says that it lives."""
    from app.cli.alive import worker_alive

    with carefully():
        typer.echo(worker_alive())


@alive.command("fleet")
def fleet_is_alive(world: World = "sample_store") -> None:
    """Whether the world's fleet is heard of at the broker."""
    from app.cli.alive import fleet_alive

    with carefully():
        typer.echo(fleet_alive(named_world(world)))
    leave(0)
