"""What the commands that run until they are told to end have in common."""

import logging
import signal
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import TypeVar

from rich.console import Console
from rich.markup import escape

from robots.link.mqtt import Broker

T = TypeVar("T")


def log_warnings() -> None:
    """On standard error, from any part."""
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(levelname)s %(name)s: %(message)s")


@contextmanager
def told_to_end() -> Iterator[threading.Event]:
    """Set by SIGINT and SIGTERM for the length of the block."""
    ending = threading.Event()
    before = {
        number: signal.signal(number, lambda *_: ending.set()) for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield ending
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def each(blocks: Iterable[AbstractContextManager[T]]) -> Iterator[Sequence[T]]:
    """Enter them one after the other, and leave all at the end of the block."""
    with ExitStack() as entered:
        yield [entered.enter_context(block) for block in blocks]


def warn_if_open(broker: Broker) -> None:
    """Say so if a password is about to be sent in the clear."""
    if broker.password is not None and not broker.is_private:
        Console(stderr=True).print(
            f"[yellow]{escape(str(broker))} is not encrypted: the password can be read on its way; say mqtts://[/]"
        )


def tell_why_afresh(world: str, why: str) -> None:
    """That a world does not go on from where it was kept."""
    Console(stderr=True).print(f"World {world} begins afresh: {escape(why)}.", soft_wrap=True)
