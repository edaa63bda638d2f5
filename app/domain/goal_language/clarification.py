"""What the language asks an operator."""

from dataclasses import dataclass

from app.domain.errors import Invalid


@dataclass(frozen=True, slots=True, kw_only=True)
class Clarification:
    """What is missing or not understood in a sentence.

    :param thing: the word in question.
    :param choices: words that would be understood.
    :param span: start and end of the word in the text, or where a choice would be inserted; None if there is no one
        place.
    :param link: a word to insert before a choice.
    """

    code: str
    detail: str
    thing: str = ""
    choices: tuple[str, ...] = ()
    span: tuple[int, int] | None = None
    link: str = ""

    def refusal(self) -> Invalid:
        """The error of a request that would need the answer."""
        return Invalid(self.detail, code=self.code, choices=self.choices, thing=self.thing, span=self.span)
