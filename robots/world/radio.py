"""The radio link of a world: loss, delay and contact windows."""

from collections.abc import Sequence
from math import ceil, log
from typing import Any

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator
from typing_extensions import Self

from robots.data import Checked

ONE_IN = 100
"""One exchange in this many may take longer than `LinkSpec.answer_s`."""
WORD_S = 0.2
"""Assumed interval between two messages of a robot, telemetry included; the real one is shorter."""
QUIET_S = 20.0
"""A shorter silence is never a sign of failure, whatever the radio: there are outages (our choice)."""
ONE_SILENCE_IN = 1_000_000
"""One silence in this many may exceed `LinkSpec.quiet_s` by loss alone."""
RESENT_S = 1.0
"""An unanswered message is resent this long after its answer could have arrived (world's clock)."""


class Outage(Checked):
    """An unannounced time without contact; repeated every `every_s` seconds, if given."""

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


class Contact(Checked):
    """A contact window of `for_s` seconds in every `every_s`, first at `start_s`; known in advance, as an orbit is."""

    start_s: float = Field(default=0.0, ge=0)
    for_s: float = Field(gt=0)
    every_s: float = Field(gt=0)

    @property
    def silence_s(self) -> float:
        """From the end of one window to the next."""
        return self.every_s - self.for_s

    def covers(self, at_s: float) -> bool:
        since_s = at_s - self.start_s
        return since_s >= 0 and since_s % self.every_s < self.for_s

    def next_s(self, at_s: float) -> float:
        """The beginning of the next window; `at_s` itself within one."""
        if self.covers(at_s):
            return at_s
        return self.start_s + max(0.0, ceil((at_s - self.start_s) / self.every_s)) * self.every_s

    def covered_s(self, till_s: float, *, late_s: float) -> float:
        """The total contact time until then, without the first `late_s` seconds of each window."""
        times, since_s = divmod(max(0.0, till_s - self.start_s), self.every_s)
        useful_s = self.for_s - late_s
        return times * useful_s + min(max(0.0, since_s - late_s), useful_s)

    @model_validator(mode="after")
    def _ends(self) -> Self:
        if self.for_s >= self.every_s:
            raise ValueError(
                f"a contact of {self.for_s:g} s every {self.every_s:g} s has no end: leave it out"
            )
        return self


class LinkSpec(Checked):
    """The radio between the service and a robot, the same both ways; left out, it is perfect.

    A message is lost with probability `loss`, and if there is no contact when it leaves or when it would arrive. It
    takes `light_time_s` and `delay_s`, and up to `jitter_s` more, so that one may overtake another; with probability
    `duplication` it arrives twice. With `contacts`, there is contact only within them; never within `outages`.
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
        """This link, with the other's values where this one states none."""
        return LinkSpec.model_validate({**other.model_dump(), **self.model_dump()})

    def in_contact(self, at_s: float) -> bool:
        if self.contacts and not any(contact.covers(at_s) for contact in self.contacts):
            return False
        return not any(outage.covers(at_s) for outage in self.outages)

    @property
    def is_sure(self) -> bool:
        """True if the link is deterministic: no loss, jitter or duplication."""
        return self.loss == self.jitter_s == self.duplication == 0

    @property
    def round_trip_s(self) -> float:
        """The longest round trip in contact, if neither message is lost."""
        return 2 * (self.light_time_s + self.delay_s + self.jitter_s)

    @property
    def silence_s(self) -> float:
        """The longest planned time without contact."""
        return min((contact.silence_s for contact in self.contacts), default=0.0)

    @property
    def quiet_s(self) -> float:
        """The shortest silence in contact that losses do not explain.

        Long enough that loss alone explains it only once in `ONE_SILENCE_IN`, and at least `QUIET_S`, or
        one whole window where that is shorter.
        """
        words = ceil(log(1 / ONE_SILENCE_IN) / log(self.loss)) if self.loss > 0 else 1
        whole_s = min((contact.for_s - self._late_s for contact in self.contacts), default=QUIET_S)
        return max(words * WORD_S, min(whole_s, QUIET_S))

    def hearing_s(self, since_s: float, till_s: float) -> float:
        """The part of a time span in which a message could have arrived by the planned contacts; outages ignored."""
        if not self.contacts:
            return max(0.0, till_s - since_s)
        late_s = self._late_s
        return max(
            one.covered_s(till_s, late_s=late_s) - one.covered_s(since_s, late_s=late_s)
            for one in self.contacts
        )

    def next_contact_s(self, at_s: float) -> float:
        """When contact is planned next; `at_s` itself while there is contact."""
        return min((contact.next_s(at_s) for contact in self.contacts), default=at_s)

    @property
    def _late_s(self) -> float:
        """The longest one-way delay."""
        return self.round_trip_s / 2

    @property
    def answer_s(self) -> float:
        """The time within which a query that is resent is answered, but for one in `ONE_IN`.

        Unannounced outages are not counted. 0 for a perfect link.
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
            if contact.for_s <= self._late_s:
                raise ValueError(
                    f"a contact of {contact.for_s:g} s is shorter than the delivery of a message, which takes up to "
                    f"{self._late_s:g} s"
                )
        return self

    @model_serializer(mode="wrap")
    def _as_written(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Only values that are set: the others default to the world's."""
        return {name: value for name, value in handler(self).items() if name in self.model_fields_set}
