"""The radio link of a world: what it loses, how long it takes, and when there is contact at all."""

from collections.abc import Sequence
from math import ceil, log
from typing import Any, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from robots.world.part import Part

ONE_IN = 100
"""Of so many exchanges one may take longer than `LinkSpec.answer_s` says."""
RESENT_S = 1.0
"""An unanswered message is sent again so long after its answer could have come (world's clock)."""


class Outage(Part):
    """A time without contact that nobody knows of beforehand; every `every_s` seconds anew, if given."""

    start_s: float = Field(ge=0)
    end_s: float
    every_s: float | None = Field(default=None, gt=0)

    def covers(self, at_s: float) -> bool:
        since_s = at_s - self.start_s
        if since_s < 0:
            return False
        return (since_s if self.every_s is None else since_s % self.every_s) < self.end_s - self.start_s

    @model_validator(mode="after")
    def _ends(self) -> Self:
        if self.end_s <= self.start_s:
            raise ValueError(
                f"an outage ends after it starts: end_s {self.end_s:g}, start_s {self.start_s:g}"
            )
        if self.every_s is not None and self.every_s <= self.end_s - self.start_s:
            raise ValueError(
                f"an outage of {self.end_s - self.start_s:g} s every {self.every_s:g} s never ends"
            )
        return self


class Contact(Part):
    """Contact for `for_s` seconds in every `every_s`, the first time at `start_s`: known beforehand, as an orbit is."""

    start_s: float = Field(default=0.0, ge=0)
    for_s: float = Field(gt=0)
    every_s: float = Field(gt=0)

    @property
    def silence_s(self) -> float:
        """From the end of a contact to the next."""
        return self.every_s - self.for_s

    def covers(self, at_s: float) -> bool:
        since_s = at_s - self.start_s
        return since_s >= 0 and since_s % self.every_s < self.for_s

    @model_validator(mode="after")
    def _ends(self) -> Self:
        if self.for_s >= self.every_s:
            raise ValueError(
                f"a contact of {self.for_s:g} s every {self.every_s:g} s has no end: leave it out"
            )
        return self


class LinkSpec(Part):
    """The radio between the service and a robot, the same both ways; left out, it is perfect.

    A message is lost with probability `loss`, and if there is no contact when it leaves or when it would arrive. It
    takes `light_time_s` and `delay_s`, and up to `jitter_s` more, so that one may overtake another; with probability
    `duplication` it arrives twice. Where there are `contacts` there is contact in them alone; never in `outages`.
    World's clock throughout.
    """

    loss: float = Field(default=0.0, ge=0, le=0.95)
    delay_s: float = Field(default=0.0, ge=0, le=3600)
    jitter_s: float = Field(default=0.0, ge=0, le=3600)
    duplication: float = Field(default=0.0, ge=0, le=1)
    light_time_s: float = Field(default=0.0, ge=0, le=3600, description="one way")
    outages: tuple[Outage, ...] = ()
    contacts: tuple[Contact, ...] = ()

    def over(self, other: "LinkSpec") -> "LinkSpec":
        """This link, and where it says nothing the other."""
        return LinkSpec.model_validate({**other.model_dump(), **self.model_dump()})

    def in_contact(self, at_s: float) -> bool:
        if self.contacts and not any(contact.covers(at_s) for contact in self.contacts):
            return False
        return not any(outage.covers(at_s) for outage in self.outages)

    @property
    def is_sure(self) -> bool:
        """True if nothing is left to chance."""
        return self.loss == self.jitter_s == self.duplication == 0

    @property
    def round_trip_s(self) -> float:
        """There and back at the longest, in contact and if neither is lost."""
        return 2 * (self.light_time_s + self.delay_s + self.jitter_s)

    @property
    def silence_s(self) -> float:
        """The longest time without contact that is known beforehand."""
        return min((contact.silence_s for contact in self.contacts), default=0.0)

    @property
    def answer_s(self) -> float:
        """Within so long a question that is sent again and again is answered, but for one in `ONE_IN`.

        Outages are not known beforehand and so not counted. 0 for a perfect link.
        """
        through = (1 - self.loss) ** 2
        tries = ceil(log(1 / ONE_IN) / log(1 - through)) if through < 1 else 1
        pace_s = self.round_trip_s + RESENT_S
        speaking_s = self.round_trip_s + (tries - 1) * pace_s
        return speaking_s + self._windows_for(speaking_s, pace_s) * self.silence_s

    def _windows_for(self, speaking_s: float, pace_s: float) -> int:
        usable: Sequence[float] = [max(one.for_s - self.round_trip_s, pace_s) for one in self.contacts]
        return max(1, ceil(speaking_s / max(usable))) if usable else 0

    @model_validator(mode="after")
    def _speaks(self) -> Self:
        for contact in self.contacts:
            if contact.for_s <= self.round_trip_s / 2:
                raise ValueError(
                    f"a contact of {contact.for_s:g} s is over before a message has arrived, which takes up to "
                    f"{self.round_trip_s / 2:g} s"
                )
        return self

    @model_serializer(mode="wrap")
    def _as_written(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Only what is said, for what is left unsaid is the world's to say."""
        return {name: value for name, value in handler(self).items() if name in self.model_fields_set}
