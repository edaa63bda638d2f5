"""`macta world`: check and generate world files, print their schema."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from app.cli.options import PackNames, named_world, packs_of, reported_errors
from app.domain.errors import Invalid

commands = typer.Typer(no_args_is_help=True, help="Check and generate world files, print their schema.")


@commands.command()
def validate(
    file: Annotated[str, typer.Argument(help="Name of a world that ships with Macta, or a world file.")],
    pack: PackNames = None,
) -> None:
    """Check a world file; an error names the field and the choices."""
    with reported_errors():
        world = named_world(file, packs_of(pack))
    berths = [len(row) for row in world.places_by_location.values() if len(row) > 1]
    in_berths = f" ({len(berths)} of them with {sum(berths)} berths)" if berths else ""
    locations = f"{len(world.locations)} locations{in_berths}"
    typer.echo(f"{world.name}: valid; {len(world.robots)} robots, {locations}, {len(world.samples)} samples")


Count = Annotated[int | None, typer.Option(min=0, help="Count (default: derived from the other options).")]


@commands.command()
def generate(
    aisles: Count = None,
    store_robots: Count = None,
    yard_robots: Count = None,
    interchanges: Count = None,
    doors: Count = None,
    bays: Count = None,
    samples: Annotated[int, typer.Option(min=0, help="Count; aisles and robots follow from it.")] = 4,
    compartments: Annotated[int, typer.Option(min=2, help="Count: the yard and the stores behind it.")] = 2,
    bay_capacity: Annotated[int, typer.Option(min=1, max=100, help="Samples that fit in each bay.")] = 1,
    in_phases: Annotated[
        bool, typer.Option("--in-phases", help="Robots hold a place only while they use it.")
    ] = False,
    shared_chargers: Annotated[
        bool, typer.Option("--shared-chargers", help="Robots share a charger in place of homes.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the samples' places.")] = 0,
    out: Annotated[Path | None, typer.Option(help="File to write (default: standard output).")] = None,
) -> None:
    """Write a world file of a sample store of any size; the same options and seed give the same file."""
    from robots.world import StoreShapeError, generate_world, store_shape, world_yaml

    given = {
        "aisles": aisles,
        "store_robots": store_robots,
        "yard_robots": yard_robots,
        "interchanges": interchanges,
        "doors": doors,
        "bays": bays,
        "bay_capacity": bay_capacity,
    }
    with reported_errors():
        try:
            shape = store_shape(samples=samples, compartments=compartments, **given)
            text = world_yaml(
                generate_world(shape, seed=seed, in_phases=in_phases, shared_chargers=shared_chargers)
            )
        except StoreShapeError as error:
            raise Invalid(f"a store with these options cannot be generated: {error}") from error
        _write(text, out)


def _write(text: str, out: Path | None) -> None:
    if out is None:
        sys.stdout.write(text)
        return
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise Invalid(f"--out: {out} cannot be written: {error.strerror}") from error


@commands.command("import")
def import_world(
    kind: Annotated[
        str, typer.Argument(help="Format: ros_map, or one of an installed package.", metavar="FORMAT")
    ],
    file: Annotated[Path, typer.Argument(help="File to read.")],
    out: Annotated[Path | None, typer.Option(help="File to write (default: standard output).")] = None,
) -> None:
    """Write a world file from a map of ROS (docs/worlds.md), or a format that an installed package reads."""
    from app.packs.importing import imported_world
    from robots.world import world_yaml

    with reported_errors():
        _write(world_yaml(imported_world(kind, file)), out)


@commands.command()
def schema() -> None:
    """Print the JSON Schema of world files."""
    from robots.world import WorldFile

    typer.echo(json.dumps(WorldFile.model_json_schema(), indent=2))
