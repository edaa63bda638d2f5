"""Compiles groups of functions in one process of low priority, while others run them as Python."""

import logging
import os
import signal
import threading
from collections.abc import Callable, Sequence

from robots.child_processes import end_with_parent, start_child
from robots.compilation import IN_BACKGROUND, Group, compile_once, compiles, is_being_compiled, is_compiled
from robots.data import StrEnum

logger = logging.getLogger(__name__)

ATTEMPTS = 2
"""Compiling processes that may end without success; then the functions stay uncompiled until the next start."""
NICENESS = 5
"""Of the compiling process: beside others it gets a third of the time that each of them gets, of an idle core all."""
POLL_S = 0.25

Tell = Callable[[str], None]


class Stage(StrEnum):
    """How far the compilation of a group is."""

    COMPILED = "compiled"
    """Its machine code is cached."""
    COMPILING = "compiling"
    """A process of this one's compiles it, or is about to."""
    WAITING = "waiting"
    """Another process on this machine compiles it."""
    UNCOMPILED = "uncompiled"
    """It runs as Python: its compilation failed, or is switched off (`NUMBA_DISABLE_JIT`)."""


class BackgroundCompilation:
    """Has groups compiled, one after the other. Processes started after it was made run uncompiled until they are.

    Several processes on one machine may have the same groups compiled: one of them does, and the next one if it ends.
    """

    def __init__(self, groups: Sequence[Group], *, tell: Tell = logger.info) -> None:
        """:param tell: called with what is being done, if anything is to be compiled."""
        self._groups = groups
        self._tell = tell
        self._lock = threading.Lock()
        self._compiled = {group.name for group in groups if compiles() and is_compiled(group)}
        self._stage = Stage.COMPILING if compiles() else Stage.UNCOMPILED
        self._doing = ""
        self._callbacks: list[Callable[[], None]] = []
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="compilation", daemon=True)
        os.environ[IN_BACKGROUND] = "1"

    @property
    def stage(self) -> Stage:
        """Of all the groups together."""
        with self._lock:
            return Stage.COMPILED if len(self._compiled) == len(self._groups) else self._stage

    def stage_of(self, name: str) -> Stage:
        """Of one group, by its name."""
        with self._lock:
            return Stage.COMPILED if name in self._compiled else self._stage

    @property
    def is_under_way(self) -> bool:
        """True as long as the stage may change."""
        return self.stage in (Stage.COMPILING, Stage.WAITING)

    def when_changed(self, callback: Callable[[], None]) -> None:
        """Call the function, in another thread, whenever a stage has changed."""
        self._callbacks.append(callback)

    def start(self) -> None:
        """Begin to compile what is not compiled."""
        if self.stage is Stage.COMPILING:
            self._thread.start()

    def close(self) -> None:
        """End the compiling process, if there is one; the next start continues. Safe to call again."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join()
        os.environ.pop(IN_BACKGROUND, None)

    def _run(self) -> None:
        attempts = ATTEMPTS
        while (missing := self._missing()) and not self._ending.is_set():
            if is_being_compiled(missing[0]):
                self._change(Stage.WAITING, f"another process compiles the {missing[0].name}")
                self._ending.wait(POLL_S)
            elif attempts:
                attempts -= 1
                names = " and the ".join(group.name for group in missing)
                self._change(Stage.COMPILING, f"compiling the {names}, once")
                self._have_compiled(missing)
            else:
                logger.warning("the %s cannot be compiled and runs slowly", missing[0].name)
                self._change(Stage.UNCOMPILED, f"the {missing[0].name} cannot be compiled")
                return
        if not missing:
            self._tell("everything is compiled")
            self._announce()

    def _have_compiled(self, groups: Sequence[Group]) -> None:
        process = start_child(_compile, tuple(groups), name="compiling", shares=False)
        try:
            while process.is_alive() and not self._ending.is_set():
                process.join(POLL_S)
                self._missing()
        finally:
            process.terminate()
            process.join()

    def _missing(self) -> Sequence[Group]:
        """The groups that are not compiled yet; those that have just been are announced."""
        missing = [group for group in self._groups if not is_compiled(group)]
        compiled = {group.name for group in self._groups} - {group.name for group in missing}
        with self._lock:
            is_new = compiled != self._compiled
            self._compiled = compiled
        if is_new:
            self._announce()
        return missing

    def _change(self, stage: Stage, doing: str) -> None:
        with self._lock:
            is_new = (stage, doing) != (self._stage, self._doing)
            self._stage = stage
            self._doing = doing
        if is_new:
            self._tell(doing)
            self._announce()

    def _announce(self) -> None:
        for callback in self._callbacks:
            callback()


def _compile(groups: Sequence[Group]) -> None:
    """The process's main function."""
    # NOTE: while functions are compiled, an exception cannot unwind the stack: the compiler's callbacks drop it.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.nice(NICENESS)
    end_with_parent()
    for group in groups:
        compile_once(group, logger.info)
