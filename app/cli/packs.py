"""`macta pack`: make, check and list domain packs."""

import json as json_format
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options import PackNames, reported_errors

if TYPE_CHECKING:
    from app.packs.contents import PackContents

commands = typer.Typer(no_args_is_help=True, help="Make, check and list domain packs (docs/packs.md).")


@commands.command()
def new(
    name: Annotated[str, typer.Argument(help="Name of the pack.")],
    folder: Annotated[
        Path | None, typer.Option(help="Folder to make (default: the name, in the current folder).")
    ] = None,
) -> None:
    """Write a small domain pack that works: an action, its packet, and a world."""
    from app.packs.scaffold import write_example

    with reported_errors():
        target = folder or Path(name)
        for path in write_example(name, target):
            typer.echo(path)
        typer.echo(f'Try it: macta demo --pack {target} --world {name}_yard --goal "observe rock_1"')


@commands.command()
def check(
    name: Annotated[
        str, typer.Argument(help="Name of an installed pack, or a folder.", metavar="NAME|FOLDER")
    ],
    pack: PackNames = None,
) -> None:
    """Check a pack with those that it needs; an error names the file, the line, the slot and the choices."""
    from app.packs.check import faults_of
    from app.packs.contents import contents_of
    from app.packs.errors import PackError
    from app.packs.extensions import extension_faults
    from app.packs.find import find_pack, load_packs

    with reported_errors():
        packs = load_packs([*(pack or ()), name])
        checked = find_pack(name)
        if faults := [*faults_of(packs), *extension_faults(checked.place)]:
            raise PackError("\n".join(faults))
        typer.echo(f"{checked.name} {checked.version}: valid; {_summary(contents_of(checked))}")


@commands.command("list")
def list_packs(
    pack: PackNames = None,
    json: Annotated[bool, typer.Option("--json", help="Print only one JSON document.")] = False,
) -> None:
    """List the installed packs, those named, and the Python that installed packages add."""
    from app.packs.contents import contents_of
    from app.packs.extensions import installed_extensions
    from app.packs.find import find_pack, installed_names

    with reported_errors():
        names = dict.fromkeys((*installed_names(), *(pack or ())))
        contents = [contents_of(find_pack(name)) for name in names]
        extensions = list(installed_extensions())
    if json:
        document = {
            "packs": [one.model_dump(mode="json") for one in contents],
            "extensions": [one.model_dump(mode="json") for one in extensions],
        }
        typer.echo(json_format.dumps(document, indent=2))
        return
    for one in contents:
        typer.echo(f"{one.name} {one.version} ({one.source}): {_summary(one)}")
    for extension in extensions:
        typer.echo(f"{extension.group}: {extension.name} ({extension.source})")


def _summary(contents: "PackContents") -> str:
    named = {
        "actions": contents.actions,
        "packets": contents.packets,
        "verbs": contents.verbs,
        "worlds": contents.worlds,
    }
    words = (f"{what} {', '.join(names)}" for what, names in named.items() if names)
    return "; ".join(words) or "it brings nothing"
