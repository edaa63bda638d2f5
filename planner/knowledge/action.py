"""What a plan-net action is made of: the slots of table 3, and its variants (MACTA §5)."""

from collections.abc import Iterable
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, NonNegativeFloat

from planner.knowledge.comparison import condition
from planner.knowledge.literal import Literal
from planner.knowledge.timing import AT_END, AT_START, THROUGHOUT, Span, split_span

Word = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
Tag = Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9_]*$", max_length=64)]
Formula = Annotated[str, Field(coerce_numbers_to_str=True)]
"""An expression, or just a number."""

PRECONDITIONS = "preconditions"
LITERAL_SLOTS = (PRECONDITIONS, "delete", "intended_effects", "other_effects")
USUAL_SPANS = {
    PRECONDITIONS: THROUGHOUT,
    "delete": AT_START,
    "intended_effects": AT_END,
    "other_effects": AT_END,
}
"""When the literals of each slot concern an action that does not say so."""


class Slot(BaseModel):
    """Base of everything in the file: immutable, unknown keys are an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class ParameterSpec(Slot):
    """A typed parameter; `values` narrows a type with constants; `teams` are the sizes of a list of
    robots."""

    name: Word
    type: Word
    values: tuple[str, ...] = ()
    teams: tuple[Annotated[int, Field(ge=1, le=4)], ...] = ()


class VariantSpec(Slot):
    """A variant of an action (our choice; one robot carries a compact object, two carry a long one): narrower types of
    parameters, the size of a list of robots, literals that it has beside the action's own, and its own duration and
    waiting."""

    types: dict[Word, Word] = {}
    teams: dict[Word, int] = {}
    preconditions: tuple[str, ...] = ()
    delete: tuple[str, ...] = ()
    intended_effects: tuple[str, ...] = ()
    other_effects: tuple[str, ...] = ()
    duration: Formula | None = None
    waiting: NonNegativeFloat | None = None

    def literals(self, slot: str) -> tuple[Literal, ...]:
        return read_literals(slot, getattr(self, slot))


def read_literals(slot: str, texts: Iterable[str]) -> tuple[Literal, ...]:
    """The literals of a slot; pre-conditions may compare a quantity with a number."""
    return tuple(literal for literal, _ in read_timed(slot, texts))


def read_timed(slot: str, texts: Iterable[str]) -> tuple[tuple[Literal, Span], ...]:
    """The literals of a slot, and when each concerns the action."""
    read = condition if slot == PRECONDITIONS else Literal.parse
    plain = (span_in(slot, text) for text in texts)
    return tuple((read(text), span) for text, span in plain)


def span_in(slot: str, text: str) -> tuple[str, Span]:
    """A literal's text in a slot without its times, and these.

    :raises KnowledgeBaseError: if the times are not of the form that the slot allows.
    """
    return split_span(text, USUAL_SPANS[slot], is_condition=slot == PRECONDITIONS)


PLAIN = VariantSpec()
"""The one variant of an action that lists none."""


class ActionSpec(Slot):
    """A plan-net action with all the slots of table 3; and, our own, its variants, and what one of its robots drives in
    metres and uses in joules.

    phases_when: static facts without which the times within it do not count: its agent then carries it out as one.
    changes: numbers that it changes evenly while it lasts, e.g. `wear(tool) += 0.01`.
    until: the number for which it is done, and how far it is changed at most, e.g. `battery(robot) <= 0.9`. It lasts as
     long as the plan needs, at least `duration`; plans hold it where a number would leave what is to be kept.
    waiting: what one of its robots uses a second while it waits for it, beyond rest, for the `drain` of quantities.
    """

    identifier: int = Field(ge=1)
    name: Tag
    parameters: tuple[ParameterSpec, ...] = Field(min_length=1)
    agents: tuple[Word, ...] = Field(min_length=1)
    distinct: tuple[tuple[Word, Word], ...] | None = None
    variants: tuple[VariantSpec, ...] = Field(default=(PLAIN,), min_length=1)
    preconditions: tuple[str, ...]
    delete: tuple[str, ...]
    intended_effects: tuple[str, ...] = Field(min_length=1)
    other_effects: tuple[str, ...]
    phases_when: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()
    until: str = ""
    duration: Formula
    distance: Formula = "0"
    energy: Formula = "0"
    waiting: NonNegativeFloat = 0.0
    description: str

    def literals(self, slot: str, variant: VariantSpec = PLAIN) -> tuple[Literal, ...]:
        """The slot's literals, then those of the variant."""
        return tuple(literal for literal, _ in self.timed(slot, variant))

    def timed(self, slot: str, variant: VariantSpec = PLAIN) -> tuple[tuple[Literal, Span], ...]:
        """The slot's literals, then those of the variant, and when each concerns the action."""
        return read_timed(slot, (*getattr(self, slot), *getattr(variant, slot)))

    def parameter(self, name: str) -> ParameterSpec:
        return next(parameter for parameter in self.parameters if parameter.name == name)
