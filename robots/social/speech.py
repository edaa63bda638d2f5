"""A speech act as handlers get it, what they answer, and how a conversation ended."""

from dataclasses import dataclass

from robots.social.terms import Term
from robots.wire import Message, Performative


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """A speech act that was understood. `at_s`: when it was heard (world's clock)."""

    performative: Performative
    sender: str
    content: Term
    message: Message
    at_s: float

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
