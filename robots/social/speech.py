"""A speech act as handlers get it, what they answer, and how a conversation ended."""

from dataclasses import dataclass

from robots.social.terms import Term
from robots.wire import Message, Performative


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """A speech act that was understood. `at_s`: when it was heard (world's clock).

    `person`: for whom the service says it; empty if the sender speaks for itself.
    """

    performative: Performative
    sender: str
    person: str = ""
    content: Term
    message: Message
    at_s: float

    @property
    def speaker(self) -> str:
        """Who speaks: the person, or the sender."""
        return self.person or self.sender

    @property
    def key(self) -> tuple[Performative, str]:
        """By which handlers are chosen."""
        return self.performative, self.content.name


@dataclass(frozen=True, slots=True, kw_only=True)
class Reply:
    """An answer in the same conversation."""

    performative: Performative
    content: Term


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How a conversation that this robot has opened ended. `answer`: the last one, None if there was none."""

    state: str
    answer: Heard | None
    at_s: float
