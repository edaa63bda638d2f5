"""The radio link of a world: what it loses, how long it takes, and when there is contact at all."""

from collections.abc import Sequence
from math import ceil, log
from typing import Any, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from robots.data import Checked

ONE_IN = 100
"""Of so many exchanges one may take longer than `LinkSpec.answer_s` says."""
WORD_S = 0.2
"""A robot is taken to say something, if only telemetry, so often; in truth it is oftener."""
QUIET_S = 20.0
"""A silence so long is borne whatever the radio: outages come and go (our choice)."""
ONE_SILENCE_IN = 1_000_000
"""In so many silences one may be longer by loss alone than `LinkSpec.quiet_s` says."""
RESENT_S = 1.0
"""An unanswered message is sent again so long after its answer could have come (world's clock)."""


class Outage(Checked):
    """A time without contact that nobody knows of beforehand; every `every_s` seconds again, if given."""

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

    def next_s(self, at_s: float) -> float:
        """When there is contact next; `at_s` itself while there is."""
        if self.covers(at_s):
            return at_s
        return self.start_s + max(0.0, ceil((at_s - self.start_s) / self.every_s)) * self.every_s

    def covered_s(self, till_s: float, *, late_s: float) -> float:
        """How long there has been contact by then, of each time but the first `late_s` seconds."""
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
    def quiet_s(self) -> float:
        """After so long without a word in which one could have come, it is not the radio's doing any longer.

        That is the time in which loss does not let nothing through, but for one time in `ONE_SILENCE_IN`; and
        `QUIET_S`, or a whole contact where that is shorter.
        """
        words = ceil(log(1 / ONE_SILENCE_IN) / log(self.loss)) if self.loss > 0 else 1
        whole_s = min((contact.for_s - self._late_s for contact in self.contacts), default=QUIET_S)
        return max(words * WORD_S, min(whole_s, QUIET_S))

    def hearing_s(self, since_s: float, till_s: float) -> float:
        """For how much of a span of time a word could have come, as far as is known beforehand: not of outages."""
        if not self.contacts:
            return max(0.0, till_s - since_s)
        late_s = self._late_s
        return max(
            one.covered_s(till_s, late_s=late_s) - one.covered_s(since_s, late_s=late_s)
            for one in self.contacts
        )

    def next_contact_s(self, at_s: float) -> float:
        """When contact is expected next, as far as is known beforehand; `at_s` itself while it is."""
        return min((contact.next_s(at_s) for contact in self.contacts), default=at_s)

    @property
    def _late_s(self) -> float:
        """What is said when a contact begins comes so much later at the latest."""
        return self.round_trip_s / 2

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
            if contact.for_s <= self._late_s:
                raise ValueError(
                    f"a contact of {contact.for_s:g} s is over before a message has arrived, which takes up to "
                    f"{self._late_s:g} s"
                )
        return self

    @model_serializer(mode="wrap")
    def _as_written(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Only what is said, for what is left unsaid is the world's to say."""
        return {name: value for name, value in handler(self).items() if name in self.model_fields_set}
