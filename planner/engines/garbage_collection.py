"""Python's cyclic garbage collector, kept still where it finds nothing but costs a lot."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collector_at_rest() -> Iterator[None]:
    """Planning makes millions of objects that live to its end, and hardly any cycles: going through all of them again
    and again took a third of the time for 256 samples. What is not used any more goes by its reference count.

    Concerns the whole process; of plans made at the same time in several threads, the first to begin ends it.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
