"""The smallest set of constraints that cannot be kept together, and how it is known."""

from collections.abc import Callable, Sequence
from itertools import combinations, islice
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, Field

Part = TypeVar("Part")
Conflict = Callable[[Sequence[Part]], bool]
"""Whether these cannot be kept together. More of them never can if fewer cannot."""


class ConstraintConflict(BaseModel):
    """Constraints of a goal that stand in the way of a plan together."""

    model_config = ConfigDict(frozen=True)

    constraints: tuple[str, ...] = Field(description="each in words")
    proven: bool = Field(
        description="it is proven that they cannot be kept together; else no plan was found in the time given"
    )
    complete: bool = Field(
        default=True,
        description="without any one of them a plan was found; else there was no time to try each, and fewer may "
        "stand in the way",
    )


def smallest_conflict(parts: Sequence[Part], conflict: Conflict[Part], *, tries: int) -> tuple[Part, ...]:
    """A smallest part of what cannot be kept together, in the given order; empty if nothing of it can be blamed.

    :param conflict: true for `parts`.
    :param tries: how many smaller sets are tried than the first one found, of which none can be left out either.
    """
    if conflict(()):
        return ()
    found = _irreducible((), (), tuple(parts), conflict)
    smaller = (some for size in range(1, len(found)) for some in combinations(parts, size))
    smallest = next((some for some in islice(smaller, tries) if conflict(some)), found)
    return smallest if conflict(smallest) else tuple(parts)  # should fewer once conflict where more do not


def _irreducible(
    kept: tuple[Part, ...], new: tuple[Part, ...], parts: tuple[Part, ...], conflict: Conflict[Part]
) -> tuple[Part, ...]:
    """Of the parts those that are needed, beside the kept ones, for a conflict: QuickXplain (Junker, AAAI 2004).

    :param new: those of the kept ones that may make the parts needless.
    """
    if new and conflict(kept):
        return ()
    if len(parts) == 1:
        return parts
    middle = len(parts) // 2
    first, second = parts[:middle], parts[middle:]
    of_second = _irreducible((*kept, *first), first, second, conflict)
    of_first = _irreducible((*kept, *of_second), of_second, first, conflict)
    return (*of_first, *of_second)
