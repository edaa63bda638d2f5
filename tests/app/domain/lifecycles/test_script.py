from typing import Any

import pytest

from app.domain.errors import IllegalTransition
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.script import (
    TERMINAL_SCRIPTS,
    Delivery,
    abandon,
    acknowledge,
    end,
    follow_order,
    has_failed,
    hear,
    order,
    refuse,
    reissue_if_diverged,
    release_abandoned,
    unanswered_order,
    withdraw,
)
from robots.wire import Control, ControlVerb, FailureCategory, ScriptState
from tests.app.domain.lifecycles.records import PlainMission, PlainScript

CANCEL, PAUSE, RESUME = ControlVerb.CANCEL, ControlVerb.PAUSE, ControlVerb.RESUME


def script(state: str | None = "running", **more: Any) -> PlainScript:
    return PlainScript(state=state, **{"delivery": Delivery.ACKNOWLEDGED, **more})


def finish(script: PlainScript, state: ScriptState = ScriptState.FINISHED, at_s: float = 9.0) -> None:
    end(script, state, at_s=at_s, detail="", category=None, perceived=())


@pytest.mark.parametrize("delivery", [Delivery.ACKNOWLEDGED, Delivery.REFUSED, Delivery.WITHDRAWN])
def test_a_script_is_answered_once(delivery: Delivery) -> None:
    with pytest.raises(IllegalTransition):
        acknowledge(script(delivery=delivery))
    with pytest.raises(IllegalTransition):
        refuse(script(delivery=delivery), "busy")


def test_a_refused_script_has_failed_for_the_robots_reason() -> None:
    refused = PlainScript()
    refuse(refused, "busy")
    assert (refused.delivery, refused.detail) == (Delivery.REFUSED, "busy")
    assert has_failed(refused)


def test_a_script_that_was_cancelled_on_its_way_and_is_refused_is_withdrawn() -> None:
    dropped = PlainScript()
    order(dropped, CANCEL)
    refuse(dropped, "stale")
    assert (dropped.delivery, dropped.state, dropped.detail) == (
        Delivery.WITHDRAWN,
        ScriptState.CANCELLED,
        "",
    )


def test_what_a_robot_said_last_counts_not_what_arrived_last() -> None:
    heard = script(None)
    hear(heard, "running", 5.0)
    hear(heard, "paused", 4.0)
    assert (heard.state, heard.heard_at_s) == ("running", 5.0)
    hear(heard, "paused", 5.0)
    assert heard.state == "paused"


@pytest.mark.parametrize("state", sorted(TERMINAL_SCRIPTS))
def test_a_script_ends_once(state: ScriptState) -> None:
    ended = script(state)
    hear(ended, "running", 99.0)
    assert (ended.state, ended.heard_at_s) == (state, 99.0)
    for other in TERMINAL_SCRIPTS - {state}:
        with pytest.raises(IllegalTransition):
            finish(ended, other)


def test_nothing_is_sent_about_a_script_that_has_ended() -> None:
    ended = script(question="q", clearance="clearance:1", heard_at_s=12.0)
    order(ended, PAUSE)
    finish(ended)
    assert (ended.question, ended.clearance, unanswered_order(ended)) == (None, None, None)
    assert ended.heard_at_s == 12.0


@pytest.mark.parametrize(
    ("stopping", "delivery"), [(False, Delivery.ACKNOWLEDGED), (True, Delivery.WITHDRAWN)]
)
def test_the_end_of_a_script_whose_answer_was_lost_says_what_became_of_it(
    stopping: bool, delivery: Delivery
) -> None:
    unanswered = PlainScript(stopping=stopping)
    finish(unanswered)
    assert unanswered.delivery == delivery


def test_each_order_has_a_greater_number_and_takes_the_place_of_the_one_before() -> None:
    ordered = script()
    given = []
    for verb in (PAUSE, RESUME, PAUSE, CANCEL):
        order(ordered, verb)
        given.append(unanswered_order(ordered))
    assert given == [
        Control(script_id="m-fred", verb=verb, number=number)
        for number, verb in enumerate((PAUSE, RESUME, PAUSE, CANCEL), start=1)
    ]
    assert ordered.stopping


def test_an_order_keeps_its_number_though_the_robot_knows_of_greater_ones() -> None:
    ordered = script()
    order(ordered, PAUSE)
    ordered.orders = 7  # as the robot says
    assert unanswered_order(ordered) == Control(script_id="m-fred", verb=PAUSE, number=1)


@pytest.mark.parametrize(("verb", "state"), [(PAUSE, "paused"), (RESUME, "running"), (CANCEL, "accepted")])
def test_a_robot_that_has_agreed_to_an_order_stands_as_ordered(verb: ControlVerb, state: str) -> None:
    ordered = script("accepted")
    order(ordered, verb)
    follow_order(ordered, verb, 3.0)
    assert (ordered.state, unanswered_order(ordered)) == (state, None)


@pytest.mark.parametrize(
    ("stands", "mission", "ordered"),
    [
        ("paused", "running", RESUME),
        ("paused", "unknown", RESUME),
        ("running", "paused", PAUSE),
        ("accepted", "paused", PAUSE),
        ("running", "running", None),
        ("paused", "paused", None),
        ("finished", "paused", None),
        ("paused", "cancelled", None),
    ],
)
def test_a_robot_that_stands_otherwise_than_its_mission_is_ordered_again(
    stands: str, mission: str, ordered: ControlVerb | None
) -> None:
    diverged = script(stands)
    reissue_if_diverged(diverged, PlainMission(state=mission))
    again = unanswered_order(diverged)
    assert (again and again.verb) == ordered


@pytest.mark.parametrize(
    "more",
    [
        {"control": "pause", "control_number": 4},
        {"stopping": True},
        {"abandoned": True},
        {"plan_id": "before"},
        {"delivery": Delivery.PENDING},
    ],
    ids=[
        "an order is out",
        "it is to stop",
        "it is lost",
        "its plan is not carried out any longer",
        "the robot has not agreed to it",
    ],
)
def test_nothing_is_ordered_again_where(more: dict[str, Any]) -> None:
    diverged = script("paused", **more)
    before = unanswered_order(diverged)
    reissue_if_diverged(diverged, PlainMission(state=MissionState.RUNNING))
    assert unanswered_order(diverged) == before


def test_an_abandoned_script_is_cancelled_until_its_world_starts_again() -> None:
    lost = script(question="q", clearance="clearance:1")
    abandon(lost)
    cancel = unanswered_order(lost)
    assert cancel is not None
    assert cancel.verb is CANCEL
    assert (lost.question, lost.clearance) == (None, None)
    abandon(lost)
    assert unanswered_order(lost) == cancel
    release_abandoned(lost)
    assert (lost.delivery, lost.abandoned, unanswered_order(lost)) == (Delivery.WITHDRAWN, False, None)


@pytest.mark.parametrize(
    ("before", "after"),
    [(Delivery.PENDING, Delivery.WITHDRAWN), (Delivery.ACKNOWLEDGED, Delivery.ACKNOWLEDGED)],
)
def test_with_its_mission_a_script_on_its_way_is_withdrawn(before: Delivery, after: Delivery) -> None:
    left = PlainScript(delivery=before, category=FailureCategory.ROBOT)
    withdraw(left)
    assert left.delivery == after
