"""What robots do when a mishap happens: one robot brings a sample, or two bring a long one.

The scripts are written by hand, with timeouts as the mission organiser would give: four times the expected duration of
a packet.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from benchmarks.errands import Leg, script
from benchmarks.relocation import FROM, THING, TO, scripts
from robots.wire import BehaviourScript
from robots.world import WorldFile, load_world

CARRIER, PARTNERS = "yard_1", ("fred", "ginger")
PACKET_S, WAIT_S = 40.0, 60.0
"""Timeouts for packets of ten seconds."""
JOINT_S, JOINT_WAIT_S = 180.0, 240.0
"""TRANSPORT by two takes 45 s, and the second to dock waits until its partner has docked."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Undertaking:
    """Scripts that bring a sample from `start` to `goal`, in a world of their own."""

    world: WorldFile
    scripts: Sequence[BehaviourScript]
    sample: str
    start: str
    goal: str

    @property
    def limit_s(self) -> float:
        """All of its packets' timeouts together: by then every script has ended."""
        return max(sum(p.timeout_s + p.wait_timeout_s for p in one.packets) for one in self.scripts)


@cache
def errand() -> Undertaking:
    """A yard robot of the sample store, alone, carries a sample from a door to an interchange."""
    sample, start, goal = "sample_1", "door_1", "interchange_2"
    work = script(Leg(robot=CARRIER, fetch=start, deposit=goal), sample, handed_over=False)
    world = load_world("sample_store").model_dump()
    kept = [robot for robot in world["robots"] if robot["name"] == CARRIER]
    return Undertaking(
        world=WorldFile.model_validate({**world, "robots": kept}),
        scripts=(_limited(work, {}),),
        sample=sample,
        start=start,
        goal=goal,
    )


@cache
def relocation() -> Undertaking:
    """Fred and Ginger bring the rock sample from the quarry to the lander between them."""
    return Undertaking(
        world=load_world("relocation_lab"),
        scripts=tuple(_limited(one, {"TRANSPORT": JOINT_S}, JOINT_WAIT_S) for one in scripts(*PARTNERS)),
        sample=THING,
        start=FROM,
        goal=TO,
    )


def _limited(
    work: BehaviourScript, timeouts_s: Mapping[str, float], wait_timeout_s: float = WAIT_S
) -> BehaviourScript:
    packets = [
        one.model_copy(
            update={"timeout_s": timeouts_s.get(one.tag, PACKET_S), "wait_timeout_s": wait_timeout_s}
        )
        for one in work.packets
    ]
    return work.model_copy(update={"packets": tuple(packets)})
