"""The commands of a production installation, where robots are reached over a broker."""

from pathlib import Path
from typing import Annotated

import typer

from app.cli.options import (
    Broker,
    PackNames,
    Speed,
    World,
    Worlds,
    leave,
    named_world,
    named_worlds,
    packs_of,
    reported_errors,
    world_file,
)


def fleet(
    world: World = None,
    pack: PackNames = None,
    broker: Broker = None,
    speed: Speed = 1.0,
    data: Annotated[Path | None, typer.Option(help="Folder of the world's snapshots.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulation's noise.")] = 0,
    afresh: Annotated[
        bool, typer.Option("--afresh", help="Start the world again, not from its snapshot.")
    ] = False,
) -> None:
    """Simulate a world and its robots for `macta serve --broker`."""
    from app.cli.fleet import fleet as run

    given = {"broker_url": broker, "data": data, "packs": pack}
    with reported_errors():
        options = {k: v for k, v in given.items() if v is not None}
        run(named_world(world, packs_of(pack)), speed or 1.0, seed, options, start_new=afresh)
    leave(0)


def worker(world: Worlds = None, pack: PackNames = None, broker: Broker = None) -> None:
    """Plan goals for the services on the same database (MACTA_DATABASE_URL)."""
    from app.cli.shared_modules import PLANNING
    from robots.child_processes import sharing

    with sharing(PLANNING):
        from planner.engines.garbage_collection import loading

        with loading():
            from app.cli.worker import worker as run

        given = {"broker_url": broker, "packs": pack}
        with reported_errors():
            run(named_worlds(world, packs_of(pack)), {k: v for k, v in given.items() if v is not None})
        leave(0)


alive = typer.Typer(
    no_args_is_help=True,
    help="Check a part of a production installation; exits with 2 if it does not respond.",
)


@alive.command("worker")
def worker_is_alive() -> None:
    """Check the planning worker on this host."""
    from app.cli.alive import worker_alive

    with reported_errors():
        typer.echo(worker_alive())


@alive.command("fleet")
def fleet_is_alive(world: World = None, pack: PackNames = None) -> None:
    """Check the world's fleet at the broker."""
    from app.cli.alive import fleet_alive
    from app.packs import MAIN_WORLD, STORE, chosen_packs

    with reported_errors():
        if list(chosen_packs(pack)) == [STORE]:  # packs take longer to load than all else here
            file = world_file(world or MAIN_WORLD, None)
        else:
            packs = packs_of(pack)
            file = world_file(world or packs.default_world, packs.worlds())
        typer.echo(fleet_alive(file))
    leave(0)
