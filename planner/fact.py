"""Ground facts."""

from typing import NamedTuple


class Fact(NamedTuple):
    """A ground atom of the knowledge base's vocabulary, e.g. object_position(sample_1, in, bay_7).

    A tuple, since sets of facts are looked into millions of times for a large plan.
    """

    predicate: str
    args: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.args)})"
