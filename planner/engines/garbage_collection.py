"""Pauses Python's cyclic garbage collector during planning."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def garbage_collection_paused() -> Iterator[None]:
    """Pause the collector of the whole process.

    Planning makes millions of long-lived objects and hardly any cycles; the collector took a third of the time for 256
    samples. If several threads plan at a time, the first to start ends the pause.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
