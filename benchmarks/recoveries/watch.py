"""Observes the radios of a world's robots: when packets run, and which robots have ended their scripts."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from robots.wire import (
    Acknowledgement,
    BehaviourScript,
    Message,
    PacketReport,
    PacketState,
    ScriptReport,
    ScriptRequest,
)
from robots.world import LinkSpec
from sim.world.radio import Direction, Radio


@dataclass(slots=True, kw_only=True)
class RobotWatch:
    """One robot's state by its messages. `begun_s`: tag of the running packet → when it began."""

    scripts: dict[str, BehaviourScript] = field(default_factory=dict)
    at_work: set[str] = field(default_factory=set)
    begun_s: dict[str, float] = field(default_factory=dict)

    def sent(self, message: Message) -> None:
        """Note a message to the robot."""
        if isinstance(message.body, ScriptRequest):
            self.scripts[message.body.script.id] = message.body.script

    def said(self, message: Message) -> None:
        """Note a message from the robot."""
        match message.body:
            case Acknowledgement(script_id=script_id) if message.in_reply_to == f"{script_id}:request":
                self.at_work.add(script_id)
            case ScriptReport(script_id=script_id):
                self.at_work.discard(script_id)
            case PacketReport() as report:
                self._note(report)

    def _note(self, report: PacketReport) -> None:
        tag = next(
            packet.tag for packet in self.scripts[report.script_id].packets if packet.id == report.packet_id
        )
        if report.state is PacketState.RUNNING:
            self.begun_s.setdefault(tag, report.at_s)
        else:
            self.begun_s.pop(tag, None)


class WatchedRadio(Radio):
    """A radio that is observed and can be broken: then no message passes."""

    def __init__(self, link: LinkSpec, *, robot: str, seed: int) -> None:
        super().__init__(link, robot=robot, seed=seed)
        self.watch, self.broken = RobotWatch(), False

    def send(self, way: Direction, message: Message, now_s: float) -> None:
        if way is Direction.DOWN:
            self.watch.sent(message)
        else:
            self.watch.said(message)
        super().send(way, message, now_s)

    def in_contact(self, at_s: float) -> bool:
        return not self.broken and super().in_contact(at_s)


Radios = Mapping[str, WatchedRadio]
