"""A speech act as handlers get it, what they answer, and how a conversation ended."""

from dataclasses import dataclass

from robots.social.terms import ContentError, Term, parse_term
from robots.wire import MAX_CONTENT, TERMS, Message, Performative, SpeechAct

TOO_LONG = Term("too_long", (f"the answer is longer than {MAX_CONTENT} characters",))


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

    @property
    def is_too_long(self) -> bool:
        return len(str(self.content)) > MAX_CONTENT

    @property
    def text(self) -> str:
        """The content as it is said; in place of one that no message holds, that it is too long."""
        return str(TOO_LONG if self.is_too_long else self.content)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How a conversation that this robot has opened ended. `answer`: the last one, None if there was none."""

    state: str
    answer: Heard | None
    at_s: float


def content_of(performative: Performative, act: SpeechAct) -> Term:
    """What is said; a not-understood may say it in no language.

    :raises ContentError: if the language or the content is not known here.
    """
    if act.language != TERMS:
        raise ContentError(f"the language {act.language!r} is not spoken here; it is {TERMS}")
    try:
        return parse_term(act.content)
    except ContentError:
        if performative is not Performative.NOT_UNDERSTOOD:
            raise
        return Term("reason", (act.content,))
