"""A robot whose packet does not find what it is about gives up by its own limits, or searches by rules."""

from collections.abc import Callable

import pytest

from robots.deliberative.mind import Mind
from robots.deliberative.reader import read_rules, rules_of
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.wire import FailureCategory, PacketReport, ScriptReport, ScriptState
from robots.world.rule_files import shipped_rules
from tests.robots.fake_world import STEP_S, FakeWorld
from tests.robots.stories import EAST, NORTH, SOUTH, Service, packet, room, run_for, script

MakesMind = Callable[[RobotProfile], Mind]


def search(profile: RobotProfile) -> Mind:
    return Mind(profile, load_repertoire(), [read_rules(shipped_rules()["search"])])


def idle(profile: RobotProfile) -> Mind:
    return Mind(profile, load_repertoire(), [rules_of("AGENT search;", "search.rules")])


class Story:
    """fred stands in the southern hall and carries out one packet."""

    def __init__(self, world: FakeWorld, makes_mind: MakesMind | None) -> None:
        self.world = world
        link = world.add("fred", Pose(x_m=1.0, y_m=1.5, heading_rad=EAST), ("ginger",), mind=makes_mind)
        self.service = Service(world, link, "fred")

    def step(self, time_s: float) -> None:
        run_for(self.world, [self.service], time_s)

    def run(self, limit_s: float = 200.0) -> ScriptReport | None:
        while self.service.report is None and self.world.clock.now_s() < limit_s:
            self.step(STEP_S)
        return self.service.report

    @property
    def packets(self) -> list[PacketReport]:
        return [one.body for one in self.service.heard if isinstance(one.body, PacketReport)]


def docking(makes_mind: MakesMind | None, samples: dict[str, complex]) -> Story:
    story = Story(room(samples, noise=0.0), makes_mind)
    story.service.order(script("fred", packet("DOCK", object="rock", ref1="door", wait_timeout_s=90)))
    return story


@pytest.mark.parametrize("makes_mind", [None, search, idle], ids=["software", "rules", "empty"])
def test_a_sample_that_is_nowhere_is_reported_with_what_was_done(makes_mind: MakesMind | None) -> None:
    story = docking(makes_mind, {})
    report = story.run()
    assert report is not None
    assert report.state is ScriptState.FAILED
    assert report.category is FailureCategory.WORLD_CHANGED
    assert [one.events for one in story.packets if one.events] == [("missing",)]
    is_searched = makes_mind is search
    assert any("stands for TURN_LEFT of search" in one.detail for one in story.packets) is is_searched
    assert ("it was never seen, and is not in view" in report.detail) is is_searched
    assert (story.world.clock.now_s() < 25) is is_searched


def test_a_sample_that_lies_elsewhere_in_view_is_not_waited_for() -> None:
    report = docking(search, {"rock": 2 + 0.8j}).run()
    assert report is not None
    assert "it is in view, but not where it was believed" in report.detail
    assert "sees rock" in report.detail


@pytest.mark.parametrize("makes_mind", [None, search], ids=["software", "rules"])
def test_a_robot_is_looked_for_where_it_was_seen_last(makes_mind: MakesMind | None) -> None:
    world = room(noise=0.0)
    story = Story(world, makes_mind)
    world.add("ginger", Pose(x_m=3.0, y_m=2.5, heading_rad=NORTH), ("fred",))
    story.service.order(script("fred", packet("NAVIGATE", ref2="door", timeout_s=60), name="first"))
    while story.service.report is None:
        story.step(STEP_S)
    world.bodies["ginger"].pose = Pose(x_m=3.3, y_m=4.2, heading_rad=SOUTH)  # through the hatch, out of sight
    story.service.heard.clear()
    story.service.order(script("fred", packet("TRACK", robot2="ginger", wait_timeout_s=60), name="second"))
    report = story.run()
    assert report is not None
    assert (report.state is ScriptState.FINISHED) is (makes_mind is search)
    assert any("stands for MOVE_TO of search" in one.detail for one in story.packets) is (
        makes_mind is search
    )


def test_what_others_are_to_bring_is_waited_for() -> None:
    story = Story(room(noise=0.0), search)
    brought = packet("DOCK", object="rock", ref1="door", awaits=["in(rock, door)"], wait_timeout_s=20)
    story.service.order(script("fred", brought))
    report = story.run()
    assert report is not None
    assert "could not start within 20 s" in report.detail
    assert not any(one.events for one in story.packets)
