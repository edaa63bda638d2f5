"""Shared by the commands: options, world files, errors and exit codes."""

import gc
import os
import sys
import traceback
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from app.domain.errors import Invalid, MactaError

if TYPE_CHECKING:
    from app.packs.pack_set import Packs
    from planner import KnowledgeBase
    from robots.wire import PacketTunings
    from robots.world import WorldFile

DEFAULT_WORLD = "of the pack: sample_store, survey_site"
World = Annotated[
    str | None,
    typer.Option(
        help="Name of a world of the packs, or a world file.", metavar="NAME|FILE", show_default=DEFAULT_WORLD
    ),
]
Worlds = Annotated[
    list[str] | None,
    typer.Option(
        "--world",
        help="Name of a world of the packs, or a world file; repeatable.",
        metavar="NAME|FILE",
        show_default=DEFAULT_WORLD,
    ),
]
PackNames = Annotated[
    list[str] | None,
    typer.Option(
        "--pack",
        help="Domain pack: the name of an installed one, or a folder; repeatable.",
        metavar="NAME|FOLDER",
        show_default="MACTA_PACKS, else store",
    ),
]
Speed = Annotated[float | None, typer.Option(min=0.01, help="World seconds per wall-clock second.")]

Broker = Annotated[
    str | None,
    typer.Option(help="MQTT broker between the service and the robots.", metavar="mqtt[s]://HOST[:PORT]"),
]


def fail(message: str) -> NoReturn:
    """Print an error on standard error and exit with 2."""
    from rich.console import Console  # here: a call without an error does without
    from rich.markup import escape

    Console(stderr=True, highlight=False, soft_wrap=True).print(f"[bold red]macta:[/] {escape(message)}")
    raise typer.Exit(2)


def leave(code: int) -> NoReturn:
    """Exit at once after everything is closed.

    A sleeping workflow holds a thread until its time is up. Its state is in the database, so nothing is lost.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


@contextmanager
def reported_errors() -> Iterator[None]:
    """Report expected errors as one line on standard error; an interruption exits with 130."""
    try:
        yield
    except (KeyboardInterrupt, typer.Abort) as interruption:
        # NOTE: releases the resources of the interrupted calls; semaphores would otherwise be reported as leaked.
        traceback.clear_frames(interruption.__traceback__)
        gc.collect()
        print("macta: interrupted", file=sys.stderr)
        leave(130)
    except MactaError as error:
        fail(f"{error.detail}; choices: {', '.join(error.choices)}" if error.choices else error.detail)
    except Exception as error:
        # NOTE: imported here: most commands need neither, and those that raise these errors have imported them.
        from planner.errors import KnowledgeBaseError
        from sim.error import SimulationError

        if isinstance(error, (SimulationError, KnowledgeBaseError)):
            fail(str(error))
        from app.store import unusable_reason

        if (why := unusable_reason(error)) is None:
            raise
        fail(f"the database cannot be used: {why}; check MACTA_DATABASE_URL or --data")


def packs_of(given: Sequence[str] | None) -> "Packs":
    """The domain packs that a command's options or the environment name, with those that they need."""
    from app.packs import chosen_packs
    from app.packs.find import load_packs

    return load_packs(chosen_packs(given))


def named_world(
    name: str | None, packs: "Packs | None" = None, knowledge_base: "KnowledgeBase | None" = None
) -> "WorldFile":
    """The world; exits if its file is invalid, or its facts or tags are not in the packs.

    :param name: None: the first world of the packs.
    :param packs: None: `store`.
    :param knowledge_base: None: that of the packs.
    """
    from app.domain.world_model import initial_facts
    from app.domain.world_model.numbers import initial_numbers
    from app.packs import STORE
    from app.packs.find import load_packs
    from planner import KnowledgeBaseError

    packs = packs or load_packs([STORE])

    def check_rules(files: "Mapping[str, str]") -> None:
        from robots.deliberative.rule_set import check_rule_set  # a parser, which few worlds need

        check_rule_set(files, packs.repertoire())

    name = name or packs.default_world
    world = world_file(
        name,
        packs.worlds(),
        tags=packs.tags(),
        check_tuning=lambda tuning: packs.repertoire().tuned(tuning),
        check_rules=check_rules,
    )
    try:
        initial_facts(world, knowledge_base or packs.knowledge_base())
        initial_numbers(world, knowledge_base or packs.knowledge_base())
    except (KnowledgeBaseError, Invalid) as error:
        fail(f"{name} is not a valid world: facts: {error}")
    return world


def world_file(
    name: str,
    worlds: Mapping[str, Path] | None,
    *,
    tags: "Collection[str] | None" = None,
    check_tuning: "Callable[[PacketTunings], object] | None" = None,
    check_rules: "Callable[[Mapping[str, str]], object] | None" = None,
) -> "WorldFile":
    """The world; exits if its file is invalid. Facts are not checked; tags, tunings and rules if these are given.

    :param worlds: the files of the worlds that have names; None: of those that ship with Macta.
    """
    from robots.world import WorldFileError, load_world

    try:
        return load_world(name, worlds=worlds, tags=tags, check_tuning=check_tuning, check_rules=check_rules)
    except WorldFileError as error:
        fail(str(error))


def named_worlds(names: Sequence[str] | None, packs: "Packs") -> "Sequence[WorldFile]":
    """The worlds of one service; exits if one is invalid, or two worlds or robots have the same name."""
    worlds = [named_world(name, packs) for name in names or (None,)]
    known: dict[str, str] = {}
    for world in worlds:
        for thing in (f"world {world.name}", *(f"robot {robot.name}" for robot in world.agents)):
            if thing in known:
                fail(
                    f"--world: {thing} is in {known[thing]} and in {world.name}; "
                    "the names of worlds and robots must be unique in a service"
                )
            known[thing] = world.name
    return worlds
