"""Orders on scripts: to cancel, pause or resume. Each has a greater number than those before it, for they overtake
each other on their way to the robot.

The last one stands in the record until the robot has answered it; what the robot says of itself then is held against
what is wanted of it.
"""

from app.domain.states import TERMINAL_SCRIPTS, MissionState
from app.store import MissionRow, ScriptRow
from robots.wire import Control, ControlVerb, ScriptState


def give(script: ScriptRow, verb: ControlVerb) -> None:
    """Have the robot told, in place of any order that it has not answered yet."""
    script.orders += 1
    script.control = f"{verb.value}:{script.orders}"
    script.stopping = script.stopping or verb is ControlVerb.CANCEL


def unanswered(script: ScriptRow) -> Control | None:
    """The order that the robot has not answered yet."""
    if script.control is None:
        return None
    verb, number = script.control.split(":")
    return Control(script_id=script.id, verb=ControlVerb(verb), number=int(number))


def can_be_ordered(script: ScriptRow, mission: MissionRow) -> bool:
    """True if pausing and resuming concerns it. A script that is not agreed to yet is held back while the mission is
    paused; one that was told to stop is not told anything else any more.
    """
    if script.stopping or script.abandoned or script.plan_id != mission.plan_id:
        return False
    if MissionState(mission.state).ended:
        return False
    return script.state not in TERMINAL_SCRIPTS and script.delivery == "acknowledged"


def insist(script: ScriptRow, mission: MissionRow) -> None:
    """Order anew if the robot has answered its orders and yet stands otherwise than its mission does."""
    if script.control is not None or not can_be_ordered(script, mission):
        return
    stands, should = script.state == ScriptState.PAUSED, mission.state == MissionState.PAUSED
    if stands != should:
        give(script, ControlVerb.PAUSE if should else ControlVerb.RESUME)
