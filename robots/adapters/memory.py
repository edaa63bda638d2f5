"""What a robot that is driven packet by packet remembers over restarts. All is JSON data."""

from typing import Any

from pydantic import ConfigDict, Field

from robots.contract.memory import MailboxMemory, StaleMemory
from robots.data import Checked, Memory
from robots.wire import BehaviourScript, Factsheet, FailureCategory, PacketState, ScriptState


class Stop(Checked):
    """Why the packet that was begun is being cancelled.

    `ends`: the state that the script gets once the robot stands. A packet that finishes meanwhile has finished; if its
    time was over (`ends` failed), the script goes on.
    """

    ends: ScriptState
    category: FailureCategory
    detail: str


class RunMemory(Memory):
    """A script and its progress.

    `index`: of the current packet, `state`: its state without pauses; `begun`: the driver was, or is about to be, given
    it; `told_running`: that it runs was reported; `order`: the newest order's number (0: none); `ended`: the actions
    that have ended, by clearances; `silent`: it reports nothing, because its run of the world is over.
    """

    script: BehaviourScript
    index: int = Field(default=0, ge=0)
    state: PacketState = PacketState.WAITING
    begun: bool = False
    told_running: bool = False
    paused: bool = False
    waited_s: float = 0.0
    ran_s: float = 0.0
    stop: Stop | None = None
    order: int = Field(default=0, ge=0)
    ended: frozenset[str] = frozenset()
    silent: bool = False


class ContractMemory(Checked):
    """The whole memory. `run`: the world's; `runs`: the current script, and the one that supersedes it; `verdicts`: by
    script, the reason of its refusal, None if it was accepted; `announced`: the last factsheet; `driver`: the driver's.

    Fields of other versions are ignored.
    """

    model_config = ConfigDict(extra="ignore")
    robot: str
    run: str = ""
    mailbox: MailboxMemory = MailboxMemory()
    runs: tuple[RunMemory, ...] = ()
    states: dict[str, ScriptState] = Field(default_factory=dict)
    verdicts: dict[str, str | None] = Field(default_factory=dict)
    stale: StaleMemory = StaleMemory()
    announced: Factsheet | None = None
    driver: dict[str, Any] = Field(default_factory=dict)
