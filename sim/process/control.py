"""Commands and answers on the control channel of a world's process."""

from dataclasses import dataclass
from typing import Protocol

from robots.executive.breakpoints import Debugging
from sim.truth import Truth


@dataclass(frozen=True, slots=True)
class AskTruth:
    """Answered with a `Truth`."""


@dataclass(frozen=True, slots=True)
class Pause:
    """Pause the world, or let it continue. Answered with `Done`."""

    paused: bool


@dataclass(frozen=True, slots=True)
class BreakAt:
    """Set the breakpoints of a robot's rules, "guard:3" and the like. Answered with `Debugging`."""

    robot: str
    rules: frozenset[str]


@dataclass(frozen=True, slots=True)
class GoOn:
    """Let a world that stands at a breakpoint go on, or make one control cycle and stand again. Answered likewise."""

    one_cycle: bool


@dataclass(frozen=True, slots=True)
class AskDebugging:
    """Answered with `Debugging`."""


@dataclass(frozen=True, slots=True)
class Stop:
    """End the process. Not answered."""


@dataclass(frozen=True, slots=True)
class Done:
    """The command is carried out."""


@dataclass(frozen=True, slots=True)
class Starting:
    """What the process is doing before it is ready; sent if that takes time."""

    doing: str


@dataclass(frozen=True, slots=True)
class Ready:
    """The process has built the world: its run, its robots, whether it was resumed from a snapshot, and if one was
    expected, why not.
    """

    run: str
    robots: tuple[str, ...]
    is_resumed: bool
    not_resumed_because: str = ""


@dataclass(frozen=True, slots=True)
class Failed:
    """The world could not be built, broke, or refused a command."""

    reason: str


Command = AskTruth | Pause | BreakAt | GoOn | AskDebugging | Stop
Answer = Done | Starting | Ready | Failed | Truth | Debugging


class SharedNumber(Protocol):
    """A number shared between two processes without a lock."""

    value: float
