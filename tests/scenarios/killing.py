"""Processes that tests kill, with all that they started."""

from pathlib import Path

from app.cli.trials.service_process import holder_of
from app.planning.pool.process_tree import kill, tree_of


def kill_family(pid: int) -> None:
    """SIGKILL to a process and all that it and its children started."""
    kill(tree_of(pid))


def process_of_the_world(pid: int, data: Path) -> int:
    """Of a process' family, the one that keeps the world in this data folder."""
    simulating = holder_of(data / "worlds", tree_of(pid))
    assert simulating is not None, "no process keeps the world"
    return simulating.pid
