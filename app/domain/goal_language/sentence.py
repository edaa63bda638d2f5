"""The parts of a parsed sentence; names are still words."""

from dataclasses import dataclass, field
from enum import StrEnum


class Quantity(StrEnum):
    """How many of a kind a phrase means."""

    NAMED = "named"
    """The one of that name."""
    ALL = "all"
    """Every one: "every sample of aisle_1"."""
    COUNT = "count"
    """A number of them: "two samples"."""
    ANY = "any"
    """One that is free: "any bay"."""
    OTHER = "other"
    """Those that the sentence has not named before: "the other samples"."""


class Part(StrEnum):
    """The part that a phrase plays in its clause; the values are the grammar's names."""

    TARGET = "target"
    """After "to", "in", "at", "on"."""
    ORIGIN = "origin"
    """After "from"."""
    WITH = "with_robots"
    """After "with", "using"."""
    WITHOUT = "without_robots"
    """After "without", "not with"."""
    AVOIDING = "avoiding"
    """After "avoiding", "not through"."""
    THROUGH = "through"
    """After "through", "via": the interchanges that samples go through."""
    COST = "cost"
    """After "cost": the seconds that the preference before it is worth."""
    AFTER = "after"
    """After "after": a mission."""
    DUE = "due"
    """After "by", "before": a time of day."""
    WITHIN = "within"
    """After "in", "within": a span of time."""
    UNTIL = "until"
    """After "until": a time of day, a mission, a goal, or a fact."""
    LASTING = "lasting"
    """After "for": a span of time."""


LISTS = frozenset({Part.WITH, Part.WITHOUT, Part.AVOIDING, Part.THROUGH, Part.AFTER})
"""The parts whose names may be joined: "with yard_1 and yard_2"."""
PLACES = frozenset({Part.TARGET, Part.ORIGIN})
ENDS = frozenset({Part.UNTIL, Part.LASTING})
"""The parts that say until when something is kept as it is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Phrase:
    """A name, or a quantity of a kind.

    :param word_spans: where each of the words stands in the text.
    :param whole: the words after "of": "every sample of aisle_1"; `whole_span`: where they stand.
    :param span: start and end in the text; for what is not said, where it would be.
    """

    words: tuple[str, ...] = ()
    word_spans: tuple[tuple[int, int], ...] = ()
    quantity: Quantity = Quantity.NAMED
    count: int = 0
    whole: tuple[str, ...] = ()
    whole_word_spans: tuple[tuple[int, int], ...] = ()
    whole_span: tuple[int, int] = (0, 0)
    span: tuple[int, int] = (0, 0)

    @property
    def said(self) -> str:
        """The words as a name."""
        return "_".join(self.words)

    def of_whole(self) -> "Phrase | None":
        """The phrase after "of"; None if there is none."""
        if not self.whole:
            return None
        return Phrase(words=self.whole, word_spans=self.whole_word_spans, span=self.whole_span)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tail:
    """A phrase after a preposition.

    :param time: a time of day, "14:30".
    :param is_before: after "before", which may also name a mission.
    :param seconds: a span of time; `has_number`, `has_unit`: what is said of it.
    :param is_preferred: after "preferably"; `is_more`: another name of the tail before it: "without yard_1 and yard_2".
    :param place: of a fact: "sample_1 is in door_2"; None if none is said.
    :param says_is: "is" is said, of a fact or of a mission; `says_empty`: also "empty".
    """

    part: Part
    phrase: Phrase = Phrase()
    place: Phrase | None = None
    says_is: bool = False
    says_empty: bool = False
    has_number: bool = False
    has_unit: bool = False
    time: str = ""
    is_before: bool = False
    seconds: float = 0.0
    is_preferred: bool = False
    is_more: bool = False
    span: tuple[int, int] = (0, 0)


@dataclass(slots=True, kw_only=True)
class Clause:
    """A command, or a part of one that continues the clause before.

    :param verb: the verb's word; empty if none is said.
    :param agent: the robot that is to do it: "have rover_2 wait at base".
    :param first: the clause's first word, and where it stands.
    :param object_at: where its object would be said: after the verb.
    :param span: start and end in the text.
    :param is_keep: "keep bay_3 empty" or "keep sample_1 in bay_7"; `says_empty`: its last word is said.
    :param continues_keep: another thing that one "keep" keeps: "sample_2 in bay_3" after "keep sample_1 in bay_7".
    :param is_keep_on: "bay_4 empty", which continues one; `is_preferred`: "preferably keep bay_3 empty".
    :param stage: number of times that "then" stands before it.
    """

    verb: str = ""
    agent: Phrase | None = None
    first: str = ""
    first_span: tuple[int, int] = (0, 0)
    object_at: int = 0
    span: tuple[int, int] = (0, 0)
    objects: list[Phrase] = field(default_factory=list)
    tails: list[Tail] = field(default_factory=list)
    is_keep: bool = False
    is_keep_on: bool = False
    continues_keep: bool = False
    is_preferred: bool = False
    says_empty: bool = False
    stage: int = 0

    def object_or_gap(self) -> Phrase:
        """The first object; if none is said, a phrase without words where it would be."""
        return self.objects[0] if self.objects else Phrase(span=(self.object_at, self.object_at))

    def phrases(self, part: Part) -> list[Phrase]:
        """The phrases of the part, without those that are only preferred."""
        return [tail.phrase for tail in self.tails if tail.part is part and not tail.is_preferred]

    @property
    def says_end(self) -> bool:
        """True if it says until when something is kept as it is."""
        return any(tail.part in ENDS for tail in self.tails)

    @property
    def names_place(self) -> bool:
        return any(tail.part in PLACES for tail in self.tails)

    @property
    def keeps_facts(self) -> bool:
        """True if it keeps something where it is: "keep sample_1 in bay_7"."""
        return self.is_keep and not self.says_empty and any(tail.part is Part.TARGET for tail in self.tails)
