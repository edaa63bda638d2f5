"""A world's link is told who judges and who signs messages before the first arrives, if it can have that."""

from typing import Any, cast

from app.agents.running_world import RunningWorld
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.link.mqtt.service import Guard, Listener
from robots.link.mqtt.signature import OrderSigner
from robots.link.transport import ServiceEnd
from tests.app.sample_store import Store

LISTENER, GUARD, SIGNER = cast("Listener", "listener"), cast("Guard", "guard"), cast("OrderSigner", "signer")


class PlainLink:
    """As of a package: notes what it is told, in order."""

    def __init__(self) -> None:
        self.told: list[Any] = []

    def listen(self, listener: Listener) -> None:
        self.told.append(listener)

    def start(self) -> None:
        self.told.append("start")


class SafeLink(PlainLink):
    """Others may publish on it."""

    def guard(self, guard: Guard) -> None:
        self.told.append(guard)

    def sign_orders(self, signer: OrderSigner) -> None:
        self.told.append(signer)


def told(link: PlainLink, guard: Guard | None = None, signer: OrderSigner | None = None) -> list[Any]:
    world = RunningWorld(
        file=Store().world,
        link=InMemoryLink.pair()[0],
        clock=ManualClock(),
        run=None,
        fleet=cast("ServiceEnd", link),
    )
    world.listen(LISTENER, guard, signer)
    return link.told


def test_a_link_on_which_others_may_publish_is_guarded_and_signs_before_it_starts() -> None:
    assert told(SafeLink(), GUARD, SIGNER) == ["guard", "signer", "listener", "start"]
    assert told(SafeLink()) == ["listener", "start"]


def test_a_link_that_can_have_neither_starts_without() -> None:
    assert told(PlainLink(), GUARD, SIGNER) == ["listener", "start"]
