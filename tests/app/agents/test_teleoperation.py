"""The numbers of set-points, of which a robot follows the greatest."""

from typing import cast

from app.agents.robot_board import RobotView
from app.agents.robot_directory import RobotDirectory, RobotReport
from app.agents.teleoperation import Teleoperation
from app.domain.contact import Connection
from robots.wire import Telemetry
from tests.app.stepped_clock import SteppedClock


class InContact:
    """A directory with one robot that may be driven."""

    def robot(self, name: str) -> RobotReport:
        view = RobotView(name=name, world="hall", telemetry=Telemetry(at_s=0, x_m=0, y_m=0, heading_rad=0))
        return RobotReport(
            view=view,
            kind="robot",
            state="",
            connection=Connection.ONLINE,
            last_heard_s=0.0,
            silent=False,
            next_contact_s=0.0,
            repertoire=(),
            senses=(),
            reach=(),
            mission_id=None,
            lost=None,
            out_of_service=None,
            unasked=None,
            impersonation=None,
            role=None,
            world_stands=False,
            body="simulated",
        )


def test_set_points_are_followed_though_the_wall_clock_is_set_back() -> None:
    clock = SteppedClock()
    teleoperation = Teleoperation(cast(RobotDirectory, InContact()), {"hall": lambda: 1.0}, wall=clock)
    numbers = []
    for back_s in (0.0, 3600.0, 0.0):
        clock.set_back(back_s)
        teleoperation.drive("fred", "ada", speed_m_s=0.1, turn_rad_s=0.0)
        numbers += [one.number for _, one in teleoperation.to_send(["fred"])]
    teleoperation.release("fred", "ada")
    numbers += [one.number for _, one in teleoperation.to_send(["fred"])]
    assert numbers == sorted(set(numbers))
    assert len(numbers) == 4


def test_a_process_that_begins_later_gives_greater_numbers() -> None:
    clock = SteppedClock()
    numbers = []
    for _ in range(2):
        teleoperation = Teleoperation(cast(RobotDirectory, InContact()), {"hall": lambda: 1.0}, wall=clock)
        teleoperation.drive("fred", "ada", speed_m_s=0.1, turn_rad_s=0.0)
        numbers += [one.number for _, one in teleoperation.to_send(["fred"])]
        clock.advance(0.001)
    assert numbers[0] < numbers[1]
