"""`macta rules`: the rule files of robots' deliberative level."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options import PackNames, packs_of, reported_errors
from app.domain.errors import Invalid

if TYPE_CHECKING:
    from robots.deliberative.program import RuleFile

commands = typer.Typer(no_args_is_help=True, help="Check rule files (docs/rules.md).")


@commands.callback()
def rules() -> None:
    """Check rule files (docs/rules.md)."""


@commands.command()
def check(
    files: Annotated[
        list[Path],
        typer.Argument(help="Rule files of one agent: its own and those of roles.", metavar="FILE"),
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
            read = [read_rules(file) for file in files]
            check_rules(read, packs_of(pack).repertoire())
        except RuleError as error:
            raise Invalid(str(error)) from error
        for one in read:
            needs = sorted({need for spec in one.perceptors for need in Perceptor(spec).needs})
            typer.echo(
                f"{one.name} {one.version}: valid; {_summary(one)}; needs {', '.join(needs) or 'no sensor'}"
            )


def _summary(file: "RuleFile") -> str:
    counted = {"rule": file.rules, "plan": file.plans, "perceptor": file.perceptors}
    return ", ".join(f"{len(some)} {name}{'' if len(some) == 1 else 's'}" for name, some in counted.items())
