"""An operator drives the robot (SRA: remote control), as a packet of the robot's own whose task level is the wish.

The robot is the one that decides who drives it, so it holds however many services speak to it: one at a time, only
while it has no script but its own, slowly, and never for longer than the last set-point is valid. A script that comes
ends it.
"""

from robots.conditions.facts import perceived
from robots.executive.executive import Executive
from robots.perception.percepts import Percepts
from robots.perception.wish import Wish
from robots.physical.geometry import clip
from robots.physical.profile import RobotProfile
from robots.repertoire.parameters import MAX_VELOCITY
from robots.wire import OWN, BehaviourPacket, BehaviourScript, PacketState, SetPoint, UpkeepReport

TELEOPERATE = "TELEOPERATE"
MOST_M_S, MOST_RAD_S = 0.3, 1.0
"""No faster than this, whatever is wished: an operator sees late and sees little (our choice)."""
HELD = 6.0
"""A driver who says no more lets go after so many times what the last set-point was valid for."""
STARTS_WITHIN_S, ENDS_WITHIN_S = 3.0, 4 * 3600.0
STANDING = Wish()


class Teleoperation:
    """Who drives the robot now, and what he wishes. Times are the robot's clock."""

    def __init__(self, profile: RobotProfile) -> None:
        self._profile = profile
        self._speed_m_s = min(MOST_M_S, profile.speed_m_s)
        self._turn_rad_s = min(MOST_RAD_S, profile.turn_rad_s)
        self._last: SetPoint | None = None
        self._last_s = float("-inf")
        self._script_id: str | None = None
        self._over = ("", "")

    @property
    def driver(self) -> str | None:
        """Who drives it; None if nobody does."""
        return self._last.driver if self._last is not None else None

    def follow(
        self, wanted: SetPoint, executive: Executive, now_s: float, *, too_weak: str | None
    ) -> str | None:
        """Drive by a set-point, beginning if need be; or say why not. One that was overtaken changes nothing."""
        if (why_not := self._why_not(wanted, executive)) is not None:
            return why_not
        last = self._last
        if last is None:
            if wanted.ends:
                return None
            if (why_not := too_weak or self._begin(wanted, executive, now_s)) is not None:
                return why_not
        elif wanted.number <= last.number:
            return None
        self._last, self._last_s = wanted, now_s
        return None

    def is_late(self, sent_at_s: float, wanted: SetPoint, now_s: float) -> bool:
        """True if a set-point was under way for longer than the radio explains, as after an outage."""
        return now_s - sent_at_s > wanted.valid_s + self._profile.round_trip_s / 2

    def wish(self, now_s: float) -> Wish | None:
        """What is wished now: to stand, once the last set-point is valid no more; None if nobody drives."""
        last = self._last
        if last is None or last.ends or now_s - self._last_s > HELD * last.valid_s:
            return None
        if now_s - self._last_s > last.valid_s:
            return STANDING
        speed, turn = clip(last.speed_m_s / self._speed_m_s), clip(last.turn_rad_s / self._turn_rad_s)
        return Wish(speed, turn * self._turn_rad_s / self._profile.turn_rad_s)

    def settle(self, executive: Executive, percepts: Percepts | None, now_s: float) -> UpkeepReport | None:
        """Note that the drive has ended; a report if it gave way, for of its own end the packet tells itself."""
        last, script = self._last, executive.script
        if last is None or (script is not None and script.id == self._script_id):
            return None
        gave_way = executive.script_id != self._script_id
        detail = f"gave way to script {executive.script_id}" if gave_way else executive.ending
        self._over, self._last, self._script_id = (last.driver, detail or "let go"), None, None
        if not gave_way:
            return None
        return UpkeepReport(
            tag=TELEOPERATE,
            state=PacketState.FINISHED,
            at_s=now_s,
            perceived=perceived(percepts),
            detail=detail,
            driver=last.driver,
        )

    def _why_not(self, wanted: SetPoint, executive: Executive) -> str | None:
        me = self._profile.name
        if wanted.driver == self._over[0]:
            return f"{me} is driven no more: {self._over[1]}"
        if self.driver not in (None, wanted.driver):
            return f"{self.driver} drives {me}"
        if executive.script is not None and not executive.script.is_own:
            return f"{me} is busy with script {executive.script.id}"
        return None

    def _begin(self, wanted: SetPoint, executive: Executive, now_s: float) -> str | None:
        packet = BehaviourPacket(
            id=f"teleoperate_{now_s:.2f}",
            tag=TELEOPERATE,
            arguments={"driver": wanted.driver, MAX_VELOCITY: str(self._speed_m_s)},
            expected_start_s=0.0,
            expected_duration_s=ENDS_WITHIN_S,
            timeout_s=ENDS_WITHIN_S,
            wait_timeout_s=STARTS_WITHIN_S,
        )
        me = self._profile.name
        script = BehaviourScript(id=f"{OWN}:{packet.id}", mission_id=OWN, robot=me, packets=(packet,))
        why_not = executive.accept(script)
        if why_not is None:
            self._script_id = script.id
        return why_not
