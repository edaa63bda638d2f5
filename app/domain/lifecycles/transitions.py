"""A checked change of state, shared by all life cycles."""

from collections.abc import Collection, Mapping
from enum import StrEnum
from typing import Protocol, TypeVar

from app.domain.errors import IllegalTransition

State = TypeVar("State", bound=StrEnum)


class Stateful(Protocol):
    """Anything with a recorded state, such as a row of a table."""

    state: str


def change_state(
    thing: Stateful, target: State, transitions: Mapping[State, Collection[State]], *, what: str
) -> None:
    """Assign `target` if the table allows it.

    :param transitions: the states that may follow each state.
    :raises IllegalTransition: if the table does not allow it, or lacks the present state.
    """
    check_transition(thing.state, target, transitions, what=what)
    thing.state = target


def check_transition(
    present: str | None,
    target: StrEnum | None,
    transitions: Mapping[State, Collection[State]] | Mapping[State | None, Collection[State | None]],
    *,
    what: str,
) -> None:
    """Refuse a change that the table does not allow; None stands for no state.

    :raises IllegalTransition: if the table does not allow it, or lacks the present state.
    """
    allowed = next((follow for state, follow in transitions.items() if state == present), ())
    if target not in allowed:
        raise IllegalTransition(f"a {what} that is {present} cannot become {target}")
