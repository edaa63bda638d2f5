"""How a person asks for a packet in plain words, as data beside its content."""

from typing import Annotated

from pydantic import Field

from robots.data import Checked

HOME = "home"
"""A value of `sets` that stands for the robot's own home."""
TIMEOUT = "timeout_s"
"""An amount that is how long the packet runs at most, not a parameter of it."""
Phrase = Annotated[str, Field(pattern=r"^[a-z]+( [a-z]+)*$", max_length=48)]


class Wording(Checked):
    """Verbs for a packet, and which of its arguments the other parts of a command fill.

    `object`: what follows the verb; `target`: what follows "to", "at", "in" or "on"; `amounts`: numbers with a unit,
    each told from the others by the unit that its name ends in, negative after a minus sign. `sets`: fixed values.
    """

    verbs: tuple[Phrase, ...] = Field(min_length=1, max_length=16)
    object: str = ""
    target: str = ""
    amounts: tuple[str, ...] = ()
    sets: dict[str, str] = Field(default_factory=dict)

    def fills(self) -> tuple[str, ...]:
        """The names of the arguments that it fills."""
        amounts = (one.removeprefix("-") for one in self.amounts)
        return tuple(name for name in (self.object, self.target, *amounts, *self.sets) if name)
