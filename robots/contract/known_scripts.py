"""What a robot remembers of scripts: their states, and which must not be started although they may still arrive."""

from collections import OrderedDict
from collections.abc import Mapping
from typing import TypeVar

from robots.contract.memory import StaleMemory
from robots.errors import RobotError
from robots.wire import OWN, BehaviourScript, ScriptState

T = TypeVar("T")

ENDED = (ScriptState.FINISHED, ScriptState.FAILED, ScriptState.CANCELLED)
TRANSITIONS: Mapping[ScriptState | None, frozenset[ScriptState]] = {
    None: frozenset({ScriptState.ACCEPTED, ScriptState.CANCELLED}),
    ScriptState.ACCEPTED: frozenset({ScriptState.RUNNING, ScriptState.PAUSED, *ENDED})
    - {ScriptState.FINISHED},
    ScriptState.RUNNING: frozenset({ScriptState.RUNNING, ScriptState.PAUSED, *ENDED}),
    ScriptState.PAUSED: frozenset({ScriptState.RUNNING, ScriptState.FAILED, ScriptState.CANCELLED}),
}
"""The states that may follow each state; None for a script that is not known. Nothing follows an end."""
REMEMBERED = 1024
"""The newest scripts and missions that are remembered."""


class ScriptStates:
    """The state of each of the last scripts, the newest noted last."""

    def __init__(self) -> None:
        self._states: OrderedDict[str, ScriptState] = OrderedDict()

    def __contains__(self, script_id: str) -> bool:
        return script_id in self._states

    def of(self, script_id: str) -> ScriptState | None:
        """None for a script that is not known."""
        return self._states.get(script_id)

    def note(self, script_id: str, state: ScriptState) -> None:
        """:raises RobotError: if the state may not follow the script's present one."""
        before = self.of(script_id)
        if state not in TRANSITIONS.get(before, frozenset()):
            raise RobotError(f"script {script_id} cannot become {state}: it is {before or 'not known'}")
        remember(self._states, script_id, state)

    def memory(self) -> dict[str, ScriptState]:
        return dict(self._states)

    def recall(self, states: Mapping[str, ScriptState]) -> None:
        self._states = OrderedDict(states)

    def why_not_active(self, script_id: str) -> str:
        """Why a script that is not active cannot be changed, in words."""
        known = self.of(script_id)
        return f"script {script_id} has ended: {known}" if known else f"no script {script_id} here"


class StaleScripts:
    """Ids of scripts that were cancelled before they arrived, and the newest revision of each mission."""

    def __init__(self) -> None:
        self._cancelled: OrderedDict[str, None] = OrderedDict()
        self._revisions: OrderedDict[str, int] = OrderedDict()

    def memory(self) -> StaleMemory:
        return StaleMemory(cancelled=tuple(self._cancelled), revisions=dict(self._revisions))

    def recall(self, memory: StaleMemory) -> None:
        self._cancelled = OrderedDict.fromkeys(memory.cancelled)
        self._revisions = OrderedDict(memory.revisions)

    def cancel(self, script_id: str) -> None:
        """Refuse the script if it still arrives."""
        remember(self._cancelled, script_id, None)

    def refusal(self, script: BehaviourScript) -> str | None:
        """Why a script that has just arrived must not be started; None if it may."""
        if script.id in self._cancelled:
            return f"stale: script {script.id} was cancelled before it arrived"
        newest = self._revisions.get(script.mission_id, 0)
        if script.revision < newest:
            mission = script.mission_id
            return f"stale: script {script.id} is superseded by revision {newest} of mission {mission}"
        if script.mission_id != OWN and script.revision:
            remember(self._revisions, script.mission_id, script.revision)
        return None


def supersedes(script: BehaviourScript, other: BehaviourScript | None) -> bool:
    """True if `script` is a later revision of the other one's mission."""
    return other is not None and script.mission_id == other.mission_id and script.revision > other.revision


def remember(known: OrderedDict[str, T], key: str, value: T, at_most: int = REMEMBERED) -> None:
    """Note a value as the newest; the oldest is dropped when there are too many."""
    known[key] = value
    known.move_to_end(key)
    if len(known) > at_most:
        known.popitem(last=False)
