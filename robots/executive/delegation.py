"""When a packet of a script has failed, its leg may be done by another robot, if the script names robots for that.

The executive's part: which leg that is, and what it keeps of it. Whom it asks is the social level's concern.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from robots.perception.percepts import GRIP, Percepts
from robots.wire import OWN, BehaviourPacket, BehaviourScript, DelegableLeg, PacketState

if TYPE_CHECKING:
    from robots.executive.packet_run import PacketRun

AWARDED = f"{OWN}:awarded:"
"""Begins the ids of the scripts by which a robot does legs of others."""
ASIDE = f"{OWN}:aside:"
"""Begins the ids of the scripts by which a robot makes way for another."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DelegatedLeg:
    """A leg that is put to others, of this robot's script. `why`: how its packet failed, in words."""

    script_id: str
    leg: DelegableLeg
    packets: Sequence[BehaviourPacket]
    why: str


def is_awarded(script: BehaviourScript | None) -> bool:
    """True for a script by which the robot does another one's leg."""
    return script is not None and script.id.startswith(AWARDED)


def to_delegate(
    script: BehaviourScript, runs: "Sequence[PacketRun]", failed: "PacketRun", percepts: Percepts | None
) -> DelegableLeg | None:
    """The leg whose packet has failed, if another robot can begin it; None if there is none.

    The robot holds nothing and has moved nothing of it: none of the leg's packets that have ended moves the jaws. What
    fails because it has waited for other robots in vain would fail for another robot, too. What the other takes or
    notices reaches nobody: it reports no packets, so none of the leg brings results or tells facts by its events.
    """
    leg = next((one for one in script.delegable if failed.packet.id in one.packets), None)
    if leg is None or percepts is None:
        return None
    holds = percepts.holding if percepts.data.holds(GRIP) else percepts.last_held
    ended = [run for run in runs if run.packet.id in leg.packets and run.state is PacketState.FINISHED]
    has_waited = not failed.has_begun and bool(failed.packet.awaits or failed.packet.after)
    is_told = any(run.content.results or run.packet.events for run in runs if run.packet.id in leg.packets)
    if holds is not None or has_waited or is_told or any(run.moves_jaws for run in ended):
        return None
    return leg


def packets_of(script: BehaviourScript, leg: DelegableLeg) -> tuple[BehaviourPacket, ...]:
    """The leg's packets, in the script's order."""
    return tuple(packet for packet in script.packets if packet.id in leg.packets)
