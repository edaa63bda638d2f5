"""What a world's process is asked and answers on its control channel; between our own two processes only."""

from dataclasses import dataclass
from typing import Protocol

from sim.truth import Truth


@dataclass(frozen=True, slots=True)
class AskTruth:
    """The answer is a `Truth`."""


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """World seconds a wall second; None is flat out. Answered with `Done`."""

    speed: float | None


@dataclass(frozen=True, slots=True)
class Pause:
    """Let the world stand still, or go on. Answered with `Done`."""

    paused: bool


@dataclass(frozen=True, slots=True)
class Stop:
    """Not answered: the process ends."""


@dataclass(frozen=True, slots=True)
class Done:
    """The command is carried out."""


@dataclass(frozen=True, slots=True)
class Ready:
    """The first word of a world: its run, and why it begins afresh where it might have gone on."""

    run: str
    why_afresh: str = ""


@dataclass(frozen=True, slots=True)
class Failed:
    """The world could not be built, broke, or refused a command."""

    reason: str


Command = AskTruth | SetSpeed | Pause | Stop
Answer = Done | Ready | Failed | Truth


class Gauge(Protocol):
    """A number shared between two processes without a lock."""

    value: float
