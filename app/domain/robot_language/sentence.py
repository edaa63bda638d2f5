"""What a sentence or a line of ACL says, before its names are resolved."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum


@dataclass(frozen=True, slots=True, kw_only=True)
class Phrase:
    """A name as it was said, and where it stands in the text."""

    words: tuple[str, ...]
    span: tuple[int, int]

    @property
    def said(self) -> str:
        return " ".join(self.words)


class Dimension(StrEnum):
    """What an amount measures; the value is the ending of the parameters that it may set."""

    LENGTH = "_m"
    """Metres."""
    TIME = "_s"
    """Seconds."""
    ANGLE = "_rad"
    """Radians."""

    @property
    def words(self) -> str:
        """The unit in which a person says it."""
        return {Dimension.LENGTH: "metres", Dimension.TIME: "seconds", Dimension.ANGLE: "degrees"}[self]


@dataclass(frozen=True, slots=True, kw_only=True)
class Amount:
    """A number with its unit, in metres, seconds or radians."""

    value: float
    dimension: Dimension
    span: tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """One thing that the robot is to do.

    :param span: of the verb. :param end: where the command ends in the text.
    :param given: arguments by their names, as a line of ACL states them.
    :param is_acl: it is a line of ACL, in which what is missing is added as a field.
    """

    verb: str
    span: tuple[int, int]
    end: int
    object: Phrase | None = None
    target: Phrase | None = None
    amounts: tuple[Amount, ...] = ()
    given: Mapping[str, Phrase] = field(default_factory=dict)
    is_acl: bool = False


class Topic(StrEnum):
    """What a person may ask a robot; the values are the names of the terms that it answers."""

    SEEN = "seen"
    """What it sees now."""
    POSITION = "position"
    """Where it believes to be."""
    BATTERY = "battery"
    """The share of its charge that is left."""
    ACTIVITY = "activity"
    """What it is at."""
    HELD = "held"
    """What its jaws hold."""
    ABILITIES = "abilities"
    """The packets that it can carry out."""
    BELIEFS = "beliefs"
    """What its agents believe."""
    SEES = "sees"
    """Whether it sees something."""
    HOLDS = "holds"
    """Whether it holds something."""
    PLACE = "place"
    """Where it believes something to be."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """What the robot is asked; `about` a thing, or nothing."""

    topic: Topic
    about: Phrase | None = None


Said = tuple[Command, ...] | Question
