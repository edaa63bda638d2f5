"""The life cycle of a conversation between the service and a robot, and the only code that assigns its state.

The states are those of the interaction protocol that it follows (`robots.social.protocols`): the robot's side has the
same ones.
"""

from typing import Protocol

from robots.social import OutOfProtocol
from robots.social.protocols import (
    CANCELLED,
    NOT_UNDERSTOOD,
    PROTOCOLS,
    TIMED_OUT,
    InteractionProtocol,
    RequestState,
    Side,
)
from robots.wire import Performative

__all__ = [
    "CANCELLED",
    "NOT_UNDERSTOOD",
    "TIMED_OUT",
    "OutOfProtocol",
    "ask_again",
    "cancel",
    "drop",
    "hear",
    "is_to_be_said",
    "open_conversation",
    "say",
    "stop_repeating",
    "time_out",
    "was_said",
]


class Talk(Protocol):
    """The fields of a conversation that its life cycle assigns.

    `is_ours`: the service has opened it. `is_due`: what the service said last is repeated until it is answered; what
    ends the conversation is due until it was sent once, for nothing answers it.
    """

    protocol: str
    is_ours: bool
    state: str
    is_over: bool
    is_due: bool
    reason: str


def open_conversation(talk: Talk, performative: Performative) -> None:
    """:raises OutOfProtocol: if its protocol is not known, or is not opened by this performative."""
    protocol = PROTOCOLS.get(talk.protocol)
    if protocol is None:
        choices = ", ".join(PROTOCOLS)
        raise OutOfProtocol(f"the protocol {talk.protocol!r} is not known here; choices: {choices}")
    if performative not in protocol.opens:
        raise OutOfProtocol(
            f"{protocol.name} is opened by {' or '.join(protocol.opens)}, not by {performative}"
        )
    talk.state = protocol.opens[performative]
    talk.is_over = protocol.has_ended(talk.state)
    talk.is_due = talk.is_ours
    talk.reason = ""


def is_to_be_said(talk: Talk) -> bool:
    """True while the service repeats what it said last: until it is answered, and after an agreement until the end, for
    the robot says that once, and again when it hears a repetition.
    """
    return talk.is_due or (talk.is_ours and talk.state == RequestState.AGREED)


def say(talk: Talk, performative: Performative) -> None:
    """The service says something. :raises OutOfProtocol: if it may not say it now."""
    _advance(talk, _service(talk), performative)
    talk.is_due = talk.is_ours


def was_said(talk: Talk) -> None:
    """What the service said last was sent."""
    if talk.is_over:
        talk.is_due = False


def hear(talk: Talk, performative: Performative, reason: str = "") -> None:
    """The robot says something. :raises OutOfProtocol: if it may not say it now. :param reason: that it states."""
    _advance(talk, Side.PARTICIPANT if talk.is_ours else Side.INITIATOR, performative)
    talk.is_due = False
    talk.reason = reason if talk.is_over else ""


def stop_repeating(talk: Talk) -> None:
    """The robot is known to have heard what was said last, unless that ended the conversation."""
    if not talk.is_over:
        talk.is_due = False


def ask_again(talk: Talk) -> None:
    """Repeat what was said last, unless the conversation has ended: its answer may have been lost."""
    talk.is_due = talk.is_due or not talk.is_over


def time_out(talk: Talk, reason: str) -> None:
    """End a conversation whose answer has not come in time."""
    _end(talk, TIMED_OUT, reason)


def cancel(talk: Talk, reason: str) -> None:
    """Give a conversation up without a word."""
    _end(talk, CANCELLED, reason)


def drop(talk: Talk, reason: str) -> None:
    """Give a conversation up whose robot is no longer spoken to; what was not sent yet is not sent."""
    cancel(talk, reason)
    talk.is_due = False


def _end(talk: Talk, state: str, reason: str) -> None:
    if talk.is_over:
        return
    talk.state = state
    talk.is_over = True
    talk.is_due = False
    talk.reason = reason


def _advance(talk: Talk, side: Side, performative: Performative) -> None:
    protocol = _protocol(talk)
    after = protocol.after(talk.state, side, performative)
    if after is None:
        raise OutOfProtocol(
            f"{performative} by the {side} does not follow in {protocol.name}, which is {talk.state}"
        )
    talk.state = after
    talk.is_over = protocol.has_ended(after)


def _service(talk: Talk) -> Side:
    return Side.INITIATOR if talk.is_ours else Side.PARTICIPANT


def _protocol(talk: Talk) -> InteractionProtocol:
    return PROTOCOLS[talk.protocol]
