"""The robots that keep the contract with our own software break none of its rules."""

from collections.abc import Sequence

from app.trials.conformance.check import CheckRequest, RobotCheck
from app.trials.conformance.line import RUN, Line
from app.trials.conformance.rules import Rule, Verdict
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
    """A `ContractRobot` at the other end of the check's line, in time that is stepped."""

    def __init__(self) -> None:
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
        if publication.run == RUN:  # as robots' ends of the link do
            self._far.send(Message.model_validate_json(publication.payload))

    def receive(self, timeout_s: float) -> Sequence[Publication]:
        self._clock.advance(timeout_s)
        self._machine.step(timeout_s)
        self._robot.tick()
        arrived = self._out + [robot_publication("check", one, RUN) for one in self._far.receive()]
        self._out = []
        return arrived


def test_a_contract_robot_breaks_no_rule() -> None:
    found = RobotCheck(Line(OurRobot(), "check", "fred"), CheckRequest()).run()
    assert [one for one in found if one.verdict is Verdict.BROKEN] == []
    assert {one.rule for one in found if one.verdict is Verdict.UNTRIED} == {Rule.RECONNECTS}
