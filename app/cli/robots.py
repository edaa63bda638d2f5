"""`macta robot`: the contract between the service and robots."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from app.cli import enrolment
from app.cli.options import Broker, reported_errors
from app.domain.errors import Invalid

commands = typer.Typer(no_args_is_help=True, help="Connect robots to the service (docs/robots.md).")
Service = Annotated[str, typer.Option(help="Address of the service.", metavar="URL")]
LOCAL = "http://127.0.0.1:8000"
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


@commands.command()
def check(
    robot: Annotated[str, typer.Option(help="Name of the robot to check.")],
    world: Annotated[
        str, typer.Option(help="World of its topics. No service and no fleet may run it meanwhile.")
    ] = "check",
    broker: Broker = None,
    tag: Annotated[
        str | None, typer.Option(help="Packet to give it (default: the first of its factsheet).")
    ] = None,
    argument: Annotated[
        list[str] | None, typer.Option(help="Argument of the packet; repeatable.", metavar="NAME=VALUE")
    ] = None,
    packet_s: Annotated[float, typer.Option(min=0.5, help="Seconds that the packet takes.")] = 3.0,
    patience_s: Annotated[
        float, typer.Option(min=1, help="Seconds that an answer or a packet may take.")
    ] = 20.0,
    quiet_s: Annotated[
        float, typer.Option(min=0.5, help="Seconds that are waited for what must not happen.")
    ] = 2.0,
    relay: Annotated[
        str | None,
        typer.Option(
            help="Where to pass connections on to the broker (default host: 127.0.0.1). A robot that connects there is "
            "cut off for a while, to try its last will and how it reconnects.",
            metavar="[HOST:]PORT",
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print only one JSON document.")] = False,
) -> None:
    """Play the service for a robot and say which rules of the contract it keeps; the robot carries packets out.

    Exits with 0 only if no rule is broken.
    """
    from app.cli.robot_check import check_robot
    from app.cli.trials.conformance.check import CheckRequest

    with reported_errors():
        arguments = dict(one.partition("=")[::2] for one in argument or ())
        request = CheckRequest(
            tag=tag, arguments=arguments, packet_s=packet_s, patience_s=patience_s, quiet_s=quiet_s
        )
        raise typer.Exit(check_robot(broker, world, robot, request, relay=relay, as_json=as_json))


@commands.command()
def twin(
    robot: Annotated[str, typer.Argument(help="The robot's name.", metavar="NAME")],
    is_simulated: Annotated[
        bool | None,
        typer.Option("--simulated/--real", help="Who speaks for it from now on (default: say who does)."),
    ] = None,
    service: Service = LOCAL,
) -> None:
    """Replace an idle robot by its simulated twin, or the twin by the robot, on a running service.

    The service's token is read from MACTA_TOKEN. Refused with the reason while a mission needs the robot, it holds a
    sample, or its own software is connected.
    """
    from app.cli.service_calls import connected
    from app.cli.twin import twin as run

    with reported_errors(), connected(service) as client:
        typer.echo(run(client, robot, is_simulated=is_simulated))


@commands.command()
def embody(
    robot: Annotated[str, typer.Argument(help="The robot's name.", metavar="NAME")],
    body: Annotated[
        str | None,
        typer.Argument(
            help="Kind of the body: avatar, velocity, wheeled, or real (default: say which it is in).",
            metavar="BODY",
        ),
    ] = None,
    lease_s: Annotated[
        float | None,
        typer.Option(
            help="Seconds that it may act there without hearing of the service (default: without end)."
        ),
    ] = None,
    patience_s: Annotated[float, typer.Option(min=0, help="Seconds that the move's end is awaited.")] = 60.0,
    service: Service = LOCAL,
) -> None:
    """Move a robot's mind into another body on a running service, while it works, too, or say which body it is in.

    The service's token is read from MACTA_TOKEN. Refused with the reason while the robot could not go on there.
    """
    from app.cli.embody import embody as run
    from app.cli.service_calls import connected

    with reported_errors(), connected(service) as client:
        typer.echo(run(client, robot, body, lease_s=lease_s, patience_s=patience_s))


@commands.command()
def role(
    robot: Annotated[str, typer.Argument(help="The robot's name.", metavar="NAME")],
    wanted: Annotated[
        str | None,
        typer.Argument(help="The role that it is to play (default: say what it plays).", metavar="ROLE"),
    ] = None,
    tag: Annotated[
        list[str] | None,
        typer.Option(
            help="Packet that it is recruited for in this role; repeatable (default: all that it can)."
        ),
    ] = None,
    home: Annotated[
        str | None, typer.Option(help="Place where it is charged in this role (default: as it was).")
    ] = None,
    rules: Annotated[
        Path | None,
        typer.Option(
            help="The role's rule file (default: one of its name among the robot's, or a shipped one)."
        ),
    ] = None,
    clear: Annotated[bool, typer.Option("--clear", help="End its role.")] = False,
    service: Service = LOCAL,
) -> None:
    """Give a robot a role on a running service, end it, or say which it plays (docs/rules.md).

    The service's token is read from MACTA_TOKEN. Refused with the reason if the role does not fit the robot.
    """
    from app.cli.role import role as run
    from app.cli.service_calls import connected

    with reported_errors(), connected(service) as client:
        typer.echo(run(client, robot, wanted, tags=tag or (), home=home, rules=rules, clear=clear))


@commands.command()
def say(
    robot: Annotated[str, typer.Argument(help="The robot's name.", metavar="NAME")],
    text: Annotated[str, typer.Argument(help="A sentence, or a line of FIPA ACL (docs/people.md).")],
    approve: Annotated[
        bool, typer.Option("--approve", help="Carry out at once what it asks for, without showing it first.")
    ] = False,
    dialogue: Annotated[
        str | None, typer.Option(help="Dialogue that it goes on with, such as the answer to which one.")
    ] = None,
    patience_s: Annotated[
        float, typer.Option(min=0, help="Seconds that the robot's answer is awaited.")
    ] = 120.0,
    service: Service = LOCAL,
) -> None:
    """Say something to one robot on a running service, such as "face sample_1" or "what do you see?".

    The service's token is read from MACTA_TOKEN.
    """
    from app.cli.say import say as run
    from app.cli.service_calls import connected

    with reported_errors(), connected(service) as client:
        for line in run(client, robot, text, approve=approve, dialogue=dialogue, patience_s=patience_s):
            typer.echo(line)
