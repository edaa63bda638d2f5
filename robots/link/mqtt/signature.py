"""Signatures of a robot's messages, and of orders to it: who holds the robot's key said this, of this topic and run.

A signed message has two MQTT user properties: `counter`, a decimal that grows with each message of a robot, and
`signature`, HMAC-SHA256 in hex with the robot's key over topic, run and counter, each followed by a line feed, and the
payload. A counter is accepted once on each topic, so a recorded message cannot be sent again
(orders: `robots.link.mqtt.order_check`). The last will is signed
when the robot connects, so it may arrive after messages with greater counters, but not after those of a later
connection: one message may be overtaken by one.
"""

import hashlib
import hmac
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from robots.link.mqtt.session import Publication

MAX_DIGITS = 19
"""Of a counter: nanoseconds since the epoch have as many."""


def signature_of(key: str, publication: Publication) -> str:
    """The signature of a message with its counter, hex."""
    head = f"{publication.topic}\n{publication.run}\n{publication.counter}\n".encode()
    return hmac.new(key.encode(), head + publication.payload, hashlib.sha256).hexdigest()


def fault_of(publication: Publication, key: str) -> str:
    """Why a message is not of one that holds the key, in words; empty if it is, be it new or sent again."""
    if not publication.signature:
        return "a message is not signed"
    if not publication.counter.isascii() or not publication.counter.isdigit():
        return "a signed message has no counter"
    if len(publication.counter) > MAX_DIGITS:
        return "a signed message's counter is too long"
    if not hmac.compare_digest(signature_of(key, publication).encode(), publication.signature.encode()):
        return "a message has a wrong signature"
    return ""


class Signer:
    """Signs with a robot's key. Its counters are the clock's time, so that they grow over restarts. Thread-safe."""

    def __init__(self, key: str, *, epoch_ns: Callable[[], int] = time.time_ns) -> None:
        """:param epoch_ns: a clock that is never set back over a restart; between messages it may be."""
        self._key = key
        self._epoch_ns = epoch_ns
        self._last = 0
        self._lock = threading.Lock()

    def __call__(self, publication: Publication) -> Publication:
        """The message with counter and signature."""
        with self._lock:
            self._last = max(self._last + 1, self._epoch_ns())
            counted = replace(publication, counter=str(self._last))
        return replace(counted, signature=signature_of(self._key, counted))


class OrderSigner:
    """Signs the service's orders to robots that have a key. Thread-safe."""

    def __init__(
        self, keys: Callable[[], Mapping[str, str]], *, epoch_ns: Callable[[], int] = time.time_ns
    ) -> None:
        """:param keys: by robot, asked for with each order: they change while the service runs."""
        self._keys = keys
        self._epoch_ns = epoch_ns
        self._signers: dict[str, tuple[str, Signer]] = {}
        self._lock = threading.Lock()

    def sign(self, robot: str, publication: Publication) -> Publication:
        """An order to the robot, signed if it has a key."""
        key = self._keys().get(robot)
        if key is None:
            return publication
        with self._lock:
            known = self._signers.get(robot)
            if known is None or known[0] != key:
                known = self._signers[robot] = key, Signer(key, epoch_ns=self._epoch_ns)
        return known[1](publication)


@dataclass(frozen=True, slots=True, kw_only=True)
class Accepted:
    """On one topic the two greatest counters accepted so far, and the greater one's signature.

    :param key_id: a digest of the key that they are of; a new key begins anew.
    """

    key_id: str
    before: int = -1
    last: int = -1
    signature: str = ""


def key_id_of(key: str) -> str:
    """A digest by which keys are told apart, and from which they cannot be computed."""
    return hashlib.sha256(b"counters of " + key.encode()).hexdigest()[:16]


class SignatureCheck:
    """Judges the messages of robots that have a key; nothing is computed for others. To be called from one thread.

    On a topic of which nothing is known the first message is accepted whatever its counter.
    """

    def __init__(self, accepted: Mapping[str, Accepted] | None = None) -> None:
        """:param accepted: by topic, before a restart."""
        self._accepted = dict(accepted or {})

    @property
    def accepted(self) -> Mapping[str, Accepted]:
        """By topic, to be kept over a restart."""
        return self._accepted.copy()

    def doubt(self, publication: Publication, key: str) -> str:
        """Why a message is not the robot's that holds the key; empty if it is.

        A message that the broker, or the network, delivers twice is accepted twice: recipients know its id.
        """
        if reason := fault_of(publication, key):
            return reason
        counter = int(publication.counter)
        key_id = key_id_of(key)
        known = self._accepted.get(publication.topic)
        if known is None or known.key_id != key_id:
            known = Accepted(key_id=key_id)
        if counter > known.last:
            self._accepted[publication.topic] = Accepted(
                key_id=key_id, before=known.last, last=counter, signature=publication.signature
            )
        elif counter > known.before and counter != known.last:
            self._accepted[publication.topic] = replace(known, before=counter)
        elif (counter, publication.signature) != (known.last, known.signature):
            return "an earlier message was sent again"
        return ""


def signers(keys: Mapping[str, str]) -> Mapping[str, Signer]:
    """A signer for each robot with a key."""
    return {robot: Signer(key) for robot, key in keys.items()}
