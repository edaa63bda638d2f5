"""Signatures of robots' messages: who holds the robot's key said this, of this topic and run, and said it now.

A signed message has two MQTT user properties: `counter`, a decimal that grows with each message of a robot, and
`signature`, HMAC-SHA256 in hex with the robot's key over topic, run and counter, each followed by a line feed, and the
payload. A counter is accepted once on each topic, so a recorded message cannot be sent again. The last will is signed
when the robot connects, so it may arrive after messages with greater counters, but not after those of a later
connection: one message may be overtaken by one.
"""

import hashlib
import hmac
import time
from collections.abc import Callable, Mapping
from dataclasses import replace

from robots.link.mqtt.session import Publication

MAX_DIGITS = 19
"""Of a counter: nanoseconds since the epoch have as many."""


def signature_of(key: str, publication: Publication) -> str:
    """The signature of a message with its counter, hex."""
    head = f"{publication.topic}\n{publication.run}\n{publication.counter}\n".encode()
    return hmac.new(key.encode(), head + publication.payload, hashlib.sha256).hexdigest()


class Signer:
    """Signs a robot's messages. Its counters begin at the clock's time, so that they grow over its restarts."""

    def __init__(self, key: str, *, epoch_ns: Callable[[], int] = time.time_ns) -> None:
        """:param epoch_ns: a clock that is never set back over a restart; between messages it may be."""
        self._key = key
        self._epoch_ns = epoch_ns
        self._last = 0

    def __call__(self, publication: Publication) -> Publication:
        """The message with counter and signature."""
        self._last = max(self._last + 1, self._epoch_ns())
        counted = replace(publication, counter=str(self._last))
        return replace(counted, signature=signature_of(self._key, counted))


class SignatureCheck:
    """Judges the messages of robots that have a key; nothing is computed for others. To be called from one thread.

    Counters are kept in memory: after a restart the first message of a topic is accepted whatever its counter.
    """

    def __init__(self) -> None:
        self._last: dict[str, tuple[int, int, str]] = {}
        """By topic the two greatest counters accepted so far, the greater last, with its signature."""

    def doubt(self, publication: Publication, key: str) -> str:
        """Why a message is not the robot's that holds the key; empty if it is.

        A message that the broker, or the network, delivers twice is accepted twice: recipients know its id.
        """
        if not publication.signature:
            return "a message is not signed"
        if not publication.counter.isascii() or not publication.counter.isdigit():
            return "a signed message has no counter"
        if len(publication.counter) > MAX_DIGITS:
            return "a signed message's counter is too long"
        if not hmac.compare_digest(signature_of(key, publication).encode(), publication.signature.encode()):
            return "a message has a wrong signature"
        counter = int(publication.counter)
        before, last, known = self._last.get(publication.topic, (-1, -1, ""))
        if counter > last:
            self._last[publication.topic] = last, counter, publication.signature
        elif counter > before and counter != last:
            self._last[publication.topic] = counter, last, known
        elif (counter, publication.signature) != (last, known):
            return "an earlier message was sent again"
        return ""


def signers(keys: Mapping[str, str]) -> Mapping[str, Signer]:
    """A signer for each robot with a key."""
    return {robot: Signer(key) for robot, key in keys.items()}
