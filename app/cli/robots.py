"""`macta robot`: the contract between the service and robots."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from app.cli import enrolment
from app.cli.options import reported_errors
from app.domain.errors import Invalid

commands = typer.Typer(no_args_is_help=True, help="Connect robots to the service (docs/robots.md).")
commands.command()(enrolment.enrol)
commands.command()(enrolment.revoke)
commands.command()(enrolment.enrolled)


@commands.command()
def contract(
    schemas: Annotated[
        Path | None, typer.Option(help="Folder to write a JSON Schema of each message to, besides.")
    ] = None,
) -> None:
    """Print the contract between the service and robots, as an AsyncAPI document."""
    from robots.link.mqtt.contract import asyncapi_text
    from robots.link.mqtt.contract import schemas as all_schemas

    with reported_errors():
        if schemas is not None:
            _write(schemas, {name: json.dumps(one, indent=2) for name, one in all_schemas().items()})
        typer.echo(asyncapi_text(), nl=False)


def _write(folder: Path, texts: Mapping[str, str]) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise Invalid(f"--schemas: {folder} cannot be written: {error.strerror}") from error
