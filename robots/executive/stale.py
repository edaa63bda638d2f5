"""Scripts that must not be begun any more, though they may yet arrive: cancelled in advance, or superseded."""

from collections import OrderedDict
from typing import TypeVar

from robots.executive.memory import StaleMemory
from robots.wire import OWN, BehaviourScript

T = TypeVar("T")
REMEMBERED = 1024
"""Scripts and missions that are remembered, the newest; late letters are not that late."""


class StaleScripts:
    """What a robot was told of scripts that it does not have: ids that were cancelled, missions' newest revisions."""

    def __init__(self) -> None:
        self._cancelled: OrderedDict[str, None] = OrderedDict()
        self._revisions: OrderedDict[str, int] = OrderedDict()

    def memory(self) -> StaleMemory:
        return StaleMemory(cancelled=tuple(self._cancelled), revisions=dict(self._revisions))

    def recall(self, memory: StaleMemory) -> None:
        self._cancelled = OrderedDict.fromkeys(memory.cancelled)
        self._revisions = OrderedDict(memory.revisions)

    def cancel(self, script_id: str) -> None:
        """It is not to be carried out should it still come."""
        _note(self._cancelled, script_id, None)

    def refusal(self, script: BehaviourScript) -> str | None:
        """Why this script, which has just come, is not to be begun; None if it is the newest word."""
        if script.id in self._cancelled:
            return f"stale: script {script.id} was cancelled before it arrived"
        newest = self._revisions.get(script.mission_id, 0)
        if script.revision < newest:
            mission = script.mission_id
            return f"stale: script {script.id} is superseded by revision {newest} of mission {mission}"
        if script.mission_id != OWN and script.revision:
            _note(self._revisions, script.mission_id, script.revision)
        return None


def supersedes(script: BehaviourScript, other: BehaviourScript | None) -> bool:
    """True if it is a later script of the same mission."""
    return other is not None and script.mission_id == other.mission_id and script.revision > other.revision


def _note(known: OrderedDict[str, T], key: str, value: T) -> None:
    known[key] = value
    known.move_to_end(key)
    if len(known) > REMEMBERED:
        known.popitem(last=False)
