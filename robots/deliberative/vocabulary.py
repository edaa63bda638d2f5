"""The beliefs that every agent has without declaring them: events of one cycle, and what it knows of itself."""

from collections.abc import Mapping

from robots.deliberative.terms import Term, Value, Variable

STARTUP = "startup"
EVENT = "event"
PACKET = "packet"
SCRIPT = "script"
MESSAGE = "message"
FULFILLED = "fulfilled"
FAILED = "failed"
ROLE = "role"
ME = "me"
HOME = "home"
HAS_SCRIPT = "has_script"
DOING = "doing"
GIVEN = "given"
LAST_SEEN = "last_seen"

EVENTS: Mapping[str, tuple[str, ...]] = {
    STARTUP: (),
    EVENT: ("tag", "name"),
    PACKET: ("tag", "state"),
    SCRIPT: ("state",),
    MESSAGE: ("performative", "sender", "content"),
    FULFILLED: ("name",),
    FAILED: ("name",),
}
"""Beliefs of one cycle, with their arguments: the robot's start, events and states of packets and scripts, messages,
and how commitments ended, by the name of the packet, plan or action.
"""
KNOWN: Mapping[str, tuple[str, ...]] = {
    ME: ("robot",),
    HOME: ("place",),
    HAS_SCRIPT: (),
    DOING: ("tag",),
    GIVEN: ("name", "value"),
    LAST_SEEN: ("thing", "x", "y"),
}
"""What a robot knows of itself: its name, the place of its charger, whether it has a script of the service, its
current packet and that packet's arguments, and where it last saw what they name and is out of view, metres.
"""
ASSIGNED: Mapping[str, tuple[str, ...]] = {ROLE: ("name",)}
"""What an operator may have a robot believe, and its own rules may adopt, too."""
PERFORMATIVES = (
    "accept-proposal",
    "agree",
    "cancel",
    "cfp",
    "confirm",
    "disconfirm",
    "failure",
    "inform",
    "inform-if",
    "inform-ref",
    "not-understood",
    "propagate",
    "propose",
    "proxy",
    "query-if",
    "query-ref",
    "refuse",
    "reject-proposal",
    "request",
    "request-when",
    "request-whenever",
    "subscribe",
)
"""Of FIPA ACL (SC00037)."""


def form(name: str, arguments: tuple[str, ...]) -> Term:
    """The most general belief of a name."""
    return Term(name, tuple[Value, ...](Variable(one) for one in arguments))
