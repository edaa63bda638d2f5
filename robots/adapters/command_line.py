"""The command `macta-robot`: connects robots of one's own. What a subcommand needs is imported when it is called."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import version

DISTRIBUTION = "macta-robots"


@dataclass(frozen=True, slots=True, kw_only=True)
class Subcommand:
    """`module` has `add_arguments(parser)` and `run(arguments)`, which returns the exit status."""

    module: str
    about: str


SUBCOMMANDS: Mapping[str, Subcommand] = {
    "ros2": Subcommand(
        module="robots.adapters.ros2.command",
        about="keep the contract for a robot that is driven by ROS 2 actions; runs beside ROS 2",
    ),
    "vda5050": Subcommand(
        module="robots.adapters.vda5050.command",
        about="make VDA 5050 vehicles robots of a world, or robots vehicles of another master control",
    ),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand; answers the exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and words[0] in SUBCOMMANDS:
        return _run(words[0], words[1:])
    _parser().parse_args(words)
    _parser().print_help()
    return 0


def _run(name: str, words: Sequence[str]) -> int:
    chosen = SUBCOMMANDS[name]
    module = import_module(chosen.module)
    parser = argparse.ArgumentParser(prog=f"macta-robot {name}", description=module.__doc__)
    module.add_arguments(parser)
    status: int = module.run(parser.parse_args(words))
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="macta-robot", description="Connects robots to Macta.")
    parser.add_argument("--version", action="version", version=f"{DISTRIBUTION} {version(DISTRIBUTION)}")
    choices = parser.add_subparsers(metavar="SUBCOMMAND")
    for name, subcommand in SUBCOMMANDS.items():
        choices.add_parser(name, help=subcommand.about)
    return parser
