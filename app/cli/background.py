"""Compilation in the background of a command, and its progress line."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console

from app.background_compilation import BackgroundCompilation
from app.cli.start_progress import StartProgress
from robots.compilation import Group
from robots.world import WorldFile

SMALL_ROBOTS = 8
"""A world of more robots runs slower than real time until the simulation is compiled, so that is compiled first."""


@contextmanager
def background_compilation(groups: Sequence[Group]) -> Iterator[BackgroundCompilation]:
    """Compilation that begins with `start` and ends with the block; what is not compiled then is compiled next time.

    :param groups: in the order in which they are compiled.
    """
    progress = StartProgress(Console(stderr=True), title="In the background")
    compilation = BackgroundCompilation(groups, tell=progress.tell)

    def end_if_compiled() -> None:
        if not compilation.is_under_way:
            progress.end()

    compilation.when_changed(end_if_compiled)
    with ending(compilation):
        try:
            yield compilation
        finally:
            progress.end()


@contextmanager
def ending(compilation: BackgroundCompilation) -> Iterator[BackgroundCompilation]:
    """End the compilation with the block."""
    try:
        yield compilation
    finally:
        compilation.close()


def groups_for(worlds: Sequence[WorldFile]) -> Sequence[Group]:
    """The groups of a service that simulates these worlds itself."""
    from app.planning.pool.work import PLANNER
    from sim.process.first_calls import SIMULATION

    if any(len(world.robots) > SMALL_ROBOTS for world in worlds):
        return (SIMULATION, PLANNER)
    return (PLANNER, SIMULATION) if worlds else (PLANNER,)
