"""The commands of production, where robots are reached over a broker."""

from pathlib import Path
from typing import Annotated

import typer

from app.cli.options import Broker, Speed, World, carefully, leave, named_world


def fleet(
    world: World = "sample_store",
    broker: Broker = None,
    speed: Speed = 1.0,
    data: Annotated[Path | None, typer.Option(help="Folder that the world is kept in.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulation's noise.")] = 0,
) -> None:
    """Simulate a world and its robots, to be reached over a broker by `macta serve --broker`."""
    from app.cli.fleet import fleet as run

    given = {"broker_url": broker, "data": data}
    with carefully():
        run(named_world(world), speed or 1.0, seed, {k: v for k, v in given.items() if v is not None})
    leave(0)
