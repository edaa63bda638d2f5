"""The mission monitor's rules (MACTA §4): expected time, enquiry, silence, making safe, conclusion."""

from dataclasses import replace

import pytest

from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.recovery import RecoveryStep
from app.domain.lifecycles.script import Delivery
from app.domain.mission_monitor import EXTENSION_S, LOOK_S, MissionView, ScriptView, review
from app.domain.recovery_rules import LeftOut, Policy, left_out
from robots.wire import FailureCategory, ScriptState

PATIENCE_S = 10.0
AT_WORK = ScriptView(
    robot="yard_1", delivery=Delivery.ACKNOWLEDGED, state=ScriptState.RUNNING, open_question=False
)
MISSED = ("in(sample_1, bay_7)",)
DONE = ScriptView(
    robot="store_2", delivery=Delivery.ACKNOWLEDGED, state=ScriptState.FINISHED, open_question=False
)
FAILED = replace(
    AT_WORK, state=ScriptState.FAILED, category=FailureCategory.WORLD_CHANGED, detail="bay_7 is occupied"
)


def mission(
    *scripts: ScriptView, now_s: float = 10.0, asked_for_s: float | None = None, **more: object
) -> MissionView:
    view = MissionView(
        state=MissionState.RUNNING,
        now_s=now_s,
        enquire_at_s=100.0,
        estimate_s=60.0,
        asked_for_s=asked_for_s,
        cancel_requested=False,
        scripts=scripts,
        missed=() if all(script.state is ScriptState.FINISHED for script in scripts) else MISSED,
    )
    return replace(view, **more)  # type: ignore[arg-type]


def test_before_the_expected_time_is_over_nobody_is_asked() -> None:
    verdict = review(mission(AT_WORK, DONE), patience_s=PATIENCE_S)
    assert (verdict.state, verdict.ask, verdict.wait_s) == (MissionState.RUNNING, (), 90.0)


def test_silent_robot_is_asked_for_status_after_the_expected_time() -> None:
    verdict = review(mission(AT_WORK, DONE, now_s=100.0), patience_s=PATIENCE_S)
    assert verdict.ask == ("yard_1",)


def test_a_robot_that_answers_it_is_at_work_gets_more_time() -> None:
    verdict = review(mission(AT_WORK, now_s=101.0, asked_for_s=0.5), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.RUNNING
    assert verdict.enquire_at_s == 131.0
    short = review(mission(AT_WORK, now_s=101.0, asked_for_s=0.5, estimate_s=1.0), patience_s=PATIENCE_S)
    assert short.enquire_at_s == 101.0 + EXTENSION_S


@pytest.mark.parametrize("asked_for_s", [PATIENCE_S, 10 * PATIENCE_S])
def test_a_robot_that_stays_silent_makes_the_mission_unknown_not_failed(asked_for_s: float) -> None:
    silent = replace(AT_WORK, open_question=True)
    verdict = review(mission(silent, now_s=101.0, asked_for_s=asked_for_s), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.UNKNOWN
    assert verdict.failure is FailureCategory.UNREACHABLE
    assert "yard_1" in verdict.reason


UNASKED = replace(AT_WORK, robot="store_2", is_unasked=True)


@pytest.mark.parametrize(
    ("unasked", "now_s", "words"),
    [(UNASKED, 101.0, "time is over"), (replace(UNASKED, silent_in_s=0.0), 10.0, "no message from store_2")],
)
@pytest.mark.parametrize("asked_for_s", [None, 0.5])
def test_when_a_robot_would_have_to_be_asked_that_cannot_be_the_mission_is_unknown(
    unasked: ScriptView, now_s: float, words: str, asked_for_s: float | None
) -> None:
    view = mission(unasked, now_s=now_s, asked_for_s=asked_for_s)
    verdict = review(view, patience_s=PATIENCE_S)
    assert (verdict.state, verdict.ask) == (MissionState.UNKNOWN, ())
    assert words in verdict.reason
    assert "cannot be asked" in verdict.reason


def test_others_are_asked_and_a_robot_that_cannot_be_is_at_work_once_it_is_heard() -> None:
    both = mission(AT_WORK, UNASKED, now_s=100.0)
    assert review(both, patience_s=PATIENCE_S).ask == ("yard_1",)
    heard = mission(UNASKED, now_s=10.0, state=MissionState.UNKNOWN)
    assert review(heard, patience_s=PATIENCE_S).state is MissionState.RUNNING


def test_within_its_patience_the_monitor_waits_for_the_answer() -> None:
    silent = replace(AT_WORK, open_question=True)
    verdict = review(mission(silent, now_s=101.0, asked_for_s=PATIENCE_S / 2), patience_s=PATIENCE_S)
    assert (verdict.state, verdict.ask) == (MissionState.RUNNING, ())


def test_a_robot_that_never_acknowledged_its_script_is_silent_too() -> None:
    unheard = replace(AT_WORK, delivery=Delivery.PENDING, state=None)
    verdict = review(mission(unheard, now_s=101.0, asked_for_s=PATIENCE_S), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.UNKNOWN


def test_an_unknown_mission_runs_again_once_the_robot_answers() -> None:
    view = mission(AT_WORK, now_s=500.0, asked_for_s=300.0, state=MissionState.UNKNOWN)
    assert review(view, patience_s=PATIENCE_S).state is MissionState.RUNNING


def test_a_robot_whose_silence_its_radio_does_not_explain_is_asked_before_the_expected_time_is_over() -> None:
    silent, heard = replace(AT_WORK, silent_in_s=0.0), replace(AT_WORK, robot="yard_2", silent_in_s=15.0)
    verdict = review(mission(silent, heard), patience_s=PATIENCE_S)
    assert (verdict.state, verdict.ask) == (MissionState.RUNNING, ("yard_1",))
    assert verdict.reason == "no message from yard_1: asking yard_1"


@pytest.mark.parametrize(
    ("silent_in_s", "now_s", "wait_s"), [(20.0, 10.0, 20.0), (0.3, 10.0, LOOK_S), (20.0, 97.0, 3.0)]
)
def test_it_is_looked_again_when_a_robot_may_have_been_silent_for_too_long(
    silent_in_s: float, now_s: float, wait_s: float
) -> None:
    heard = replace(AT_WORK, silent_in_s=silent_in_s)
    verdict = review(mission(heard, now_s=now_s), patience_s=PATIENCE_S)
    assert (verdict.ask, verdict.wait_s) == ((), wait_s)


def test_a_silent_robot_that_does_not_answer_makes_the_mission_unknown_before_its_time_is_over() -> None:
    silent = replace(AT_WORK, silent_in_s=0.0, open_question=True)
    for asked_for_s, state in ((0.5 * PATIENCE_S, MissionState.RUNNING), (PATIENCE_S, MissionState.UNKNOWN)):
        assert review(mission(silent, asked_for_s=asked_for_s), patience_s=PATIENCE_S).state is state


def test_once_it_has_answered_what_is_left_of_the_expected_time_is_left() -> None:
    view = mission(AT_WORK, now_s=60.0, asked_for_s=300.0, state=MissionState.UNKNOWN)
    verdict = review(view, patience_s=PATIENCE_S)
    assert (verdict.state, verdict.enquire_at_s) == (MissionState.RUNNING, 100.0)


def test_one_that_is_heard_and_has_yet_to_agree_to_its_script_owes_no_answer_before_the_time_is_over() -> (
    None
):
    coming = replace(AT_WORK, delivery=Delivery.PENDING, state=None, silent_in_s=15.0)
    verdict = review(mission(coming, asked_for_s=PATIENCE_S), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.DISPATCHING
    silent = replace(coming, silent_in_s=0.0)
    verdict = review(mission(silent, asked_for_s=PATIENCE_S), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.UNKNOWN


def test_all_scripts_finished_complete_the_mission_even_if_it_was_unknown() -> None:
    view = mission(DONE, now_s=500.0, asked_for_s=300.0, state=MissionState.UNKNOWN)
    assert review(view, patience_s=PATIENCE_S).state is MissionState.COMPLETED


def test_when_one_robot_fails_the_others_are_stopped_first() -> None:
    verdict = review(mission(FAILED, AT_WORK), patience_s=PATIENCE_S)
    assert not verdict.state.ended
    assert verdict.cancel == ("yard_1",)
    assert "bay_7 is occupied" in verdict.reason


def test_a_robot_is_stopped_even_if_it_was_asked_before() -> None:
    verdict = review(mission(FAILED, AT_WORK, asked_for_s=PATIENCE_S), patience_s=PATIENCE_S)
    assert verdict.cancel == ("yard_1",)


def test_a_robot_that_does_not_answer_the_order_to_stop_leaves_the_mission_unknown() -> None:
    stopping = replace(AT_WORK, stopping=True)
    verdict = review(mission(FAILED, stopping, asked_for_s=PATIENCE_S), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.UNKNOWN


def test_once_all_have_stopped_the_mission_has_failed_with_the_robots_reason() -> None:
    stopped = replace(AT_WORK, state=ScriptState.CANCELLED, stopping=True)
    verdict = review(mission(FAILED, stopped), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.FAILED
    assert verdict.failure is FailureCategory.WORLD_CHANGED
    assert "bay_7 is occupied" in verdict.reason


def test_some_finished_and_some_failed_is_partially_completed() -> None:
    assert review(mission(FAILED, DONE), patience_s=PATIENCE_S).state is MissionState.PARTIALLY_COMPLETED


def test_a_refused_script_fails_the_mission() -> None:
    refused = replace(AT_WORK, delivery=Delivery.REFUSED, state=None, detail="busy")
    verdict = review(mission(refused), patience_s=PATIENCE_S)
    assert (verdict.state, verdict.reason) == (MissionState.FAILED, "yard_1: busy")


def test_a_cancelled_mission_ends_once_every_robot_has_stopped() -> None:
    order = review(mission(AT_WORK, cancel_requested=True), patience_s=PATIENCE_S)
    assert order.cancel == ("yard_1",)
    stopped = replace(AT_WORK, state=ScriptState.CANCELLED, stopping=True)
    verdict = review(mission(stopped, cancel_requested=True), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.CANCELLED


@pytest.mark.parametrize(("missed", "says_so"), [(MISSED, False), ((), True)])
def test_a_cancelled_mission_says_if_what_it_was_to_achieve_has_come_true(
    missed: tuple[str, ...], says_so: bool
) -> None:
    stopped = replace(AT_WORK, state=ScriptState.CANCELLED, stopping=True)
    verdict = review(mission(stopped, cancel_requested=True, missed=missed), patience_s=PATIENCE_S)
    assert (verdict.state, verdict.failure) == (MissionState.CANCELLED, FailureCategory.CANCELLED)
    assert ("all its goals are true" in verdict.reason) is says_so


def test_a_mission_that_finished_before_the_cancel_reached_it_is_completed() -> None:
    assert review(mission(DONE, cancel_requested=True), patience_s=PATIENCE_S).state is MissionState.COMPLETED


def test_a_paused_mission_is_not_asked_when_its_time_runs_out() -> None:
    view = mission(AT_WORK, now_s=200.0, state=MissionState.PAUSED)
    verdict = review(view, patience_s=PATIENCE_S)
    assert (verdict.state, verdict.ask) == (MissionState.PAUSED, ())


@pytest.mark.parametrize("open_question", [True, False])
def test_a_mission_paused_while_a_question_is_open_stays_paused(open_question: bool) -> None:
    asked = replace(AT_WORK, open_question=open_question)
    view = mission(asked, now_s=200.0, state=MissionState.PAUSED, asked_for_s=10 * PATIENCE_S)
    verdict = review(view, patience_s=PATIENCE_S)
    assert verdict.state is MissionState.PAUSED
    assert verdict.enquire_at_s == 200.0 + EXTENSION_S


def test_a_mission_without_scripts_yet_is_not_concluded() -> None:
    for state in (MissionState.PENDING, MissionState.PAUSED):
        assert review(mission(state=state), patience_s=PATIENCE_S).state is state


STOPPED = replace(AT_WORK, robot="store_2", state=ScriptState.CANCELLED, stopping=True)


def recovered(*scripts: ScriptView, **more: object) -> MissionView:
    """A mission that is recovered without asking, unless told otherwise."""
    return mission(*scripts, **{"policy": Policy.AUTO, "tries_left": 2, **more})


def test_a_mission_recovers_once_its_robots_are_safe() -> None:
    stopping = review(recovered(FAILED, AT_WORK), patience_s=PATIENCE_S)
    assert (stopping.state, stopping.cancel, stopping.recover) == (MissionState.RECOVERING, ("yard_1",), None)
    verdict = review(recovered(FAILED, STOPPED), patience_s=PATIENCE_S)
    assert (verdict.state, verdict.recover) == (MissionState.RECOVERING, RecoveryStep.PLANNING)
    assert verdict.failure is FailureCategory.WORLD_CHANGED


def test_a_mission_that_was_recovered_too_often_fails_or_has_an_operator_asked() -> None:
    view = recovered(FAILED, STOPPED, tries_left=0)
    assert review(view, patience_s=PATIENCE_S).state is MissionState.FAILED
    asked = review(replace(view, policy=Policy.ASK), patience_s=PATIENCE_S)
    assert (asked.state, asked.recover) == (MissionState.RECOVERING, RecoveryStep.STUCK)


def test_a_mission_without_a_plan_to_recover_by_fails_with_both_reasons() -> None:
    view = recovered(FAILED, STOPPED, no_way="no plan was found without yard_1")
    verdict = review(view, patience_s=PATIENCE_S)
    assert verdict.state is MissionState.FAILED
    assert "bay_7 is occupied" in verdict.reason
    assert "no plan was found without yard_1" in verdict.reason


@pytest.mark.parametrize(
    ("step", "reason"),
    [
        (RecoveryStep.PLANNING, "wait"),
        (RecoveryStep.DECIDING, "wait"),
        (RecoveryStep.STUCK, "yard_1: bay_7 is occupied"),
    ],
)
def test_while_a_repair_is_sought_or_decided_on_nothing_is_concluded(step: RecoveryStep, reason: str) -> None:
    view = recovered(FAILED, step=step, state=MissionState.RECOVERING, reason="wait", tries_left=0)
    verdict = review(view, patience_s=PATIENCE_S)
    assert (verdict.state, verdict.reason, verdict.recover) == (MissionState.RECOVERING, reason, None)
    cancelled = review(replace(view, cancel_requested=True), patience_s=PATIENCE_S)
    assert cancelled.state is MissionState.CANCELLED
    true_after_all = review(replace(view, missed=()), patience_s=PATIENCE_S)
    assert true_after_all.state is MissionState.COMPLETED


def test_a_repair_that_others_keep_from_being_made_is_sought_again_later() -> None:
    view = recovered(FAILED, step=RecoveryStep.WAITING, no_way="waits for mission-2")
    early = review(view, patience_s=PATIENCE_S)
    assert (early.state, early.recover, early.wait_s) == (MissionState.RECOVERING, None, 90.0)
    assert review(replace(view, now_s=100.0), patience_s=PATIENCE_S).recover is RecoveryStep.PLANNING
    spent = review(replace(view, now_s=100.0, tries_left=0), patience_s=PATIENCE_S)
    assert spent.state is MissionState.FAILED


def test_a_repair_that_was_turned_down_ends_the_mission() -> None:
    view = recovered(
        FAILED, DONE, policy=Policy.ASK, step=RecoveryStep.ENDING, no_way="the repair was rejected"
    )
    verdict = review(view, patience_s=PATIENCE_S)
    assert verdict.state is MissionState.PARTIALLY_COMPLETED
    assert "the repair was rejected" in verdict.reason


def test_a_world_that_is_not_as_the_plan_counts_on_stops_the_robots() -> None:
    verdict = review(recovered(AT_WORK, broken=("in(sample_1, door_1)",)), patience_s=PATIENCE_S)
    assert verdict.cancel == ("yard_1",)
    assert "in(sample_1, door_1) is no longer true" in verdict.reason
    again = review(recovered(replace(AT_WORK, stopping=True), asked_for_s=0.1), patience_s=PATIENCE_S)
    assert (again.state, again.cancel) == (MissionState.RECOVERING, ())


def asked(*scripts: ScriptView, **more: object) -> MissionView:
    """A mission whose operator has asked for another plan."""
    return recovered(*scripts, **{"replans": True, "stopped_for": "an operator has asked", **more})


@pytest.mark.parametrize("policy", Policy)
def test_a_mission_whose_operator_asks_for_another_plan_is_planned_again_by_every_policy(
    policy: Policy,
) -> None:
    stopping = review(asked(AT_WORK, policy=policy), patience_s=PATIENCE_S)
    assert (stopping.state, stopping.cancel) == (MissionState.RECOVERING, ("yard_1",))
    planning = review(asked(STOPPED, DONE, policy=policy), patience_s=PATIENCE_S)
    assert (planning.recover, planning.failure) == (RecoveryStep.PLANNING, None)
    stuck = review(asked(STOPPED, policy=policy, no_way="store_2 is needed"), patience_s=PATIENCE_S)
    assert (stuck.state, stuck.recover) == (MissionState.RECOVERING, RecoveryStep.STUCK)
    cancelled = review(asked(STOPPED, policy=policy, cancel_requested=True), patience_s=PATIENCE_S)
    assert cancelled.state is MissionState.CANCELLED


def test_a_mission_that_is_done_before_its_robots_stop_is_completed_without_a_remark() -> None:
    verdict = review(asked(DONE, missed=()), patience_s=PATIENCE_S)
    assert (verdict.state, verdict.reason) == (MissionState.COMPLETED, "")


def test_what_fails_while_a_plan_is_asked_for_is_the_failure() -> None:
    verdict = review(asked(FAILED, STOPPED), patience_s=PATIENCE_S)
    assert verdict.failure is FailureCategory.WORLD_CHANGED
    assert "bay_7 is occupied" in verdict.reason


def test_a_lost_robot_counts_as_failed_and_nobody_waits_for_it() -> None:
    lost = replace(AT_WORK, abandoned=True)
    verdict = review(recovered(lost, STOPPED), patience_s=PATIENCE_S)
    assert verdict.recover is RecoveryStep.PLANNING
    assert verdict.failure is FailureCategory.UNREACHABLE
    finished_after_all = replace(lost, state=ScriptState.FINISHED)
    assert review(recovered(finished_after_all, DONE), patience_s=PATIENCE_S).state is MissionState.COMPLETED


def test_a_robot_that_was_lost_by_mistake_and_is_found_is_planned_with_again() -> None:
    lost = replace(AT_WORK, abandoned=True, state=ScriptState.CANCELLED, script_id="script-1")
    found = replace(lost, found=True)
    assert left_out([lost.trouble]).robots == {"yard_1"}
    assert left_out([found.trouble, found.trouble]) == LeftOut()
    stuck = recovered(found, step=RecoveryStep.STUCK, no_way="no plan was found", policy=Policy.ASK)
    verdict = review(stuck, patience_s=PATIENCE_S)
    assert verdict.reason == "yard_1: was given up as lost and has been found; no plan was found"


def test_a_mission_whose_goals_are_true_is_completed_though_a_robot_failed_afterwards() -> None:
    verdict = review(recovered(FAILED, DONE, missed=()), patience_s=PATIENCE_S)
    assert verdict.state is MissionState.COMPLETED


def test_a_mission_past_its_deadline_goes_on_as_overdue() -> None:
    early = review(mission(AT_WORK, now_s=10.0, deadline_s=40.0), patience_s=PATIENCE_S)
    assert (early.failure, early.is_overdue, early.wait_s) == (None, False, 30.0)
    late = review(mission(AT_WORK, now_s=41.0, deadline_s=40.0), patience_s=PATIENCE_S)
    assert (late.state, late.failure) == (MissionState.RUNNING, FailureCategory.DEADLINE)
    assert late.cancel == ()
    assert late.is_overdue


def test_another_failure_comes_before_the_deadline() -> None:
    view = mission(FAILED, now_s=41.0, deadline_s=40.0, policy=Policy.ASK, tries_left=1)
    assert review(view, patience_s=PATIENCE_S).failure is FailureCategory.WORLD_CHANGED
