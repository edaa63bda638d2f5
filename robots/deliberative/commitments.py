"""A commitment's life cycle: its states, the allowed transitions, and the only code that assigns them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from robots.data import StrEnum
from robots.deliberative.program import Conditions, Step
from robots.deliberative.terms import Value
from robots.errors import RuleError


class CommitmentState(StrEnum):
    """The state of a commitment."""

    ADOPTED = "adopted"
    """A rule has made it; its time has not come."""
    ACTIVE = "active"
    """Its actions are carried out."""
    FULFILLED = "fulfilled"
    """They have succeeded."""
    FAILED = "failed"
    """One of them has not."""
    DROPPED = "dropped"
    """It was given up before either."""


class DropReason(StrEnum):
    """Why a commitment was dropped."""

    CONDITION = "condition"
    """The condition to keep, or its role, no longer holds."""
    REPLACED = "replaced"
    """Another commitment has taken what it used."""
    ORDER = "order"
    """The robot was ordered to do something else: a script came, was paused or cancelled."""
    RULES = "rules"
    """The rules were replaced."""
    OVERFLOW = "overflow"
    """There were too many commitments already."""


TRANSITIONS: Mapping[CommitmentState, frozenset[CommitmentState]] = {
    CommitmentState.ADOPTED: frozenset(
        {CommitmentState.ACTIVE, CommitmentState.FAILED, CommitmentState.DROPPED}
    ),
    CommitmentState.ACTIVE: frozenset(
        {CommitmentState.FULFILLED, CommitmentState.FAILED, CommitmentState.DROPPED}
    ),
    CommitmentState.FULFILLED: frozenset(),
    CommitmentState.FAILED: frozenset(),
    CommitmentState.DROPPED: frozenset(),
}


@dataclass(slots=True, kw_only=True, eq=False)
class Commitment:
    """What an agent has committed itself to.

    `number` counts the agent's commitments; `origin`: the file and line of its rule; `towards`: to whom it is made;
    `due_s`: when it becomes active; `reason`: why it was dropped; `words`: why it failed or was
    dropped, or which plan it has chosen, for people.
    """

    number: int
    origin: str
    towards: str
    step: Step
    bindings: Mapping[str, Value]
    maintain: Conditions
    made_s: float
    due_s: float
    name: str
    state: CommitmentState = field(default=CommitmentState.ADOPTED, init=False)
    reason: DropReason | None = field(default=None, init=False)
    words: str = field(default="", init=False)
    ended_s: float | None = field(default=None, init=False)

    @property
    def has_ended(self) -> bool:
        return not TRANSITIONS[self.state]


def activate(commitment: Commitment) -> None:
    """Begin to carry it out."""
    _change(commitment, CommitmentState.ACTIVE)


def note(commitment: Commitment, words: str) -> None:
    """Say for people how it is carried out."""
    commitment.words = words


def fulfil(commitment: Commitment, now_s: float) -> None:
    """Its actions have succeeded."""
    _change(commitment, CommitmentState.FULFILLED)
    commitment.ended_s = now_s


def fail(commitment: Commitment, words: str, now_s: float) -> None:
    """One of its actions has not succeeded."""
    _change(commitment, CommitmentState.FAILED)
    commitment.words = words
    commitment.ended_s = now_s


def drop(commitment: Commitment, reason: DropReason, words: str, now_s: float) -> None:
    """Give it up."""
    _change(commitment, CommitmentState.DROPPED)
    commitment.reason = reason
    commitment.words = words
    commitment.ended_s = now_s


def _change(commitment: Commitment, state: CommitmentState) -> None:
    if state not in TRANSITIONS[commitment.state]:
        raise RuleError(
            f"commitment {commitment.number} of {commitment.origin} cannot become {state}: it is {commitment.state}"
        )
    commitment.state = state
