"""Which process compiles functions (numba), and what the others do meanwhile.

Functions are compiled in groups. One process at a time compiles a group, under the group's lock in the cache folder;
the kernel releases the lock when that process ends, however it ends. A file beside the machine code marks a group as
complete. Where another process compiles in the background, as a service has it done, a process runs the
functions as Python until the mark is there.
"""

import fcntl
import logging
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from robots.kernels import VARIABLE

logger = logging.getLogger(__name__)

DISABLED = "NUMBA_DISABLE_JIT"
"""numba's own switch: compiled functions run as Python."""
IN_BACKGROUND = "MACTA_COMPILES_IN_BACKGROUND"
"""Set in a process that has groups compiled in the background; the processes that it starts inherit it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Functions that are compiled together.

    :param name: for messages and files.
    :param compile: calls each of them once, with arguments of all types that occur; picklable.
    """

    name: str
    compile: Callable[[], None]


def compiles() -> bool:
    """False if this process runs compiled functions as Python, as it does where numba is not installed."""
    return os.environ.get(DISABLED, "0") in ("", "0") and _has_compiler()


@cache
def _has_compiler() -> bool:
    return find_spec("numba") is not None


def run_uncompiled() -> None:
    """Run compiled functions as Python from now on; call this before modules of `planner.compiled` are imported."""
    os.environ[DISABLED] = "1"


@contextmanager
def uncompiled() -> Iterator[None]:
    """The block in which processes are started that run compiled functions as Python.

    For work so small that compiling, and even importing numba, takes longer than it saves.
    """
    before = os.environ.get(DISABLED)
    run_uncompiled()
    try:
        yield
    finally:
        del os.environ[DISABLED]
        if before is not None:
            os.environ[DISABLED] = before


def is_compiled(group: Group) -> bool:
    """True if the machine code of all functions of the group is cached."""
    return VARIABLE in os.environ and _mark(group).exists()


def is_being_compiled(group: Group) -> bool:
    """True while another process holds the group's lock."""
    with _lock_file(group).open("a") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False


def compile_once(group: Group, tell: Callable[[str], None]) -> None:
    """Compile the group unless its machine code is cached; while another process compiles it, wait.

    :param tell: called with what is being done, if that takes time.
    """
    if VARIABLE not in os.environ or not compiles() or is_compiled(group):
        return
    with _lock_file(group).open("a") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            tell(f"waiting for another process, which compiles the {group.name}")
            fcntl.flock(lock, fcntl.LOCK_EX)
        if not is_compiled(group):
            tell(f"compiling the {group.name}: once, then it is kept in {_folder()}")
            group.compile()
            _mark(group).touch()


def load(group: Group) -> bool:
    """Call the group's functions once if their machine code is cached: processes forked from this one have it loaded.

    :returns: False: it is not cached, or cannot be loaded, which is logged; processes that need it do what is needed.
    """
    if not compiles() or not is_compiled(group):
        return False
    try:
        group.compile()
    except Exception:
        logger.exception("the %s cannot be loaded", group.name)
        return False
    return True


def _folder() -> Path:
    return Path(os.environ[VARIABLE])


def _mark(group: Group) -> Path:
    return _folder() / f"{group.name}.compiled"


def _lock_file(group: Group) -> Path:
    _folder().mkdir(parents=True, exist_ok=True)
    return _folder() / f"{group.name}.lock"
