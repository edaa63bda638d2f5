"""What a plan-net action is made of: the slots of table 3, and its variants (MACTA §5)."""

from collections.abc import Iterable
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from planner.knowledge.comparison import condition
from planner.knowledge.literal import Literal

Word = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
Tag = Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9_]*$", max_length=64)]
Formula = Annotated[str, Field(coerce_numbers_to_str=True)]
"""An expression, or just a number."""

PRECONDITIONS = "preconditions"
LITERAL_SLOTS = (PRECONDITIONS, "delete", "intended_effects", "other_effects")


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
    parameters, the size of a list of robots, literals that it has beside the action's own, and its own duration."""

    types: dict[Word, Word] = {}
    teams: dict[Word, int] = {}
    preconditions: tuple[str, ...] = ()
    delete: tuple[str, ...] = ()
    intended_effects: tuple[str, ...] = ()
    other_effects: tuple[str, ...] = ()
    duration: Formula | None = None

    def literals(self, slot: str) -> tuple[Literal, ...]:
        return read_literals(slot, getattr(self, slot))


def read_literals(slot: str, texts: Iterable[str]) -> tuple[Literal, ...]:
    """The literals of a slot; pre-conditions may compare a quantity with a number."""
    read = condition if slot == PRECONDITIONS else Literal.parse
    return tuple(map(read, texts))


PLAIN = VariantSpec()
"""The one variant of an action that lists none."""


class ActionSpec(Slot):
    """A plan-net action with all the slots of table 3; and, our own, its variants, and what one of its robots drives in
    metres and uses in joules."""

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
    duration: Formula
    distance: Formula = "0"
    energy: Formula = "0"
    description: str

    def literals(self, slot: str, variant: VariantSpec = PLAIN) -> tuple[Literal, ...]:
        """The slot's literals, then those of the variant."""
        return (*read_literals(slot, getattr(self, slot)), *variant.literals(slot))

    def parameter(self, name: str) -> ParameterSpec:
        return next(parameter for parameter in self.parameters if parameter.name == name)
