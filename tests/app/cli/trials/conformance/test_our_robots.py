"""The robots that keep the contract with our own software break none of its rules."""

from collections.abc import Sequence

from app.cli.trials.conformance.check import CheckRequest, RobotCheck
from app.cli.trials.conformance.line import RUN, Line
from app.cli.trials.conformance.rules import Verdict
from robots.adapters import ContractRobot, PacketForm
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.link.mqtt.robot_sessions import presence, robot_publication
from robots.link.mqtt.session import Publication
from robots.link.mqtt.topics import ConnectionState
from robots.wire import Factsheet, Message
from tests.robots.adapters.foreign_robot import Driver, Machine

SHEET = Factsheet(repertoire=("NAVIGATE",), speed_m_s=0.5, turn_rad_s=1.0)


class OurRobot:
    """A `ContractRobot` at the other end of the check's line, and of its relay, in time that is stepped."""

    address = "in memory"

    def __init__(self) -> None:
        self._is_cut = False
        near, self._far = InMemoryLink.pair()
        self._clock = ManualClock()
        self._machine = Machine()
        self._out = [presence("check", "fred", ConnectionState.ONLINE)]
        self._robot = ContractRobot(
            "fred",
            driver=Driver(self._machine),
            packets={"NAVIGATE": PacketForm()},
            link=near,
            clock=self._clock,
            factsheet=SHEET,
            run=RUN,
        )

    def now_s(self) -> float:
        return self._clock.now_s()

    def publish(self, publication: Publication) -> None:
        if publication.run == RUN and not self._is_cut:  # as robots' ends of the link do
            self._far.send(Message.model_validate_json(publication.payload))

    def receive(self, timeout_s: float) -> Sequence[Publication]:
        self._clock.advance(timeout_s)
        self._machine.step(timeout_s)
        self._robot.tick()
        said = [] if self._is_cut else self._far.receive()
        if self._is_cut:
            self._far.receive()  # it is lost
        arrived = self._out + [robot_publication("check", one, RUN) for one in said]
        self._out = []
        return arrived

    def cut(self) -> int:
        self._is_cut = True
        self._out.append(presence("check", "fred", ConnectionState.CONNECTION_BROKEN))
        return 1

    def restore(self) -> None:
        self._is_cut = False
        self._out.append(presence("check", "fred", ConnectionState.ONLINE))


def test_a_contract_robot_breaks_no_rule() -> None:
    robot = OurRobot()
    found = RobotCheck(Line(robot, "check", "fred"), CheckRequest(), relay=robot).run()
    assert [one for one in found if one.verdict is not Verdict.KEPT] == []
