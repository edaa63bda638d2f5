"""Whom a robot knows: who was heard, when, and what it has said that it can do."""

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass

from robots.contract.known_scripts import remember

MAX_ACQUAINTANCES = 256
"""Beyond it the one that was heard longest ago is forgotten."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Acquaintance:
    """A robot, or a person, that was heard. `heard_s`: when last (world's clock); `abilities`: as it has said them."""

    name: str
    heard_s: float
    abilities: frozenset[str] = frozenset()


class Acquaintances:
    """Those that one robot has heard, the last heard last."""

    def __init__(self) -> None:
        self._known: OrderedDict[str, Acquaintance] = OrderedDict()

    def __iter__(self) -> Iterator[Acquaintance]:
        return iter(self._known.values())

    def of(self, name: str) -> Acquaintance | None:
        return self._known.get(name)

    def heard_s(self, name: str) -> float:
        """When it was last heard; -inf if never."""
        known = self._known.get(name)
        return float("-inf") if known is None else known.heard_s

    def hear(self, name: str, now_s: float, abilities: frozenset[str] | None = None) -> None:
        """:param abilities: what it says that it can do; None: it does not say."""
        before = self._known.get(name)
        told = before.abilities if abilities is None and before else abilities or frozenset()
        known = Acquaintance(name=name, heard_s=now_s, abilities=told)
        remember(self._known, name, known, MAX_ACQUAINTANCES)
