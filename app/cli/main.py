"""The commands and their options. Each command's work lies in a module of its own, imported when it is called."""

import gc
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from app.errors import MactaError
from app.world_model import initial_facts
from planner import KnowledgeBaseError, load_knowledge_base
from robots.world import WorldFile, WorldFileError, load_world
from sim import SimulationError

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Plans goals for teams of robots, has them approved, and sees them carried out.",
)
worlds = typer.Typer(no_args_is_help=True, help="World files: check them, print their schema.")
app.add_typer(worlds, name="world")

World = Annotated[
    str, typer.Option(help="A world that ships with Macta, or a world file.", metavar="NAME|FILE")
]
Speed = Annotated[
    float | None, typer.Option(min=0.01, help="World seconds a second; left out: see the command.")
]


def fail(message: str) -> NoReturn:
    """Say what is wrong on standard error and end with 2."""
    Console(stderr=True, highlight=False, soft_wrap=True).print(f"[bold red]macta:[/] {escape(message)}")
    raise typer.Exit(2)


def leave(code: int) -> NoReturn:
    """End the process now that everything is closed.

    A workflow that sleeps holds a thread until its time is up. What it waits for is in the record, so the process
    need not wait with it.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


@contextmanager
def carefully() -> Iterator[None]:
    """What can be expected to go wrong is a line on standard error; an interruption ends at once."""
    try:
        yield
    except (KeyboardInterrupt, typer.Abort) as interruption:
        # NOTE: what the interrupted calls still hold, semaphores among it, is let go; else they count as leaked.
        traceback.clear_frames(interruption.__traceback__)
        gc.collect()
        Console(stderr=True).print("macta: interrupted")
        leave(130)
    except MactaError as error:
        fail(f"{error.detail}; choices: {', '.join(error.choices)}" if error.choices else error.detail)
    except SimulationError as error:
        fail(str(error))


def main() -> None:
    """The entry point."""
    app()


@app.command()
def serve(
    world: World = "sample_store",
    speed: Speed = 1.0,
    host: Annotated[str | None, typer.Option(help="Address to listen on; loopback unless told.")] = None,
    port: Annotated[int | None, typer.Option(min=0, max=65535, help="0: any free one. Default 8000.")] = None,
    data: Annotated[Path | None, typer.Option(help="Folder of the record. Default ./macta-data.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulation's noise.")] = 0,
) -> None:
    """Serve the HTTP API, the operator's page and the simulated world."""
    from app.cli.serve import serve as run

    given = {"host": host, "port": port, "data": data}
    with carefully():
        run(_world(world), speed or 1.0, seed, {k: v for k, v in given.items() if v is not None})
    leave(0)


@app.command()
def demo(
    world: World = "sample_store",
    goal: Annotated[str, typer.Option(help="What to achieve.")] = "move sample_1 to bay_7",
    speed: Annotated[float | None, typer.Option(min=0.01, help="World seconds a second.")] = 4.0,
    flat_out: Annotated[
        bool, typer.Option(help="As fast as the machine can, whatever --speed says.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of start poses and noise.")] = 0,
) -> None:
    """Run the main job in the terminal: a goal becomes a plan, is approved, and the rovers carry it out."""
    from app.cli.demo import demo as run

    with carefully():
        leave(run(_world(world), goal, None if flat_out else speed, seed))


@app.command()
def plan(
    goal: Annotated[list[str], typer.Option(help="What to achieve; may be given several times.")],
    world: World = "sample_store",
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds the planner may take.")] = 30.0,
    json: Annotated[
        bool, typer.Option("--json", help="Print the plan body as JSON, and nothing else.")
    ] = False,
) -> None:
    """Plan only, no server: print the plan-net for a goal."""
    from app.cli.plan import plan as run

    with carefully():
        raise typer.Exit(run(_world(world), goal, time_limit, as_json=json))


@worlds.command()
def validate(
    file: Annotated[str, typer.Argument(help="A world that ships with Macta, or a world file.")],
) -> None:
    """Check a world file; the error names the slot and the choices."""
    with carefully():
        world = _world(file)
    robots, places, samples = len(world.robots), len(world.locations), len(world.samples)
    typer.echo(f"{world.name}: valid; {robots} robots, {places} locations, {samples} samples")


@worlds.command()
def schema() -> None:
    """Print the JSON Schema of world files."""
    import json

    typer.echo(json.dumps(WorldFile.model_json_schema(), indent=2))


def _world(name: str) -> WorldFile:
    """The world, its file valid and its extra facts of the vocabulary; ends the command otherwise."""
    try:
        world = load_world(name)
        initial_facts(world, load_knowledge_base())
    except WorldFileError as error:
        fail(str(error))
    except KnowledgeBaseError as error:
        fail(f"{name} is not a valid world: facts: {error}")
    return world
