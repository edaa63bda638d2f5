"""Ground facts."""

from collections.abc import Mapping
from typing import NamedTuple


class Fact(NamedTuple):
    """A ground atom of the knowledge base's vocabulary, e.g. object_position(sample_1, in, bay_7).

    A tuple, since sets of facts are looked into millions of times for a large plan.
    """

    predicate: str
    args: tuple[str, ...] = ()

    def renamed(self, names: Mapping[str, str]) -> "Fact":
        """The fact with arguments exchanged; what is not in `names` stays."""
        return Fact(self.predicate, tuple([names.get(arg, arg) for arg in self.args]))

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.args)})"
