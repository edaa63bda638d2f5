"""Child processes: how they are started and named, and what they share.

A process that is started from nothing imports everything anew: for a planner or a world a second of CPU time and more
than 100 MB. With `sharing`, children are forked from one process that has imported and loaded that already (Python's
fork server). They share its memory as long as they do not write to it, and start at once. That process runs nothing
else and has no threads, so that nothing is under way when it is forked.
"""

import ctypes
import gc
import logging
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.forkserver import ensure_running, set_forkserver_preload
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import Event, Thread
from typing import Any

logger = logging.getLogger(__name__)

ATTEMPTS = 20
"""At forking a child, for the process that it is to be forked from may have been killed."""
PAUSE_S = 0.05
"""Between two attempts: its end is noticed within a few milliseconds."""

MADV_DONTNEED = 4
"""Linux's number for `madvise`: the pages are read from their file again if they are needed."""

_sharing = Event()
"""Set while children are forked."""


@contextmanager
def sharing(*modules: str) -> Iterator[None]:
    """The block in which the children that are started share these modules, which are imported now, in the background.

    For entry points, once in a process. What is not found there is imported by each child that needs it.

    :param modules: dotted names; what their import loads is shared, too. None: nothing is shared.
    """
    try:
        if modules:
            set_forkserver_preload([*modules])
            with _interrupts_blocked():
                ensure_running()
            _sharing.set()
    except OSError as error:  # no folder for its socket, say
        logger.warning("planning processes and worlds take more memory, they cannot share any: %s", error)
    try:
        yield
    finally:
        _sharing.clear()


def keep_for_children() -> None:
    """Prepare what is loaded for the processes that are forked: for the end of a module that `sharing` is given.

    Collections will not scan it, which would write to each object, and so share none. Of the libraries, the pages that
    only loading needed are given back: LLVM's, 69 MB.
    """
    gc.freeze()
    system = ctypes.CDLL(None)
    with suppress(OSError):  # there is no /proc
        for start, length in _unchanged_files():
            system.madvise(ctypes.c_void_p(start), ctypes.c_size_t(length), MADV_DONTNEED)


def _unchanged_files() -> Iterator[tuple[int, int]]:
    """The mappings of files, each with its length, that are only read and in which no page differs from the file."""
    found = None
    for line in Path("/proc/self/smaps").read_text().splitlines():
        match line.split(maxsplit=5):
            case [bounds, "r--p" | "r-xp", _, _, _, path] if path.startswith("/"):
                start, end = (int(bound, 16) for bound in bounds.split("-"))
                found = start, end - start
            case [bounds, _, _, _, _, *_] if "-" in bounds:
                found = None
            case ["Anonymous:", "0", "kB"] if found:
                yield found


def start_child(target: Callable[..., None], *args: Any, name: str, shares: bool = True) -> BaseProcess:
    """Start a process that calls a function, with this one's environment; it is ended when this one exits.

    SIGINT is blocked in it: only the parent handles Ctrl-C. The function notices itself if the parent is killed.

    :param target: a function of a module; it and its arguments are pickled.
    :param name: the process's own, as `ps -o comm` shows it.
    :param shares: False: it is started from nothing, for it needs other things or much memory for a short time.
    """
    is_forked = shares and _sharing.is_set()
    context: Any = get_context("forkserver" if is_forked else "spawn")
    process: BaseProcess = context.Process(
        target=_call, args=(target, args, name, dict(os.environ)), name=name, daemon=True
    )
    for attempts_left in reversed(range(ATTEMPTS if is_forked else 1)):
        try:
            with _interrupts_blocked():
                process.start()
            break
        except (EOFError, OSError):
            # NOTE: the process that children are forked from was killed; it is started again once its end is noticed.
            if not attempts_left:
                raise
            Event().wait(PAUSE_S)
    return process


def end_with_parent(end: Callable[[], None] = lambda: os._exit(1)) -> None:
    """In a child: have it end after its parent, also after one that was killed; else it may wait for ever.

    :param end: ends the process; called in a thread of its own.
    """
    parent = parent_process()
    if parent is None:
        return

    def follow() -> None:
        parent.join()
        end()

    Thread(target=follow, daemon=True).start()


def _call(target: Callable[..., None], args: tuple[Any, ...], name: str, environment: dict[str, str]) -> None:
    """The child's main function."""
    os.environ.clear()
    os.environ.update(environment)
    with suppress(OSError):  # there is no /proc
        Path("/proc/self/comm").write_text(name)
    target(*args)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """The block in which processes are started that have SIGINT blocked, by the inherited signal mask."""
    resource_tracker.ensure_running()  # the first time, it unblocks what is blocked
    previous_mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous_mask)
