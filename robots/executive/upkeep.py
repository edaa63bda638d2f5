"""Upkeep (MACTA §3, the self level): a robot with a low battery and no script drives home and charges.

It does so by a script of its own, which is cancelled for any script of the service. Rules do the same where an agent
`charging` is on board (robots/deliberative/files/charging.rules); this is for robots without rules, which do without
their parser.
"""

from robots.executive.memory import UpkeepMemory
from robots.perception.percepts import Percepts
from robots.physical.profile import RobotProfile
from robots.repertoire import SelfLevel
from robots.wire import OWN, BehaviourPacket, BehaviourScript

PAUSE_S = 60.0
"""Between two attempts to charge."""
DRIVE_S = 300.0
CHARGE_S = 4 * 3600.0


class Upkeep:
    """Decides by the battery's charge when a robot seeks its charger, and whether it accepts a script."""

    def __init__(self, profile: RobotProfile, levels: SelfLevel) -> None:
        self._profile = profile
        self._levels = levels
        self.state = UpkeepMemory()

    def script(self, percepts: Percepts) -> BehaviourScript | None:
        """The script to run without any other; None if none is needed, or there is no home."""
        if self._profile.home is None or percepts.battery >= self._levels.low:
            return None
        began_s = self.state.began_s
        if percepts.charging or (began_s is not None and percepts.time_s < began_s + PAUSE_S):
            return None
        self.state.began_s = percepts.time_s
        self.state.count += 1
        return recharge(self._profile.name, self._profile.home, self.state.count)

    def refusal(self, percepts: Percepts | None, *, current_tag: str | None) -> str | None:
        """Why the battery is too low for a script; None if it is not, or not known. `current_tag`: the packet's."""
        needed = self._levels.needed
        if percepts is None or percepts.battery >= needed:
            return None
        activity = "rests" if current_tag is None else f"is at {current_tag}"
        if percepts.charging:
            activity = "charges"
        return f"{self._profile.name} {activity}, battery at {percepts.battery:.0%}: {needed:.0%} needed"


def drive_home(home: str, packet_id: str) -> BehaviourPacket:
    return BehaviourPacket(
        id=packet_id,
        tag="SEEK_CHARGER",
        arguments={"ref2": home},
        expected_start_s=0.0,
        expected_duration_s=30.0,
        timeout_s=DRIVE_S,
        wait_timeout_s=DRIVE_S,
    )


def recharge(robot: str, home: str, count: int) -> BehaviourScript:
    """The robot's own script to drive home and charge there."""
    packets = (
        drive_home(home, f"seek_charger_{count}"),
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
