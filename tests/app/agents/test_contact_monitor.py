"""When a robot's silence is more than its radio explains."""

import pytest

from app.agents.contact_monitor import ContactMonitor
from app.agents.robot_board import SILENT_AFTER_S, RobotBoard
from app.domain.contact import Connection
from robots.link.mqtt import ConnectionState
from robots.world import Contact, LinkSpec, Outage, WorldFile
from robots.world.radio import QUIET_S
from tests.app.stepped_clock import SteppedClock
from tests.robots.world.test_file import small

ORBIT = LinkSpec(contacts=(Contact(start_s=5.0, for_s=10.0, every_s=120.0),))


class Room:
    """A world with robots `left` and `right`, whose time goes `rate` times as fast as the wall clock."""

    def __init__(self, link: LinkSpec, *, rate: float = 1.0) -> None:
        file = WorldFile.model_validate(small(link=link.model_dump()))
        self._now_s = 0.0
        self._rate = rate
        self._wall = SteppedClock()
        clocks = {file.name: self}
        worlds = {file.name: file}
        self.board = RobotBoard.of(worlds, clocks=clocks, low_battery=0.0, wall=self._wall)
        self.hearing = ContactMonitor(self.board, clocks=clocks, worlds=worlds, wall=self._wall)

    def now_s(self) -> float:
        return self._now_s

    def advance(self, step_s: float) -> None:
        """Both clocks go on."""
        self._now_s += step_s
        self._wall.advance(step_s / self._rate)

    def wall_passes(self, seconds: float) -> None:
        """While the world's clock stands."""
        self._wall.advance(seconds)

    def set_wall_clock(self, back_s: float) -> None:
        """An administrator sets it back, or ahead."""
        self._wall.set_back(back_s)

    def connection(self) -> Connection:
        return self.board.view("left").connection(self._wall.monotonic_s())

    def restart(self) -> None:
        """The world's time begins again."""
        self._now_s = 0.0

    def hear(self) -> None:
        self.board.heard("left")

    def silent_at(self, till_s: float) -> float | None:
        """The first tenth of a second in which the silence is too long, if there is one."""
        while self._now_s < till_s:
            if self.hearing.silent_in_s("left") == 0:
                return round(self._now_s, 1)
            self.advance(0.1)
        return None


def test_in_contact_a_robot_counts_as_silent_after_what_loss_and_patience_explain() -> None:
    link = LinkSpec(loss=0.5)
    room = Room(link)
    room.advance(7.0)
    room.hear()
    assert room.silent_at(100.0) == pytest.approx(7.0 + link.quiet_s, abs=0.11)


def test_one_that_was_never_heard_is_given_as_long_from_the_beginning() -> None:
    assert Room(LinkSpec()).silent_at(100.0) == pytest.approx(LinkSpec().quiet_s, abs=0.11)


def test_between_windows_of_contact_nobody_is_silent_and_at_the_end_of_one_that_passed_without_a_message() -> (
    None
):
    room = Room(ORBIT)
    room.advance(14.9)
    room.hear()
    assert room.silent_at(400.0) == pytest.approx(135.0, abs=0.11)


def test_a_message_in_each_window_is_enough() -> None:
    room = Room(ORBIT)
    for window in range(5):
        assert room.silent_at(5.0 + 120.0 * window + 9.0) is None
        room.hear()


def test_what_was_heard_of_another_run_of_the_world_does_not_count() -> None:
    room = Room(LinkSpec())
    room.advance(500.0)
    room.hear()
    room.restart()
    assert room.silent_at(100.0) == pytest.approx(LinkSpec().quiet_s, abs=0.11)


def test_outages_explain_nothing_for_nobody_counts_on_them() -> None:
    room = Room(LinkSpec(outages=(Outage(start_s=0, end_s=1000),)))
    assert room.silent_at(100.0) == pytest.approx(LinkSpec().quiet_s, abs=0.11)


def test_a_robot_whose_simulated_world_stands_is_not_silent() -> None:
    room = Room(LinkSpec())
    room.hear()
    left_s = room.hearing.silent_in_s("left")
    room.wall_passes(600.0)
    assert room.hearing.silent_in_s("left") == left_s > 0


def test_however_fast_the_world_runs_a_robot_is_given_some_seconds_of_the_wall_clock() -> None:
    room = Room(LinkSpec(), rate=50.0)
    assert room.silent_at(1000.0) == pytest.approx(50.0 * SILENT_AFTER_S, abs=0.11)


@pytest.mark.parametrize("back_s", [3600.0, -3600.0])
def test_a_wall_clock_that_is_set_changes_nothing_in_who_is_in_contact(back_s: float) -> None:
    room = Room(LinkSpec(), rate=50.0)
    room.hear()
    room.set_wall_clock(back_s)
    room.advance(LinkSpec().quiet_s)
    assert (room.connection(), room.hearing.silent_in_s("left") > 0) == (Connection.ONLINE, True)
    room.advance(50.0 * 1800.0)
    assert (room.connection(), room.hearing.silent_in_s("left")) == (Connection.OFFLINE, 0)


@pytest.mark.parametrize("back_s", [3600.0, -3600.0])
def test_a_wall_clock_that_is_set_changes_nothing_for_a_robot_that_was_never_heard(back_s: float) -> None:
    room = Room(LinkSpec(), rate=50.0)
    room.set_wall_clock(back_s)
    room.advance(LinkSpec().quiet_s)
    assert room.hearing.silent_in_s("left") > 0
    room.wall_passes(SILENT_AFTER_S)
    assert room.hearing.silent_in_s("left") == 0


@pytest.mark.parametrize(
    ("state", "silent"),
    [
        (ConnectionState.ONLINE, False),
        (ConnectionState.OFFLINE, True),
        (ConnectionState.CONNECTION_BROKEN, True),
    ],
)
def test_one_that_is_said_to_be_gone_is_silent_in_time_though_the_worlds_clock_stands(
    state: ConnectionState, silent: bool
) -> None:
    room = Room(ORBIT)
    room.hear()
    room.board.connected("left", state, now=False)
    assert room.hearing.silent_in_s("left") > 0
    room.wall_passes(QUIET_S)
    assert (room.hearing.silent_in_s("left") == 0) is silent


def test_how_long_it_may_still_be_is_never_more_than_it_takes() -> None:
    """It is looked again after that time: later than the silence began to be too long would be too late."""
    for link in (LinkSpec(), LinkSpec(loss=0.9), ORBIT):
        room = Room(link)
        silent_s = room.silent_at(1000.0)
        assert silent_s is not None
        again = Room(link)
        while again.now_s() < silent_s:
            assert again.now_s() + again.hearing.silent_in_s("left") <= silent_s + 0.11
            again.advance(1.0)


def test_when_contact_is_expected_next_is_known() -> None:
    room = Room(ORBIT)
    seen = []
    for step_s in (0.0, 5.0, 9.0, 2.0, 100.0, 9.0):
        room.advance(step_s)
        seen.append(room.hearing.next_contact_s("left"))
    assert seen == pytest.approx([5.0, 0.0, 0.0, 109.0, 9.0, 0.0])
