from collections.abc import Callable
from dataclasses import replace

import pytest

from app.domain.blockers import Blockers
from app.domain.errors import IllegalTransition
from app.domain.lifecycles import recovery
from app.domain.lifecycles.recovery import AttemptOutcome, RecoveryStep
from app.domain.recovery_rules import TRIES, Measure, Trouble
from robots.wire import FailureCategory
from tests.app.domain.lifecycles.records import PlainMission

TROUBLE = Trouble(robot="fred", category=FailureCategory.ROBOT, detail="the gripper does not close")


PINS = [{"goal": "in(s, b)"}]


def begin(mission: PlainMission, *troubles: Trouble) -> None:
    recovery.begin_attempt(mission, troubles or [TROUBLE], at_s=5.0, failure="robot", reason="fred failed")


def propose(mission: PlainMission) -> None:
    recovery.propose(mission, plan_id="plan-2", measure=Measure.REPAIR, detail="")


def deciding() -> PlainMission:
    mission = PlainMission()
    begin(mission)
    propose(mission)
    recovery.ask_operator(mission)
    return mission


def stands(mission: PlainMission) -> tuple[str | None, str]:
    return mission.recovery_step, mission.attempts[-1]["outcome"]


def test_a_repair_that_is_approved_leaves_nothing_to_recover() -> None:
    mission = deciding()
    assert stands(mission) == (RecoveryStep.DECIDING, AttemptOutcome.PROPOSED)
    recovery.approve(mission, "plan-2")
    assert stands(mission) == (None, AttemptOutcome.APPROVED)
    assert mission.tries_left == TRIES - 1
    assert recovery.troubles_of(mission) == [TROUBLE]


def test_a_repair_that_is_rejected_ends_the_mission() -> None:
    mission = deciding()
    recovery.reject(mission, "plan-2", "the repair was rejected")
    assert stands(mission) == (RecoveryStep.ENDING, AttemptOutcome.REJECTED)
    assert recovery.why_no_plan(mission) == "the repair was rejected"
    with pytest.raises(IllegalTransition):
        begin(mission)


def test_a_repair_that_the_world_has_overtaken_is_sought_again() -> None:
    mission = deciding()
    recovery.overtake(mission, "sample_1 was moved")
    begin(mission)
    assert [one["outcome"] for one in mission.attempts] == [AttemptOutcome.OVERTAKEN, AttemptOutcome.PLANNING]
    assert [one["number"] for one in mission.attempts] == [1, 2]


def test_a_mission_that_is_stuck_is_tried_again_with_all_its_tries() -> None:
    mission = PlainMission(tries_left=1)
    begin(mission)
    recovery.find_no_plan(mission, "no robot is left")
    assert recovery.why_no_plan(mission) == "no robot is left"
    recovery.get_stuck(mission)
    recovery.try_again(mission)
    assert stands(mission) == (None, AttemptOutcome.TAKEN_UP)
    assert (mission.tries_left, recovery.why_no_plan(mission)) == (TRIES, "")


def test_one_failure_counts_once_however_often_its_mission_is_tried_again() -> None:
    failed = replace(TROUBLE, script="script-1")
    mission = PlainMission()
    begin(mission, failed)
    recovery.wait_for(mission, Blockers(missions=("mission-2",)))
    begin(mission, failed)
    assert recovery.troubles_of(mission) == [failed]
    recovery.find_no_plan(mission, "no robot is left")
    recovery.get_stuck(mission)
    recovery.try_again(mission)
    begin(mission, failed, replace(failed, script="script-2"))
    assert [one.script for one in recovery.troubles_of(mission)] == ["script-1", "script-2"]


def test_an_operator_who_has_a_mission_tried_again_answers_its_troubles_but_finds_nobody() -> None:
    lost = Trouble(
        robot="ginger", category=FailureCategory.UNREACHABLE, detail="was declared lost", fit=False
    )
    mission = PlainMission()
    begin(mission, TROUBLE, lost)
    recovery.find_no_plan(mission, "no robot is left")
    recovery.get_stuck(mission)
    recovery.try_again(mission)
    assert recovery.troubles_of(mission) == [replace(TROUBLE, answered=True), lost]
    recovery.answer_troubles(mission, lambda trouble: trouble.robot == "ginger")
    assert all(trouble.answered for trouble in recovery.troubles_of(mission))


def test_a_plan_that_others_stand_in_the_way_of_is_sought_later() -> None:
    mission = PlainMission()
    begin(mission)
    recovery.wait_for(mission, Blockers(missions=("mission-2",)))
    assert recovery.why_no_plan(mission) == "waits for mission-2"
    assert stands(mission) == (RecoveryStep.WAITING, AttemptOutcome.NO_PLAN)
    begin(mission)
    assert mission.recovery_step == RecoveryStep.PLANNING


@pytest.mark.parametrize(
    "change",
    [
        recovery.ask_operator,
        propose,
        lambda mission: recovery.approve(mission, "plan-2"),
        lambda mission: recovery.reject(mission, "plan-2", ""),
        lambda mission: recovery.overtake(mission, ""),
    ],
    ids=["ask", "propose", "approve", "reject", "overtake"],
)
def test_without_a_repaired_plan_there_is_nothing_to_decide(change: Callable[[PlainMission], None]) -> None:
    mission = PlainMission()
    begin(mission)
    recovery.find_no_plan(mission, "no robot is left")
    with pytest.raises(IllegalTransition):
        change(mission)


def asked_for() -> PlainMission:
    """A mission whose operator has asked for another plan, which is proposed."""
    mission = PlainMission()
    recovery.ask_for_plan(mission, pins=PINS, goals=["goal-2"], reason="an operator asks")
    recovery.begin_attempt(mission, (), at_s=5.0, failure=None, reason="an operator asks")
    propose(mission)
    recovery.ask_operator(mission)
    return mission


def test_a_plan_that_was_asked_for_uses_up_no_try() -> None:
    mission = asked_for()
    assert (mission.stopped_for, mission.replanning) == (
        "an operator asks",
        {"pins": PINS, "goals": ["goal-2"]},
    )
    recovery.approve(mission, "plan-2")
    assert (mission.stopped_for, mission.replanning, mission.tries_left) == ("", None, TRIES)


def test_once_a_plan_that_was_asked_for_is_rejected_the_mission_goes_back_to_the_one_before() -> None:
    mission = asked_for()
    assert not recovery.goes_back(mission)
    recovery.refuse_plan(mission, "plan-2", "it was rejected")
    recovery.begin_attempt(mission, (), at_s=6.0, failure=None, reason="it was rejected")
    assert recovery.goes_back(mission)
    assert (mission.replanning, mission.tries_left, mission.stopped_for) == (None, TRIES, "it was rejected")
    assert [one["outcome"] for one in mission.attempts] == [AttemptOutcome.REJECTED, AttemptOutcome.PLANNING]


def test_goals_that_a_plan_was_asked_for_join_the_mission_with_its_approval() -> None:
    mission = asked_for()
    assert (recovery.goals_beside(mission), recovery.goals_left_out(mission)) == (("goal-2",), ())
    recovery.approve(mission, "plan-2")
    recovery.ask_for_plan(mission, pins=(), goals=["goal-3"], reason="an operator asks")
    assert (mission.joined_goals, recovery.asked_goals(mission)) == (["goal-2"], ("goal-3",))
    assert recovery.goals_beside(mission) == ("goal-2", "goal-3")


def test_goals_of_a_plan_that_is_rejected_are_left_out() -> None:
    mission = asked_for()
    recovery.refuse_plan(mission, "plan-2", "it was rejected")
    assert (recovery.goals_beside(mission), recovery.goals_left_out(mission)) == ((), ("goal-2",))


def test_without_a_plan_for_the_goals_what_is_pinned_is_planned_without_them() -> None:
    mission = PlainMission()
    recovery.ask_for_plan(mission, pins=PINS, goals=["goal-2"], reason="an operator asks")
    recovery.begin_attempt(mission, (), at_s=5.0, failure=None, reason="an operator asks")
    recovery.leave_goals_out(mission, "there is no plan with goal-2")
    recovery.begin_attempt(mission, (), at_s=6.0, failure=None, reason="there is no plan with goal-2")
    assert (mission.replanning, mission.tries_left) == ({"pins": PINS, "goals": []}, TRIES)
    assert recovery.goals_left_out(mission) == ("goal-2",)
    assert [one["outcome"] for one in mission.attempts] == [AttemptOutcome.NO_PLAN, AttemptOutcome.PLANNING]


def test_a_repair_after_a_failure_does_not_go_back() -> None:
    mission = PlainMission()
    begin(mission)
    assert not recovery.goes_back(mission)


def test_a_mission_that_is_not_stuck_cannot_be_taken_up_again() -> None:
    with pytest.raises(IllegalTransition):
        recovery.try_again(deciding())
