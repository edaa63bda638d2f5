"""Unique names that every PDDL reader accepts."""

import re
from collections.abc import Collection, Iterable

_KEYWORDS = """
    action all and assign at axiom conditional constants decrease define derived domain duration either effect
    end exists forall forbidden function functions imply increase init maximize metric minimize not number
    object objects or over parameters precondition predicates preference problem requirements scale-down
    scale-up start total-cost total-time types undefined when
"""
KEYWORDS = frozenset(_KEYWORDS.split())
_NOT_ALLOWED = re.compile(r"[^a-z0-9_]")


class Names:
    """A namespace: names in lower case, unique, no keywords; `original` inverts it.

    :param reserved: names that are not assigned.
    :param others: namespaces whose names are not reused: PDDL allows that, some readers do not.
    """

    def __init__(
        self,
        originals: Iterable[str] = (),
        others: "Iterable[Names]" = (),
        *,
        reserved: Collection[str] = KEYWORDS,
    ) -> None:
        self._others = tuple(others)
        self._reserved = reserved
        self._given: dict[str, str] = {}
        self._original: dict[str, str] = {}
        for original in originals:
            self.add(original)

    def add(self, original: str) -> str:
        """The name for an original, the same one each time."""
        if original not in self._given:
            name = _NOT_ALLOWED.sub("_", original.lower())
            if not name[:1].isalpha():
                name = f"x{name}"
            while name in self._reserved or any(name in names._original for names in (self, *self._others)):
                name += "_"
            self._given[original] = name
            self._original[name] = original
        return self._given[original]

    def __contains__(self, original: str) -> bool:
        return original in self._given

    def __getitem__(self, original: str) -> str:
        """:raises KeyError: if it has not been added."""
        return self._given[original]

    def original(self, name: str) -> str:
        """:raises KeyError: if there is no such name; case is ignored."""
        return self._original[name.lower()]
