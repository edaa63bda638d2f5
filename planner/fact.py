"""Ground facts."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, order=True)
class Fact:
    """A ground atom of the knowledge base's vocabulary, e.g. object_position(sample_1, in, bay_7)."""

    predicate: str
    args: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.args)})"
