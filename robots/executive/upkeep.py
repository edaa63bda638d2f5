"""What a robot does for its own sake (MACTA §3, the self level): with no script under way and its battery low, it
drives home and is charged. It does so by a script of packets like any other, which gives way to what the service asks.
"""

from robots.executive.memory import UpkeepMemory
from robots.perception.percepts import Percepts
from robots.physical.profile import RobotProfile
from robots.repertoire import SelfLevel
from robots.wire import OWN, BehaviourPacket, BehaviourScript

PAUSE_S = 60.0
"""A robot that could not charge tries again after this time."""
DRIVE_S, CHARGE_S = 300.0, 4 * 3600.0


class Upkeep:
    """Decides when a robot that has nothing to do seeks its charger, and whether it is fit for a script.

    Both by the battery's gauge, in shares of a full battery; before the first percepts nothing is decided.
    """

    def __init__(self, profile: RobotProfile, levels: SelfLevel) -> None:
        self._profile, self._levels = profile, levels
        self._began_s = float("-inf")
        self._count = 0

    def memory(self) -> UpkeepMemory:
        return UpkeepMemory(count=self._count, began_s=self._began_s if self._count else None)

    def recall(self, memory: UpkeepMemory) -> None:
        self._count = memory.count
        self._began_s = float("-inf") if memory.began_s is None else memory.began_s

    def script(self, percepts: Percepts) -> BehaviourScript | None:
        """What to do with nothing else to do; None if there is no need, or no home to go to."""
        if self._profile.home is None or percepts.battery >= self._levels.low:
            return None
        if percepts.charging or percepts.time_s < self._began_s + PAUSE_S:
            return None
        self._began_s = percepts.time_s
        self._count += 1
        return recharge(self._profile.name, self._profile.home, self._count)

    def refusal(self, percepts: Percepts | None, *, under_way: str | None) -> str | None:
        """Why the robot is too weak for a script; None if it is not. `under_way`: the packet it is at."""
        needed = self._levels.needed
        if percepts is None or percepts.battery >= needed:
            return None
        does = "charges" if percepts.charging else "rests" if under_way is None else f"is at {under_way}"
        return f"{self._profile.name} {does}, battery at {percepts.battery:.0%}: {needed:.0%} needed"


def recharge(robot: str, home: str, count: int) -> BehaviourScript:
    """The robot's own script to drive home and be charged there."""
    packets = (
        BehaviourPacket(
            id=f"seek_charger_{count}",
            tag="SEEK_CHARGER",
            arguments={"ref2": home},
            expected_start_s=0.0,
            expected_duration_s=30.0,
            timeout_s=DRIVE_S,
            wait_timeout_s=DRIVE_S,
        ),
        BehaviourPacket(
            id=f"charge_{count}",
            tag="CHARGE",
            arguments={},
            expected_start_s=30.0,
            expected_duration_s=CHARGE_S / 2,
            timeout_s=CHARGE_S,
            wait_timeout_s=DRIVE_S,
        ),
    )
    return BehaviourScript(id=f"{OWN}:{count}", mission_id=OWN, robot=robot, packets=packets)
