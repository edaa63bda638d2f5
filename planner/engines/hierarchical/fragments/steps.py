"""Ground operators as bit masks, and the tasks they make up."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

from planner.knowledge import Operator


@dataclass(frozen=True, slots=True)
class Step:
    """A ground operator; the masks' bits are numbered by its `Task`."""

    op: Operator
    args: tuple[str, ...]
    cost: float
    needs: int
    removes: int
    adds: int
    intended: int
    """Its intended effects."""
    justifying: int
    """What it may be planned for: intended effects and whatever makes way."""

    agents: tuple[str, ...]

    @property
    def variant(self) -> tuple[str, int]:
        """The action's name and how many agents take part."""
        return self.op.spec.name, len(self.agents)


@dataclass(frozen=True, kw_only=True)
class Task:
    """A small world to search: its initial state, its steps and the goals as bits of their own (only intended
    effects set them).

    :param objects: those that the steps' arguments are chosen from.
    """

    objects: frozenset[str]
    steps: tuple[Step, ...]
    initial: int
    goal: int
    width: int

    @cached_property
    def needing(self) -> tuple[tuple[int, ...], ...]:
        """For each step the bits it needs."""
        return tuple(tuple(bits(step.needs)) for step in self.steps)

    @cached_property
    def adding(self) -> tuple[tuple[int, ...], ...]:
        """For each step the bits it adds."""
        return tuple(tuple(bits(step.adds)) for step in self.steps)

    @cached_property
    def wanted_by(self) -> tuple[tuple[int, ...], ...]:
        """For each bit the steps that need it."""
        table: list[list[int]] = [[] for _ in range(self.width)]
        for number, needs in enumerate(self.needing):
            for bit in needs:
                table[bit].append(number)
        return tuple(map(tuple, table))

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """For each step how many bits it needs."""
        return tuple(map(len, self.needing))

    def without(self, left_out: Collection[tuple[str, int]]) -> "Task":
        """The task without the actions of these names and numbers of agents."""
        return replace(self, steps=tuple(step for step in self.steps if step.variant not in left_out))

    def among(self, objects: frozenset[str]) -> "Task":
        """The task cut down to some of its objects."""
        steps = tuple(step for step in self.steps if objects.issuperset(step.args))
        return replace(self, objects=objects, steps=steps)


def bits(mask: int) -> Iterator[int]:
    """The numbers of the bits that are set."""
    while mask:
        low = mask & -mask
        yield low.bit_length() - 1
        mask ^= low
