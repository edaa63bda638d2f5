"""Reports of finished scripts that may still come and show whether robots have waited for their clearance.

A robot has waited if its packet began after the action that it waits for had ended. Where the reports of the two do not
tell that, the robot's order of packets may: a packet begins after the one before it. A robot that reports only ends
sends nothing more.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from app.domain.contradictions import CLOCKS_S, HELD_S
from app.missions.clearance import packets_of
from app.store import ScriptRow
from robots.wire import PacketState, ScriptState

Known = Mapping[str, Any]


def unheard_s(scripts: Sequence[ScriptRow], now_s: float) -> Mapping[str, float]:
    """By robot, the world seconds for which such reports of it may still come; robots that owe none are left out.

    :param scripts: all of one plan.
    """
    owing = {robot for script in scripts for robot in _owing(script, scripts, now_s)}
    left_s = {
        script.robot: script.heard_at_s + HELD_S - now_s
        for script in scripts
        if script.robot in owing and script.heard_at_s is not None and script.state == ScriptState.FINISHED
    }
    return {robot: left for robot, left in left_s.items() if left > 0}


def _owing(script: ScriptRow, scripts: Sequence[ScriptRow], now_s: float) -> Iterator[str]:
    """The robots whose reports are missing to tell whether the script's robot has waited."""
    for index, packet in enumerate(script.body["packets"]):
        known = script.packets.get(packet["id"], {})
        for action in packet.get("after", ()):
            least_s = _least_begin_s(script, index)
            for other in scripts:
                ended = other.packets.get(action, {})
                is_doer = action in packets_of(other)
                if not is_doer or (least_s is not None and _is_over(ended, least_s)):
                    continue
                if "started_at_s" not in known and _reports_beginnings(script, now_s):
                    yield script.robot
                if ended.get("implied", False):
                    yield other.robot


def _least_begin_s(script: ScriptRow, index: int) -> float | None:
    """A time before which the packet has not begun, by its robot's own reports."""
    known = script.packets.get(script.body["packets"][index]["id"], {})
    if "started_at_s" in known:
        return float(min(known["started_at_s"], known.get("claimed_at_s", known["started_at_s"])))
    before = (script.packets.get(packet["id"], {}) for packet in script.body["packets"][:index])
    return max(
        (one["at_s"] for one in before if "at_s" in one and not one.get("implied", False)), default=None
    )


def _is_over(ended: Known, at_s: float) -> bool:
    """True if a part had ended by then. One whose end follows from that of its script ended no later than that."""
    return ended.get("state") == PacketState.FINISHED and bool(ended["finished_at_s"] - at_s <= CLOCKS_S)


def _reports_beginnings(script: ScriptRow, now_s: float) -> bool:
    """False if a packet's end was reported so long ago that the report of its beginning would have come as well."""
    known = [script.packets.get(packet, {}) for packet in packets_of(script)]
    if any("started_at_s" in one for one in known):
        return True
    ends = [one["finished_at_s"] for one in known if "finished_at_s" in one and not one.get("implied", False)]
    return not any(now_s - end_s >= HELD_S for end_s in ends)
