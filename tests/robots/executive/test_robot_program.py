"""A robot's own program: what it says is saved first, and what it was at outlives it."""

import pytest

from robots.contract.memory_file import TextMemory
from robots.executive.agent import BehaviouralAgent
from robots.executive.memory import RobotMemory
from robots.executive.robot_program import SAVED_EVERY_S, RobotProgram
from robots.link import InMemoryLink, Link
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.wire import Acknowledgement, ScriptState, Telemetry
from tests.robots.fake_world import FakeBody
from tests.robots.stories import EAST, Service, packet, room, script

START = Pose(x_m=1.0, y_m=1.5, heading_rad=EAST)
DRIVE = script("fred", packet("NAVIGATE", ref1="nowhere", ref2="hatch"))


class Disk(TextMemory):
    """Counts how often it is written to, and may be full."""

    is_full = False
    saved = 0

    def save(self, text: str) -> None:
        if self.is_full:
            raise OSError("No space left on device")
        super().save(text)
        self.saved += 1


class Fred:
    """His body, his program with its disk, and the service."""

    def __init__(self) -> None:
        self.world = room()
        self.body = self.world.bodies["fred"] = FakeBody(self.world, "fred", START)
        self.disk = Disk()
        self.start()

    def start(self, *, stands_by: bool = False, with_disk: bool = True) -> None:
        """Start the program; of the one before only the disk is left."""
        ours, theirs = InMemoryLink.pair()
        self.service = Service(self.world, ours, "fred")
        self.program = RobotProgram(
            "fred",
            make=self._make,
            link=theirs,
            clock=self.world.clock,
            store=self.disk if with_disk else None,
            stands_by=stands_by,
        )

    def _make(self, link: Link, memory: RobotMemory | None) -> BehaviouralAgent:
        profile = RobotProfile(name="fred", start=START, beacons=self.world.beacons)
        return BehaviouralAgent(
            profile=profile, body=self.body, link=link, clock=self.world.clock, memory=memory
        )

    def go_on(self, time_s: float) -> None:
        end_s = self.world.clock.now_s() + time_s
        while self.world.clock.now_s() < end_s:
            self.program.tick()
            self.world.tick()
            self.service.listen()

    def heard(self, kind: type[object]) -> int:
        """How many messages of the kind the service has heard."""
        return sum(isinstance(one.body, kind) for one in self.service.heard)


@pytest.fixture
def fred() -> Fred:
    return Fred()


def test_what_matters_is_said_once_it_is_saved(fred: Fred) -> None:
    fred.go_on(1.2 * SAVED_EVERY_S)
    fred.disk.is_full = True
    fred.service.order(DRIVE)
    fred.go_on(0.5)
    assert not fred.heard(Acknowledgement), "after a power failure he would not know of it"
    fred.disk.is_full = False
    fred.service.order(DRIVE)
    fred.go_on(0.5)
    assert fred.heard(Acknowledgement)


def test_a_program_without_a_disk_says_what_matters_at_once(fred: Fred) -> None:
    fred.start(with_disk=False)
    fred.service.order(DRIVE)
    fred.go_on(0.5)
    assert fred.heard(Acknowledgement)


def test_telemetry_alone_is_said_at_once_and_saved_now_and_then(fred: Fred) -> None:
    fred.go_on(0.2)
    saved, heard = fred.disk.saved, fred.heard(Telemetry)
    fred.go_on(5 * SAVED_EVERY_S)
    assert 4 <= fred.disk.saved - saved <= 6
    assert fred.heard(Telemetry) - heard >= 9


def test_a_script_is_gone_on_with_after_a_power_failure(fred: Fred) -> None:
    fred.service.order(DRIVE)
    fred.go_on(3.0)
    fred.start()
    fred.go_on(60.0)
    report = fred.service.report
    assert report is not None
    assert (report.script_id, report.state) == (DRIVE.id, ScriptState.FINISHED)


def test_a_program_without_a_memory_stands_by_if_another_has_the_mind(fred: Fred) -> None:
    assert not fred.program.is_mute
    fred.disk.text = ""
    fred.start(stands_by=True)
    assert fred.program.is_mute
    fred.service.order(DRIVE)
    fred.go_on(1.0)
    assert not fred.heard(Acknowledgement)
    fred.program.close()
    fred.start()
    assert fred.program.is_mute, "its memory says so"
