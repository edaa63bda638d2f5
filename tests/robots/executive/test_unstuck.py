"""A robot that something holds gets free by its own software, by the rules for it, or not at all without either."""

from collections.abc import Callable

import pytest

from robots.deliberative.mind import Mind
from robots.deliberative.reader import read_rules, rules_of
from robots.physical.body import Pose
from robots.physical.geometry import wrap
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.wire import (
    BehaviourScript,
    PacketReport,
    PacketState,
    Performative,
    ScriptState,
    TraceQuery,
    TraceReport,
)
from robots.world.rule_files import shipped_rules
from tests.robots.fake_world import STEP_S
from tests.robots.stories import EAST, Service, packet, room, run_for, script

START = Pose(x_m=1.0, y_m=1.5, heading_rad=EAST)
IDLE = "AGENT unstuck;\nBELIEF(startup) => COMMIT(adoptBelief(idle));"
MakesMind = Callable[[RobotProfile], Mind]


def unstuck_rules(profile: RobotProfile) -> Mind:
    return Mind(profile, load_repertoire(), [read_rules(shipped_rules()["unstuck"])])


def idle_rules(profile: RobotProfile) -> Mind:
    return Mind(profile, load_repertoire(), [rules_of(IDLE, "unstuck.rules")])


class Snag:
    """Something that holds a robot which drives east past a line, until it has backed off or turned aside."""

    def __init__(
        self, makes_mind: MakesMind | None, seed: int, *, home: str | None = None, battery: float = 1.0
    ) -> None:
        self.world = room(seed=seed)
        link = self.world.add("fred", START, mind=makes_mind, home=home)
        self.service = Service(self.world, link, "fred")
        self.body = self.world.bodies["fred"]
        self.body.battery = battery
        self._line_m = 2.0 + 0.1 * (seed % 10)
        self._met: Pose | None = None
        self._is_free = False

    def step(self) -> None:
        run_for(self.world, [self.service], STEP_S)
        here = self.body.pose
        if self._met is None and here.x_m >= self._line_m:
            self._met = here
        if self._met is not None:
            aside = abs(wrap(here.heading_rad - self._met.heading_rad)) > 0.5
            self._is_free |= aside and self._met.x_m - here.x_m > 0.15
            self.body.stuck = not self._is_free and self.body.velocity[0] > 0

    def drive(self, order: BehaviourScript, limit_s: float = 200.0) -> ScriptState | None:
        self.service.order(order)
        for _ in range(round(limit_s / STEP_S)):
            self.step()
            if self.service.report is not None:
                return self.service.report.state
        return None

    @property
    def was_held(self) -> bool:
        return self._met is not None and self._is_free

    @property
    def reports(self) -> list[PacketReport]:
        return [one.body for one in self.service.heard if isinstance(one.body, PacketReport)]


NAVIGATE = script("fred", packet("NAVIGATE", ref2="yard", timeout_s=190))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("makes_mind", [None, unstuck_rules], ids=["software", "rules"])
def test_a_held_robot_gets_free_and_reaches_its_goal(makes_mind: MakesMind | None, seed: int) -> None:
    snag = Snag(makes_mind, seed)
    assert snag.drive(NAVIGATE) is ScriptState.FINISHED
    (stuck, *_) = [one for one in snag.reports if "stuck" in one.events]
    assert stuck.state is PacketState.RUNNING
    how = "its rules free it" if makes_mind else "backs off and tries again"
    assert stuck.detail.startswith(f"no progress, {how} (1 of 4)")
    stood_for = [one.detail for one in snag.reports if "stands for STEP of unstuck" in one.detail]
    assert bool(stood_for) is (makes_mind is not None)


@pytest.mark.parametrize("seed", range(2))
def test_rules_of_that_name_that_do_nothing_leave_it_held(seed: int) -> None:
    snag = Snag(idle_rules, seed)
    assert snag.drive(NAVIGATE) is ScriptState.FAILED
    assert snag.service.report is not None
    assert "made no progress after 4 retries" in snag.service.report.detail


def test_a_robot_on_its_own_way_to_the_charger_is_freed_by_its_software() -> None:
    snag = Snag(unstuck_rules, 0, home="yard", battery=0.24)
    while ("SEEK_CHARGER", PacketState.FINISHED) not in (
        done := [(one.tag, one.state) for one in snag.service.upkeep]
    ):
        snag.step()
        assert snag.world.clock.now_s() < 120
    assert snag.was_held
    assert not [state for tag, state in done if tag == "STEP"]


def test_the_trace_shows_the_patterns_of_a_retry() -> None:
    snag = Snag(None, 0)
    snag.service.order(NAVIGATE)
    while not any("stuck" in one.events for one in snag.reports):
        snag.step()
    for _ in range(round(1.0 / STEP_S)):
        snag.step()
    snag.service.send(TraceQuery(seconds=0.5), Performative.QUERY)
    run_for(snag.world, [snag.service], 0.2)
    names = {
        pattern.name
        for one in snag.service.heard
        if isinstance(one.body, TraceReport)
        for stretch in one.body.stretches
        for pattern in stretch.patterns
    }
    assert "translate/retreat" in names
