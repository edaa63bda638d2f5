"""Links of installed packages: another way than MQTT between a service and a world's fleet.

A package registers a function under `macta.links`, named by the scheme of its addresses; it makes a `Transport` from an
address, and raises `ValueError` if that is none (docs/packs.md).
"""

from collections.abc import Iterable, Sequence
from typing import Protocol, runtime_checkable

from robots.clock import Clock
from robots.errors import ExtensionError
from robots.extensions import LINKS, installed, load_extension
from robots.link.channel import Link
from robots.link.mqtt.service import Listener


class FollowedClock(Clock, Protocol):
    """A world's clock as its fleet announces it."""

    @property
    def rate(self) -> float | None:
        """World seconds per wall-clock second; None: as fast as possible."""
        ...


class ServiceEnd(Link, Protocol):
    """The service's end. Only messages of the run that was taken up pass, in both directions.

    Those of robots that are added later pass, too, and those of the world itself, which is called "_world".
    """

    @property
    def clock(self) -> FollowedClock: ...

    @property
    def run(self) -> str | None:
        """The run that the fleet last announced, None before the first announcement."""
        ...

    @property
    def taken_up(self) -> str | None: ...

    def take_up(self, run: str) -> None: ...

    def listen(self, listener: Listener) -> None:
        """Set who receives telemetry and connection states; before `start`."""
        ...

    def start(self) -> None: ...


class FleetEnd(Link, Protocol):
    """The robots' end, of the fleet that drives a world."""

    @property
    def connected(self) -> bool: ...

    @property
    def complaint(self) -> str:
        """What is wrong with the link, in words; empty if no failure is known."""
        ...

    @property
    def refused(self) -> bool:
        """True if it can never be connected as it is."""
        ...

    @property
    def superseded(self) -> bool:
        """True once another fleet drives the world."""
        ...

    def start(self) -> None: ...

    def announce(self, time_s: float, rate: float | None) -> None:
        """Called often: tell the service the world's time and rate, at least once a second."""
        ...


@runtime_checkable
class ServesRobots(Protocol):
    """A fleet's end that needs to know when robots are added to the world or removed from it."""

    def serve(self, robots: Iterable[str]) -> None:
        """Speak for these robots from now on."""
        ...


class Transport(Protocol):
    """Makes the ends of links at an address; its text form is the address without secrets."""

    def service_end(self, world: str, robots: Sequence[str], *, digest: str) -> ServiceEnd:
        """:param digest: of the world file; a fleet that drives another one is ignored."""
        ...

    def fleet_end(self, world: str, robots: Sequence[str], *, run: str, digest: str) -> FleetEnd: ...


def package_transport(address: str) -> Transport | None:
    """The transport of a package for an address; None if no package has its scheme.

    :raises ValueError: if the address, or the package, cannot be used.
    """
    scheme = address.partition("://")[0]
    try:
        make = load_extension(LINKS, scheme)
    except ExtensionError as error:
        raise ValueError(str(error)) from error
    if make is None:
        return None
    transport: Transport = make(address)
    return transport


def package_schemes() -> Sequence[str]:
    """The schemes of packages' addresses."""
    return sorted(installed(LINKS))
