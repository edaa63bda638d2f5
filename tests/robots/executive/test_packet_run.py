"""One packet's run: how long it bears unmet conditions, which events it raises, and which defects it reports."""

from dataclasses import dataclass, replace

import pytest

from robots.conditions.sight import LiesAt
from robots.conditions.verdict import Verdict
from robots.executive.packet_run import LOST_S, MISSING, UNSEEN_S, Outcome, PacketRun
from robots.perception.health import Defect
from robots.perception.percepts import NOTHING, Needs, Percepts
from robots.reactive.stall import MET
from robots.repertoire.schema import BoundPacket
from robots.wire import FailureCategory, PacketState
from tests.robots.sensed import PROFILE, percepts, sees
from tests.robots.stories import packet

STEP_S = 0.1
INSTANT = percepts()


@dataclass(slots=True)
class Switch:
    """A condition that a test switches on and off."""

    holds: bool = True
    unseen: bool = False
    needs: Needs = NOTHING

    def check(self, percepts: Percepts) -> Verdict:
        return Verdict(self.holds, "is as it is", self.unseen)


@dataclass(slots=True)
class Trial:
    """A run of a packet, stepped by hand."""

    run: PacketRun

    def step(self, time_s: float = STEP_S, defects: tuple[Defect, ...] = ()) -> list[Outcome]:
        return [
            self.run.step(replace(INSTANT, degraded=defects), STEP_S) for _ in range(round(time_s / STEP_S))
        ]


def trial(
    *, before: Switch | None = None, maintain: Switch | None = None, event: Switch | None = None
) -> Trial:
    content = BoundPacket(
        tag="TEST",
        before=(before,) if before else (),
        patterns=(),
        maintain=(maintain,) if maintain else (),
        after=(Switch(holds=False),),
        events={"alarm": (event,)} if event else {},
        retries=None,
    )
    made = Trial(PacketRun(packet("TEST", timeout_s=1000, wait_timeout_s=1000), content, PROFILE))
    made.step(2 * STEP_S)
    return made


def failure(outcomes: list[Outcome]) -> FailureCategory | None:
    return next((one.change.category for one in outcomes if one.change and one.change.category), None)


@pytest.mark.parametrize(("unseen", "borne_s"), [(False, LOST_S), (True, UNSEEN_S)])
def test_a_maintained_condition_that_stays_unmet_fails_the_packet(unseen: bool, borne_s: float) -> None:
    maintain = Switch()
    this = trial(maintain=maintain)
    maintain.holds = False
    maintain.unseen = unseen
    assert failure(this.step(borne_s - 2 * STEP_S)) is None
    assert failure(this.step(4 * STEP_S)) is FailureCategory.WORLD_CHANGED
    assert this.run.state is PacketState.FAILED


def test_a_maintained_condition_that_flickers_is_borne_however_often() -> None:
    maintain = Switch()
    this = trial(maintain=maintain)
    for _ in range(5):
        maintain.holds = False
        this.step(0.8 * LOST_S)
        maintain.holds = True
        this.step()
    assert this.run.state is PacketState.RUNNING


def test_a_pre_condition_may_be_out_of_view_however_often_but_not_for_long() -> None:
    before = Switch(holds=False, unseen=True)
    this = trial(before=before)
    for _ in range(3):
        this.step(0.8 * UNSEEN_S)
        before.unseen = False
        this.step()
        before.unseen = True
    assert this.run.state is PacketState.INITIALIZING
    assert failure(this.step(1.2 * UNSEEN_S)) is FailureCategory.WORLD_CHANGED


def raised(outcomes: list[Outcome]) -> int:
    return sum("alarm" in one.change.events for one in outcomes if one.change)


def test_an_event_is_raised_again_only_after_its_conditions_have_not_held_for_a_while() -> None:
    event = Switch()
    this = trial(event=event)
    assert raised(this.step(3.0)) == 1
    for _ in range(8):
        event.holds = False
        assert raised(this.step(0.3)) == 0
        event.holds = True
        assert raised(this.step(0.3)) == 0, "it has flickered"
    event.holds = False
    assert raised(this.step(1.0)) == 0
    event.holds = True
    assert raised(this.step(3.0)) == 1


def test_a_defect_of_a_sensor_is_reported_once_whatever_it_reads() -> None:
    this = trial()
    details = [
        outcome.change.detail
        for reading in ("nan", "-1.00", "nan")
        for outcome in this.step(defects=(Defect("whisker 3", f"whisker 3 reads {reading}"),))
        if outcome.change
    ]
    assert details == ["goes on though whisker 3 reads nan"]
    (outcome,) = this.step(defects=(Defect("battery", "the battery reads nan"),))
    assert outcome.change is not None
    assert outcome.change.detail == "goes on though the battery reads nan"


def test_another_robot_in_view_leaves_a_stall_to_rules_once_its_own_manoeuvre_was_tried() -> None:
    content = BoundPacket(
        tag="TEST", before=(), patterns=(), after=(Switch(holds=False),), retries=4, stalled_s=1.0
    )
    run = PacketRun(packet("TEST", timeout_s=1000, wait_timeout_s=1000), content, PROFILE)
    near = percepts(sees("other", 1.0))
    outcomes = [run.step(near, STEP_S, left_to_rules=frozenset({MET})) for _ in range(300)]
    stalls = [one.change.detail for one in outcomes if one.change and MET in one.change.events]
    assert [one.split("(")[0] for one in stalls] == [
        "no progress, backs off and tries again ",
        *["no progress, its rules free it "] * 3,
    ]


@pytest.mark.parametrize("brought", [False, True], ids=["astray", "to be brought"])
def test_want_of_sight_is_left_to_rules_only_where_they_hear_of_it(brought: bool) -> None:
    expected = LiesAt(object="rock", place="bay")
    content = BoundPacket(tag="TEST", before=(expected,), patterns=(), after=(), retries=None)
    awaits = ["in(rock, bay)"] if brought else []
    order = packet("TEST", awaits=awaits, timeout_s=1000, wait_timeout_s=1000)
    run = PacketRun(order, content, PROFILE)
    for _ in range(round(2 * UNSEEN_S / STEP_S)):
        run.step(INSTANT, STEP_S, left_to_rules=frozenset({MISSING}))
    assert run.state is (PacketState.FAILED if brought else PacketState.INITIALIZING)
