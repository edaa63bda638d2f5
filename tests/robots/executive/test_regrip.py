"""A robot that does not get hold of its object tries again by its own software, or as the rules for it say."""

from collections.abc import Callable

import pytest

from robots.deliberative.mind import Mind
from robots.deliberative.reader import read_rules, rules_of
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.wire import PacketReport, ScriptState
from robots.world.rule_files import shipped_rules
from tests.robots.fake_world import STEP_S
from tests.robots.stories import SOUTH, Service, carry, room, run_for

MakesMind = Callable[[RobotProfile], Mind]


def shipped(profile: RobotProfile, *names: str) -> Mind:
    return Mind(profile, load_repertoire(), [read_rules(shipped_rules()[name]) for name in names])


def regrip(profile: RobotProfile) -> Mind:
    return shipped(profile, "regrip")


def unstuck(profile: RobotProfile) -> Mind:
    return shipped(profile, "unstuck")


def idle(profile: RobotProfile) -> Mind:
    return Mind(profile, load_repertoire(), [rules_of("AGENT regrip;", "regrip.rules")])


class Jam:
    """A robot whose jaws are jammed open from the first on, for some time."""

    def __init__(self, makes_mind: MakesMind | None, jammed_s: float) -> None:
        world = room({"rock": 1 + 0.4j}, noise=0.0)
        link = world.add("fred", Pose(x_m=1.0, y_m=1.5, heading_rad=SOUTH), mind=makes_mind)
        self.service = Service(world, link, "fred")
        self.service.order(carry("fred", "rock", "door", "hatch"))
        self.body = world.bodies["fred"]
        self.body.jammed = True
        self.nearest_m = self.farthest_m = 0.0
        while self.service.report is None and world.clock.now_s() < 200:
            run_for(world, [self.service], STEP_S)
            self.body.jammed = world.clock.now_s() < jammed_s
        self.state = self.service.report.state if self.service.report else None

    @property
    def details(self) -> list[str]:
        return [one.body.detail for one in self.service.heard if isinstance(one.body, PacketReport)]


@pytest.mark.parametrize("makes_mind", [None, regrip, unstuck], ids=["software", "rules", "other rules"])
def test_jaws_that_close_late_get_hold_of_the_object(makes_mind: MakesMind | None) -> None:
    jam = Jam(makes_mind, jammed_s=16.0)
    assert jam.state is ScriptState.FINISHED
    how = "its rules free it" if makes_mind is regrip else "backs off and tries again"
    assert any(one.startswith(f"no progress, {how} (1 of 4)") for one in jam.details)
    assert any("stands for STEP of regrip" in one for one in jam.details) is (makes_mind is regrip)
    assert not any("of unstuck" in one for one in jam.details)


def test_rules_give_up_with_their_reason_where_the_software_tries_on() -> None:
    assert any("was given up: the jaws have missed it twice" in one for one in Jam(regrip, 200).details)
    assert not any("was given up" in one for one in Jam(None, 200).details)


def test_rules_of_that_name_that_do_nothing_leave_the_robot_where_it_is() -> None:
    jam = Jam(idle, 200)
    assert jam.state is ScriptState.FAILED
    assert not any("stands for" in one for one in jam.details)
    assert sum("its rules free it" in one for one in jam.details) == 4
