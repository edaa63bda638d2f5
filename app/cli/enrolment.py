"""`macta robot enrol`, `revoke` and `enrolled`: who may speak for a robot at the broker."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options import reported_errors

if TYPE_CHECKING:
    from app.cli.broker_files import Secrets
    from app.cli.certificates import Certificate

Folder = Annotated[
    Path,
    typer.Option(help="Folder of the broker's files `passwords` and `acl`.", metavar="FOLDER"),
]
Name = Annotated[str, typer.Argument(help="The robot's name, its user at the broker.", metavar="NAME")]
BROKER_FOLDER = Path("broker/data")
RELOAD = (
    "Have the broker read its files again: kill -HUP its process, or `docker compose kill -s HUP broker`."
)


def enrol(
    name: Name,
    world: Annotated[
        str | None, typer.Option(help="The only world that it is let into (default: all).")
    ] = None,
    folder: Folder = BROKER_FOLDER,
    certificate: Annotated[
        bool, typer.Option("--certificate", help="It shows a client certificate instead of a password.")
    ] = False,
    sign: Annotated[
        bool, typer.Option("--sign", help="It signs its messages, with a key that the service knows, too.")
    ] = False,
    renew: Annotated[
        bool, typer.Option("--renew", help="Give it new secrets for those that it has.")
    ] = False,
    days: Annotated[int, typer.Option(min=1, max=3650, help="How long a certificate is valid.")] = 365,
    out: Annotated[
        Path | None,
        typer.Option(
            help="File for its secrets, readable by you only (default: print them once).", metavar="FILE"
        ),
    ] = None,
) -> None:
    """Let a robot in at the broker: it may speak for itself, and for no other (docs/production.md).

    A robot that is enrolled keeps its secrets; --renew gives it new ones. Secrets are shown once and stored as digests.
    """
    from app.cli.broker_files import BrokerFiles, check_names
    from app.cli.certificates import Authority

    with reported_errors():
        check_names(name, world)
        issued = Authority(folder).issue(name, days=days, renew=renew) if certificate else None
        files = BrokerFiles(folder)
        secrets = files.enrol(name, world=world, password=not certificate, signs=sign, renew=renew)
        typer.echo(f"{name} is enrolled in {folder}" + (f" for world {world}" if world else ""))
        _hand_over(name, secrets, issued, out)
        typer.echo(RELOAD)


def revoke(name: Name, folder: Folder = BROKER_FOLDER) -> None:
    """Take a robot's rights and secrets at the broker. What is connected as it is cut off when the broker reloads."""
    from app.cli.broker_files import BrokerFiles
    from app.cli.certificates import Authority

    with reported_errors():
        files = BrokerFiles(folder)
        files.revoke(name)
        had_certificate = Authority(folder).forget(name)
        typer.echo(f"{name} has no rights at the broker any longer")
        if had_certificate and files.lets_everybody_in_by_name:
            typer.echo(
                f"macta: {folder / 'acl'} gives every certificate the topics of its name: remove the `pattern` lines",
                err=True,
            )
        typer.echo(RELOAD)


def enrolled(
    folder: Folder = BROKER_FOLDER,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> None:
    """List the robots that are enrolled, without their secrets."""
    from app.cli.broker_files import ANY_WORLD, BrokerFiles
    from app.cli.certificates import Authority

    with reported_errors():
        robots = [
            {
                "name": one.name,
                "world": None if one.world == ANY_WORLD else one.world,
                "password": one.has_password,
                "certificate": Authority(folder).of(one.name).certificate.exists(),
                "signs": one.signs,
            }
            for one in BrokerFiles(folder).enrolled()
        ]
        if as_json:
            typer.echo(json.dumps({"items": robots}, indent=2))
            return
        for robot in robots:
            shows = [what for what in ("password", "certificate", "signs") if robot[what]]
            typer.echo(f"{robot['name']}  {robot['world'] or 'all worlds'}  {', '.join(shows)}")


def _hand_over(name: str, secrets: "Secrets", issued: "Certificate | None", out: Path | None) -> None:
    """Show the new secrets, or write them to a file; either way for the only time."""
    from app.cli.broker_files import write_secret

    given: dict[str, object] = {}
    if secrets.password:
        given |= {"MACTA_BROKER_USERNAME": name, "MACTA_BROKER_PASSWORD": secrets.password}
    if secrets.key:
        given["MACTA_ROBOT_KEY"] = secrets.key
    if issued is not None:
        given |= {
            "MACTA_BROKER_CA": issued.authority,
            "MACTA_BROKER_CERTIFICATE": issued.certificate,
            "MACTA_BROKER_KEY": issued.key,
        }
    if not given:
        typer.echo("it keeps its secrets; --renew gives it new ones")
        return
    lines = "".join(f"{setting}={value}\n" for setting, value in given.items())
    if out is None:
        typer.echo(f"Give the robot these settings; secrets are not shown again:\n{lines}", nl=False)
    else:
        write_secret(out, lines)
        typer.echo(f"its settings are in {out}")
