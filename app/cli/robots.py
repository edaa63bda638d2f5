"""`macta robot`: the contract between the service and robots."""

import json
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
        Path | None, typer.Option(help="Folder to write a JSON Schema of each message to.")
    ] = None,
) -> None:
    """Print the contract between the service and robots as JSON Schemas."""
    from robots.link.mqtt.contract import schemas as made

    with reported_errors():
        texts = {name: json.dumps(schema, indent=2) + "\n" for name, schema in made().items()}
        if schemas is None:
            typer.echo(json.dumps(made(), indent=2))
            return
        try:
            schemas.mkdir(parents=True, exist_ok=True)
            for name, text in texts.items():
                (schemas / f"{name}.json").write_text(text, encoding="utf-8")
        except OSError as error:
            raise Invalid(f"--schemas: {schemas} cannot be written: {error.strerror}") from error
