from collections.abc import Callable

import pytest

from app.domain.errors import IllegalTransition
from app.domain.lifecycles.mission import (
    ENDED,
    MissionState,
    active_state,
    assess,
    begin_work,
    dispatch,
    end,
    full_reason,
    pause,
    resume,
)
from tests.app.domain.lifecycles.records import PlainMission

WORKING = (MissionState.DISPATCHING, MissionState.RUNNING, MissionState.UNKNOWN, MissionState.RECOVERING)
GOING_ON = (MissionState.PENDING, *WORKING)


def judge(mission: PlainMission, state: MissionState, reason: str = "") -> None:
    assess(mission, state, reason=reason, failure=None, is_overdue=False)


def finish(mission: PlainMission, state: MissionState = MissionState.COMPLETED) -> None:
    end(mission, state, reason="over", failure=None, ended_at_s=7.0)


def allowed(present: MissionState, change: Callable[[PlainMission], None]) -> bool:
    mission = PlainMission(state=present)
    try:
        change(mission)
    except IllegalTransition:
        assert mission == PlainMission(state=present)
        return False
    return True


def test_a_mission_that_goes_well_is_dispatched_runs_and_completes() -> None:
    mission = PlainMission()
    dispatch(mission)
    assert begin_work(mission)
    assert not begin_work(mission)
    assert mission.state == MissionState.RUNNING
    finish(mission)
    assert (mission.state, mission.reason, mission.ended_at_s) == (MissionState.COMPLETED, "over", 7.0)


@pytest.mark.parametrize("ended", sorted(ENDED))
@pytest.mark.parametrize(
    "change",
    [dispatch, pause, resume, finish, lambda mission: judge(mission, MissionState.RUNNING)],
    ids=["dispatch", "pause", "resume", "end", "assess"],
)
def test_an_ended_mission_changes_no_more(
    ended: MissionState, change: Callable[[PlainMission], None]
) -> None:
    assert not allowed(ended, change)


@pytest.mark.parametrize(
    ("target", "sources"),
    [
        (MissionState.RUNNING, {MissionState.DISPATCHING, MissionState.UNKNOWN}),
        (MissionState.UNKNOWN, {MissionState.DISPATCHING, MissionState.RUNNING, MissionState.RECOVERING}),
        (MissionState.RECOVERING, {MissionState.DISPATCHING, MissionState.RUNNING, MissionState.UNKNOWN}),
    ],
)
def test_the_monitor_can_bring_a_mission_to(target: MissionState, sources: set[MissionState]) -> None:
    found = {state for state in GOING_ON if allowed(state, lambda mission: judge(mission, target))}
    assert found == {*sources, target}  # that it stays as it is is no transition


def test_only_a_mission_whose_scripts_were_made_can_complete() -> None:
    for state in (MissionState.COMPLETED, MissionState.PARTIALLY_COMPLETED):
        found = {one for one in GOING_ON if allowed(one, lambda mission, to=state: finish(mission, to))}  # type: ignore[misc]
        assert found == set(WORKING)


@pytest.mark.parametrize("state", GOING_ON)
def test_a_paused_mission_resumes_to_the_state_it_had(state: MissionState) -> None:
    mission = PlainMission(state=state)
    pause(mission)
    assert (mission.state, active_state(mission)) == (MissionState.PAUSED, state)
    with pytest.raises(IllegalTransition):
        pause(mission)
    resume(mission)
    assert (mission.state, mission.resume_to) == (state, None)
    with pytest.raises(IllegalTransition):
        resume(mission)


def test_what_happens_during_a_pause_changes_the_state_to_resume_to() -> None:
    mission = PlainMission(state=MissionState.RUNNING)
    pause(mission)
    judge(mission, MissionState.PAUSED, "paused by the operator")
    assert (active_state(mission), mission.reason) == (MissionState.RUNNING, "paused by the operator")
    judge(mission, MissionState.RECOVERING)
    assert (mission.state, active_state(mission)) == (MissionState.PAUSED, MissionState.RECOVERING)
    with pytest.raises(IllegalTransition):
        judge(mission, MissionState.RUNNING)
    assert not begin_work(mission)
    resume(mission)
    assert mission.state == MissionState.RECOVERING


def test_an_overdue_mission_says_so_until_it_ends() -> None:
    mission = PlainMission(state=MissionState.RUNNING)
    assess(mission, MissionState.RUNNING, reason="no message from fred", failure=None, is_overdue=True)
    judge(mission, MissionState.UNKNOWN, "no answer from fred")
    assert full_reason(mission) == "no answer from fred; its deadline has passed"
    finish(mission)
    assert full_reason(mission) == "over"
