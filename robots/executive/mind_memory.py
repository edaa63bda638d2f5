"""What a robot's deliberative level restores after a power failure, or in another program. All is JSON data."""

from typing import Annotated, Any, Literal

from pydantic import Field

from robots.data import Checked
from robots.wire import ToldMessage


class OutcomeMemory(Checked):
    """How an action has ended; `dropped`: the reason why it was given up, None if it was not."""

    is_fulfilled: bool
    words: str = ""
    dropped: str | None = None


class AttemptMemory(Checked):
    """A packet that an agent has begun, by the robot's own script for it; `outcome`: None while it runs."""

    script_id: str
    outcome: OutcomeMemory | None = None


class PlainStep(Checked):
    """A step of which nothing is kept: it ends at once, or only waits for conditions."""

    kind: Literal["plain"] = "plain"


class DelayStep(Checked):
    """`until_s`: None before it was begun."""

    kind: Literal["delay"] = "delay"
    until_s: float | None = None


class PacketStep(Checked):
    """`attempt`: None while it waits for the robot's body."""

    kind: Literal["packet"] = "packet"
    attempt: AttemptMemory | None = None


class TurnStep(Checked):
    """Steps of a SEQ or OR: how many come after the current one, and how far that is; None: the next is to begin."""

    kind: Literal["turn"] = "turn"
    left: int = Field(ge=0)
    current: "StepMemory | None" = None


class ParallelStep(Checked):
    """Steps of a PAR that have not ended, by their number, and the first outcome that was no success."""

    kind: Literal["parallel"] = "parallel"
    runs: "dict[int, StepMemory]"
    worst: OutcomeMemory | None = None


class ChosenStep(Checked):
    """A choice between plans. `begun_s`: since when it waits; `tried`: by number and bindings, as text; `failed`: which
    have failed and why; `plan`, `bindings`, `current`: the plan under way, None: none is; `words`: how it was chosen.

    `has_begun`, `is_granted`, `keeps`: whether its claim on the body has begun a packet, has it next, or keeps it.
    """

    kind: Literal["chosen"] = "chosen"
    begun_s: float | None = None
    tried: tuple[tuple[int, str], ...] = ()
    failed: tuple[str, ...] = ()
    plan: int | None = None
    bindings: dict[str, Any] = Field(default_factory=dict)
    key: tuple[int, str] = (-1, "")
    current: "StepMemory | None" = None
    words: str = ""
    has_begun: bool = False
    is_granted: bool = False
    keeps: bool = False


StepMemory = Annotated[
    PlainStep | DelayStep | PacketStep | TurnStep | ParallelStep | ChosenStep, Field(discriminator="kind")
]
"""How far a step of a commitment was carried out."""
TurnStep.model_rebuild()
ParallelStep.model_rebuild()
ChosenStep.model_rebuild()


class CommitmentMemory(Checked):
    """A commitment that has not ended: `rule` by its number, and the values of that rule's variables (`key`).

    `run`: how far its actions are, None before its time.
    """

    rule: int = Field(ge=0)
    key: tuple[Any, ...] = ()
    number: int
    towards: str
    made_s: float
    due_s: float
    words: str = ""
    run: StepMemory | None = None


class BeliefMemory(Checked):
    """A belief as the store holds it; `term` as `robots.deliberative.stored` writes it."""

    term: Any
    origin: str
    source: str = ""
    since_s: float
    words: str = ""


class AgentMemory(Checked):
    """An agent between two cycles: its beliefs, oldest first, and commitments, oldest first.

    `settled`: the rules that hold, with the values of their variables, and have made their commitments; `held`:
    likewise those that a breakpoint holds back; `events`: beliefs that end with the next cycle; `intended`: terms to
    adopt (True) or retract in it, and for what rule; `outcomes`: events of it; `sensed`: what
    perceptors read last, with words; `known`: what the robot knew of itself; `count`: of its commitments so far.
    """

    beliefs: tuple[BeliefMemory, ...] = ()
    commitments: tuple[CommitmentMemory, ...] = ()
    settled: tuple[tuple[int, tuple[Any, ...]], ...] = ()
    held: tuple[tuple[int, tuple[Any, ...]], ...] = ()
    events: tuple[Any, ...] = ()
    intended: tuple[tuple[Any, bool, str], ...] = ()
    outcomes: tuple[Any, ...] = ()
    sensed: tuple[tuple[Any, str], ...] = ()
    known: tuple[Any, ...] = ()
    count: int = 0


class SharedBodyMemory(Checked):
    """What agents share: `count` of own scripts so far, and the last one that an agent of this `rank` has begun."""

    count: int = 0
    running: AttemptMemory | None = None
    rank: int = 0


class HeardMemory(Checked):
    """What was said to the robot's rules and is not believed yet."""

    performative: str
    other: str
    content: Any


class MindMemory(Checked):
    """What the deliberative level restores after a power failure: rule files by name, with their version, the role that
    the robot plays, and what agents have adopted as beliefs and have retracted of what they believed at first, by the
    agent's name, as written in a rule file. Commitments are not kept.

    A mind that is handed over to another program has `agents`, by name, with all that they believe and are committed
    to; what was said to them and waits (`heard`); and what was told of that (`told`).
    """

    version: int = 0
    files: dict[str, str] = Field(default_factory=dict)
    role: str = ""
    beliefs: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    retracted: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    agents: dict[str, AgentMemory] | None = None
    body: SharedBodyMemory = SharedBodyMemory()
    heard: tuple[HeardMemory, ...] = ()
    told: tuple[ToldMessage, ...] = ()
