"""What commitments act by: the interface to packets, speech and the packet under way."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from robots.deliberative.commitments import DropReason
from robots.deliberative.program import Verb
from robots.deliberative.terms import Value
from robots.executive.mind_memory import AttemptMemory, OutcomeMemory


@dataclass(frozen=True, slots=True)
class Outcome:
    """How an action has ended: fulfilled, failed, or dropped for a reason. `words` say why."""

    is_fulfilled: bool
    words: str = ""
    dropped: DropReason | None = None


DONE = Outcome(True)


def stored_outcome(outcome: Outcome | None) -> OutcomeMemory | None:
    if outcome is None:
        return None
    dropped = None if outcome.dropped is None else outcome.dropped.value
    return OutcomeMemory(is_fulfilled=outcome.is_fulfilled, words=outcome.words, dropped=dropped)


def restored_outcome(memory: OutcomeMemory | None) -> Outcome | None:
    if memory is None:
        return None
    dropped = None if memory.dropped is None else DropReason(memory.dropped)
    return Outcome(memory.is_fulfilled, memory.words, dropped)


@dataclass(slots=True, kw_only=True, eq=False)
class Claim:
    """A commitment's claim on the robot's body by the plan that it has chosen.

    `title`: the plan's; `cost`: as of now, None if it is not known; `tell`: says for people how claims were compared;
    `has_begun`: a packet of the plan has begun, or was refused.
    """

    title: str
    cost: Callable[[], float | None]
    tell: Callable[[str], None]
    has_begun: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Activation:
    """A packet that a commitment wants to run. `may_carry`: also while the robot holds something.

    `agent`: who wants it; `because`: the file and line of the rule; `claim`: of its plan, None if that states no cost.
    """

    agent: str
    tag: str
    arguments: Mapping[str, str]
    timeout_s: float | None = None
    wait_timeout_s: float | None = None
    may_carry: bool = False
    because: str = ""
    claim: Claim | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Utterance:
    """What is said to someone, or heard of someone: `other` is the receiver, or the sender."""

    performative: str
    other: str
    content: Value


class Attempt(Protocol):
    """A packet that was activated."""

    @property
    def script_id(self) -> str:
        """The robot's own script by which it runs."""
        ...

    @property
    def outcome(self) -> Outcome | None:
        """How it has ended; None while it runs."""
        ...

    def cancel(self, words: str) -> None:
        """End it, if it has not ended."""
        ...


class Actuators(Protocol):
    """The robot, as its agents may act on it."""

    def activate(self, wanted: Activation) -> Attempt | Outcome | None:
        """Run a packet; an outcome if it is refused, None while another packet or claim has precedence."""
        ...

    def resume(self, wanted: Activation, memory: AttemptMemory) -> Attempt:
        """A packet that was activated by another program, whose scripts this one has taken up."""
        ...

    def standing(self, claim: Claim) -> tuple[bool, bool]:
        """Whether the claim has the robot's body in the next cycle, and whether it keeps it from its last packet."""
        ...

    def restore_standing(self, claim: Claim, *, is_granted: bool, keeps: bool) -> None:
        """Let the claim have what `standing` told."""
        ...

    def say(self, utterance: Utterance) -> Outcome:
        """Say something; it is fulfilled once it is on its way."""
        ...

    @property
    def senses(self) -> bool:
        """False while the robot senses nothing: then no measure is known."""
        ...

    def measure(self, name: str, arguments: tuple[str, ...]) -> float | None:
        """A measure of the robot for a plan's cost (`costs.py`); None if it is not known."""
        ...

    def steer(self, verb: Verb, reason: str) -> Outcome:
        """Suspend, resume, retry or give up the packet under way."""
        ...


Speak = Callable[[Utterance], str | None]
"""Sends what an agent says, or returns the reason why it cannot be sent."""
