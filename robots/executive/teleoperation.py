"""Teleoperation (SRA: remote control): an operator drives the robot by a packet of the robot's own.

The robot itself decides who drives it, so the rules hold however many services send set-points: one driver at a time,
only while it has no script but its own, at limited speed, and never for longer than the last set-point is valid. An
accepted script ends the drive.
"""

from robots.conditions.facts import perceived
from robots.executive.executive import Executive
from robots.perception.percepts import DriveCommand, Percepts
from robots.physical.geometry import clip
from robots.physical.profile import RobotProfile
from robots.repertoire.parameters import MAX_VELOCITY
from robots.wire import OWN, BehaviourPacket, BehaviourScript, PacketState, SetPoint, UpkeepReport
from robots.wire.operator import MAX_SPEED_M_S, MAX_TURN_RAD_S, RELEASE_FACTOR

TELEOPERATE = "TELEOPERATE"
START_TIMEOUT_S = 3.0
DRIVE_TIMEOUT_S = 4 * 3600.0
STAND = DriveCommand()


class Teleoperation:
    """Who drives the robot, and the current command. Times are the robot's clock."""

    def __init__(self, profile: RobotProfile) -> None:
        self._profile = profile
        self._speed_m_s = min(MAX_SPEED_M_S, profile.speed_m_s)
        self._turn_rad_s = min(MAX_TURN_RAD_S, profile.turn_rad_s)
        self._last: SetPoint | None = None
        self._last_s = float("-inf")
        self._script_id: str | None = None
        self._last_driver: str | None = None
        """The driver whose drive ended last, and why it ended."""
        self._end_reason = ""

    @property
    def driver(self) -> str | None:
        """Who drives the robot; None if nobody does."""
        return self._last.driver if self._last is not None else None

    def follow(
        self, wanted: SetPoint, executive: Executive, now_s: float, *, low_battery: str | None
    ) -> str | None:
        """Drive by a set-point, or return the reason against it. One with an older number changes nothing.

        :param low_battery: why the battery is too low to start; None if it is not.
        """
        if (refusal := self._refusal(wanted, executive)) is not None:
            return refusal
        last = self._last
        if last is None:
            if wanted.ends:
                return None
            if (refusal := low_battery or self._start(wanted, executive, now_s)) is not None:
                return refusal
        elif wanted.number <= last.number:
            return None
        self._last = wanted
        self._last_s = now_s
        return None

    def is_late(self, sent_at_s: float, wanted: SetPoint, now_s: float) -> bool:
        """True if a set-point travelled for longer than the radio explains, as after an outage."""
        return now_s - sent_at_s > wanted.valid_s + self._profile.round_trip_s / 2

    def command(self, now_s: float) -> DriveCommand | None:
        """The current command: to stand once the last set-point is no longer valid; None if nobody drives."""
        last = self._last
        if last is None or last.ends or now_s - self._last_s > RELEASE_FACTOR * last.valid_s:
            return None
        if now_s - self._last_s > last.valid_s:
            return STAND
        forward = clip(last.speed_m_s / self._speed_m_s)
        left = clip(last.turn_rad_s / self._turn_rad_s) * self._turn_rad_s / self._profile.turn_rad_s
        return DriveCommand(forward, left)

    def settle(self, executive: Executive, percepts: Percepts | None, now_s: float) -> UpkeepReport | None:
        """Note that the drive has ended. A report if a script ended it; the packet reports any other end itself."""
        last = self._last
        script = executive.script
        if last is None or (script is not None and script.id == self._script_id):
            return None
        gave_way = executive.script_id != self._script_id
        detail = f"gave way to script {executive.script_id}" if gave_way else executive.end_reason
        self._last_driver = last.driver
        self._end_reason = detail or "released"
        self._last = None
        self._script_id = None
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

    def _refusal(self, wanted: SetPoint, executive: Executive) -> str | None:
        me = self._profile.name
        if wanted.driver == self._last_driver:
            return f"{me} is no longer driven: {self._end_reason}"
        if self.driver not in (None, wanted.driver):
            return f"{self.driver} drives {me}"
        if executive.script is not None and not executive.script.is_own:
            return f"{me} is busy with script {executive.script.id}"
        return None

    def _start(self, wanted: SetPoint, executive: Executive, now_s: float) -> str | None:
        packet = BehaviourPacket(
            id=f"teleoperate_{now_s:.2f}",
            tag=TELEOPERATE,
            arguments={"driver": wanted.driver, MAX_VELOCITY: str(self._speed_m_s)},
            expected_start_s=0.0,
            expected_duration_s=DRIVE_TIMEOUT_S,
            timeout_s=DRIVE_TIMEOUT_S,
            wait_timeout_s=START_TIMEOUT_S,
        )
        me = self._profile.name
        script = BehaviourScript(id=f"{OWN}:{packet.id}", mission_id=OWN, robot=me, packets=(packet,))
        refusal = executive.accept(script)
        if refusal is None:
            self._script_id = script.id
        return refusal
