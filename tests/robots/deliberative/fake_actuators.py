"""A robot that records what its agents do."""

from dataclasses import dataclass, field

from robots.deliberative.actuators import (
    DONE,
    Activation,
    Attempt,
    Claim,
    Outcome,
    Utterance,
    restored_outcome,
)
from robots.deliberative.commitments import DropReason
from robots.deliberative.costs import MEASURES
from robots.deliberative.program import Verb
from robots.executive.mind_memory import AttemptMemory


@dataclass
class FakeAttempt:
    """A packet that ends when the test says so."""

    wanted: Activation
    outcome: Outcome | None = None
    script_id: str = ""

    def cancel(self, words: str) -> None:
        if self.outcome is None:
            self.outcome = Outcome(False, words, DropReason.REPLACED)


@dataclass
class FakeActuators:
    """`is_busy`: another agent's packet runs; `refusal`: why packets are refused.

    `measures`: by name and arguments; what is no measure must not be asked for.
    """

    begun: list[FakeAttempt] = field(default_factory=list)
    said: list[Utterance] = field(default_factory=list)
    steered: list[tuple[Verb, str]] = field(default_factory=list)
    measures: dict[tuple[str, ...], float] = field(default_factory=dict)
    is_busy: bool = False
    refusal: str = ""
    senses: bool = True

    @property
    def tags(self) -> list[str]:
        return [one.wanted.tag for one in self.begun]

    def activate(self, wanted: Activation) -> Attempt | Outcome | None:
        if self.is_busy:
            return None
        if self.refusal:
            return Outcome(False, self.refusal)
        self.begun.append(FakeAttempt(wanted, script_id=str(len(self.begun))))
        return self.begun[-1]

    def resume(self, wanted: Activation, memory: AttemptMemory) -> Attempt:
        attempt = self.begun[int(memory.script_id)]
        attempt.outcome = restored_outcome(memory.outcome)
        return attempt

    def standing(self, claim: Claim) -> tuple[bool, bool]:
        return False, False

    def restore_standing(self, claim: Claim, *, is_granted: bool, keeps: bool) -> None:
        assert not is_granted
        assert not keeps

    def say(self, utterance: Utterance) -> Outcome:
        self.said.append(utterance)
        return DONE

    def measure(self, name: str, arguments: tuple[str, ...]) -> float | None:
        assert MEASURES.get(name) == len(arguments), f"{name}/{len(arguments)} is no measure"
        return self.measures.get((name, *arguments))

    def steer(self, verb: Verb, reason: str) -> Outcome:
        self.steered.append((verb, reason))
        return DONE
