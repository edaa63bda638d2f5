"""Speech of a robot's rules: what other robots say becomes `message` events, and `say` a message of a conversation.

What rules say belongs to the newest open conversation with the receiver in which this side may say it now; else it
opens one, if a protocol is opened by its performative.
"""

from typing import Protocol

from robots.deliberative.actuators import Utterance
from robots.deliberative.terms import Term as RuleTerm
from robots.deliberative.terms import Value, Variable, shown
from robots.social.level import SocialLevel
from robots.social.protocols import ANY, OPENED_BY
from robots.social.speech import Heard
from robots.social.terms import Argument, Term
from robots.wire import MAX_CONTENT, Performative

WITHIN_S = 60.0
"""How long a robot awaits the answer to what its rules say (our choice)."""


class Listener(Protocol):
    """The deliberative level, as far as it hears."""

    def hear(self, utterance: Utterance, now_s: float) -> bool:
        """Believe in the next cycle that someone has said this; False if no rule may match it."""
        ...


class RuleSpeech:
    """Connects rules with the social level: to be told to the one by `listen`, to the other as `speak`."""

    def __init__(self, level: SocialLevel) -> None:
        self._level = level

    def listen(self, listener: Listener) -> None:
        """Let rules hear what nobody else handles, and the answers to what they have said."""

        def handle(heard: Heard) -> bool:
            content = as_rule_value(heard.content)
            return listener.hear(
                Utterance(performative=heard.performative.value, other=heard.speaker, content=content),
                heard.at_s,
            )

        self._level.listen(handle)

    def speak(self, utterance: Utterance) -> str | None:
        """Say it, or return the reason why it cannot be said."""
        try:
            performative = Performative(utterance.performative)
        except ValueError:
            return f"{utterance.performative} is no performative"
        receiver = utterance.other
        content = as_content(utterance.content)
        if content is None:
            return (
                f"{shown(utterance.content)} is no content: it is neither a name nor a term without variables"
            )
        if len(str(content)) > MAX_CONTENT:
            return f"the content is longer than {MAX_CONTENT} characters"
        if self._level.go_on(performative, receiver, content, within_s=WITHIN_S):
            return None
        protocol = OPENED_BY.get(performative)
        if protocol is None or protocol is ANY:
            return f"{performative} answers nothing that {receiver} has said"
        self._level.say(
            performative, receiver, content, protocol=protocol, within_s=WITHIN_S, is_of_rules=True
        )
        return None


def as_rule_value(content: Argument) -> Value:
    """A content as rules know it: a term without arguments is a name."""
    if not isinstance(content, Term):
        return content
    if not content.args:
        return content.name
    return RuleTerm(content.name, tuple(as_rule_value(one) for one in content.args))


def as_content(value: Value) -> Term | None:
    """A rule's name or term as a content; None for a number or a term with variables."""
    if isinstance(value, str):
        return Term(value)
    if not isinstance(value, RuleTerm):
        return None
    args: list[Argument] = []
    for one in value.args:
        if isinstance(one, Variable):
            return None
        if isinstance(one, str | RuleTerm):
            inner = as_content(one)
            if inner is None:
                return None
            args.append(inner)
        else:
            args.append(float(one))
    return Term(value.functor, tuple(args))
