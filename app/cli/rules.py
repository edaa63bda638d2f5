"""`macta rules`: the rule files of robots' deliberative level."""

from itertools import dropwhile, takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options import PackNames, packs_of, reported_errors
from app.domain.errors import Invalid

if TYPE_CHECKING:
    from robots.deliberative.program import RuleFile

commands = typer.Typer(no_args_is_help=True, help="Show and check rule files (docs/rules.md).")


@commands.callback()
def rules() -> None:
    """Show and check rule files (docs/rules.md)."""


@commands.command("list")
def list_rules() -> None:
    """List the rule files that ship with Macta, with what each is for."""
    from robots.world.rule_files import shipped_rules

    shipped = {name: path.read_text(encoding="utf-8") for name, path in shipped_rules().items()}
    width = max(map(len, shipped), default=0)
    for name, text in shipped.items():
        typer.echo(f"{name:<{width}}  {_purpose(text)}")


@commands.command()
def show(name: Annotated[str, typer.Argument(help="A rule file that ships with Macta.")]) -> None:
    """Print a rule file that ships with Macta, to be changed for a robot."""
    with reported_errors():
        typer.echo(_path(Path(name)).read_text(encoding="utf-8"), nl=False)


@commands.command()
def check(
    files: Annotated[
        list[Path],
        typer.Argument(
            help="Rule files of one agent: its own and those of roles; shipped ones by name.", metavar="FILE"
        ),
    ],
    pack: PackNames = None,
) -> None:
    """Check rule files together; an error names the file, line and column, and the way out.

    Prints the sensors that the rules need.
    """
    from robots.deliberative.lint import check as check_rules
    from robots.deliberative.perceptors import Perceptor
    from robots.deliberative.reader import read_rules
    from robots.errors import RuleError

    with reported_errors():
        try:
            read = [read_rules(_path(file)) for file in files]
            check_rules(read, packs_of(pack).repertoire())
        except RuleError as error:
            raise Invalid(str(error)) from error
        for one in read:
            needs = sorted({need for spec in one.perceptors for need in Perceptor(spec).needs})
            typer.echo(
                f"{one.name} {one.version}: valid; {_summary(one)}; needs {', '.join(needs) or 'no sensor'}"
            )


@commands.command("try")
def try_rules(
    files: Annotated[
        list[Path],
        typer.Argument(help="Rule files of one robot; shipped ones by name.", metavar="FILE"),
    ],
    recording: Annotated[Path, typer.Option(help="A mission's recording, an MCAP file.", metavar="FILE")],
    robot: Annotated[str, typer.Option(help="The robot whose record is read.")],
    pack: PackNames = None,
) -> None:
    """Try rule files on a recording: print which rules would have fired, when and with which values.

    Nothing is acted on: each action is taken to succeed at once, and the record goes on as it was. Beacons and
    robots in view are not recorded; what was said to the robot is if it had rules.
    """
    from app.recordings.robot_record import robot_record
    from robots.deliberative.reader import read_rules
    from robots.deliberative.rehearsal import rehearse
    from robots.deliberative.terms import shown
    from robots.errors import RuleError

    with reported_errors():
        try:
            read = [read_rules(_path(file)) for file in files]
            record = robot_record(recording, robot)
            repertoire = packs_of(pack).repertoire()
            rehearsal = rehearse(
                read,
                repertoire,
                record.instants,
                robot=robot,
                home=record.home,
                has_touches=record.has_touches,
            )
        except RuleError as error:
            raise Invalid(str(error)) from error
    for agent, made in rehearsal.fired:
        bound = ", ".join(f"?{name.lstrip('?')} = {shown(value)}" for name, value in made.bindings.items())
        does = made.name or "beliefs only"
        typer.echo(f"{made.made_s:8.1f} s  {agent:<12}  {made.origin:<16}  {does:<16}  {bound}".rstrip())
    for name, spec in rehearsal.unread:
        typer.echo(
            f"{name}:{spec.place.line}: {spec.belief} is not recorded: its rules did not fire", err=True
        )
    if not record.has_messages and any(_hears(one) for one in read):
        typer.echo(f"what was said to {robot} is not recorded: it had no rules then", err=True)
    elif record.unread_messages:
        count = record.unread_messages
        what = "1 message" if count == 1 else f"{count} messages"
        typer.echo(f"{what} to {robot} {'is' if count == 1 else 'are'} not recorded whole", err=True)
    first, last = record.instants[0].percepts.time_s, record.instants[-1].percepts.time_s
    rules_fired = f"{len(rehearsal.fired)} firing{'' if len(rehearsal.fired) == 1 else 's'}"
    typer.echo(
        f"{rules_fired} from {first:.1f} to {last:.1f} s, in {len(record.instants)} records of {robot}"
    )


Service = Annotated[str, typer.Option(help="Address of the service.", metavar="URL")]
LOCAL = "http://127.0.0.1:8000"
Robot = Annotated[str, typer.Argument(help="The robot's name.", metavar="NAME")]


@commands.command("break")
def break_at(
    robot: Robot,
    rule: Annotated[
        list[str] | None,
        typer.Argument(
            help="File and line of each rule (default: say where its world stands).", metavar="FILE:LINE"
        ),
    ] = None,
    clear: Annotated[bool, typer.Option("--clear", help="Remove the robot's breakpoints.")] = False,
    service: Service = LOCAL,
) -> None:
    """Set breakpoints on rules of a simulated robot: its whole world stands where one fires (docs/rules.md).

    Replaces the robot's earlier ones. The service's token is read from MACTA_TOKEN.
    """
    from app.cli.breakpoints import set_breakpoints
    from app.cli.service_calls import connected

    with reported_errors(), connected(service) as client:
        typer.echo(set_breakpoints(client, robot, rule or [], clear=clear))


@commands.command()
def step(robot: Robot, service: Service = LOCAL) -> None:
    """Let a world that stands at a breakpoint make one control cycle: each robot deliberates once."""
    _go_on(robot, service, one_cycle=True)


@commands.command("continue")
def go_on(robot: Robot, service: Service = LOCAL) -> None:
    """Let a world that stands at a breakpoint go on until the next one is met."""
    _go_on(robot, service, one_cycle=False)


def _go_on(robot: str, service: str, *, one_cycle: bool) -> None:
    from app.cli.breakpoints import go_on as run
    from app.cli.service_calls import connected

    with reported_errors(), connected(service) as client:
        typer.echo(run(client, robot, one_cycle=one_cycle))


def _hears(file: "RuleFile") -> bool:
    """True if a condition of the file is about messages."""
    from robots.deliberative.mind import believed
    from robots.deliberative.vocabulary import MESSAGE

    return any(term.functor == MESSAGE for term in believed(file))


def _summary(file: "RuleFile") -> str:
    from robots.deliberative.program import plans_of

    counted = {"rule": file.rules, "plan": list(plans_of(file)), "perceptor": file.perceptors}
    return ", ".join(f"{len(some)} {name}{'' if len(some) == 1 else 's'}" for name, some in counted.items())


def _path(file: Path) -> Path:
    """A file, or one that ships with Macta by its name.

    :raises Invalid: if there is neither.
    """
    from robots.world.rule_files import shipped_rules

    shipped = shipped_rules()
    if file.is_file() or file.suffix:
        return file
    if str(file) not in shipped:
        raise Invalid(f"no rule file {file}; those that ship: {', '.join(shipped)}")
    return shipped[str(file)]


def _purpose(text: str) -> str:
    """The first sentence of a file's first comment."""

    def is_comment(line: str) -> bool:
        return line.startswith("//")

    lines = dropwhile(lambda line: not is_comment(line), text.splitlines())
    comment = " ".join(line[2:].strip() for line in takewhile(is_comment, lines))
    return comment.split(". ")[0].rstrip(".")
