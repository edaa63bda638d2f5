"""The terms of a goal: how it is to be carried out and by when, and how its sentence was read. Kept with the goal."""

from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ConfigDict

from app.domain.goal_language.conflict_set import ConstraintConflict
from app.domain.goal_language.constraints import UNCONSTRAINED, Constraints
from app.domain.goal_language.stated_holds import StatedHold
from app.domain.goal_language.times import Due
from robots.wire import SymbolicFact


class Reading(BaseModel):
    """Words of a sentence and what they were resolved to."""

    model_config = ConfigDict(frozen=True)

    said: str
    means: tuple[str, ...]


class GoalHold(StatedHold):
    """A hold as a goal states it, once it is recorded under its id."""

    id: str


class GoalTerms(BaseModel):
    """The terms of a goal.

    :param constraints: all of them, of the request and of the sentence.
    :param requested: those of the request alone.
    :param holds: all of them; `requested_holds`: those of the request alone; `emptying`: the goals that empty
        their places and bring their facts about, the last ones of the goal.
    :param not_before_s: how long after its submission the goal is not to be true; `not_before_at_s`: until when, by the
        world's clock.
    :param due: the deadline that the sentence states; None if it states none.
    :param conflict: of a goal without a plan, the constraints that stand in the way; None if none are known to.
    """

    model_config = ConfigDict(frozen=True)

    constraints: Constraints = UNCONSTRAINED
    requested: Constraints = UNCONSTRAINED
    due: Due | None = None
    readings: tuple[Reading, ...] = ()
    holds: tuple[GoalHold, ...] = ()
    requested_holds: tuple[StatedHold, ...] = ()
    emptying: tuple[SymbolicFact, ...] = ()
    not_before_s: float | None = None
    not_before_at_s: float | None = None
    conflict: ConstraintConflict | None = None

    @classmethod
    def from_json(cls, terms: Mapping[str, Any] | None) -> Self:
        """The terms as they are kept; no terms of a goal that has none."""
        return cls.model_validate(terms or {})
