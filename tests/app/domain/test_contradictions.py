"""Which reports of robots on one plan fit together."""

from dataclasses import replace
from typing import Any

import pytest

from app.domain.contradictions import CLOCKS_S, HELD_S, Contradiction, Parts, contradictions, told_of
from app.domain.plausibility import doubt_of_order
from planner import Keeping, PlanNet
from tests.app.sample_store import Store

STORE = Store()
SENSED = STORE.store_sample_1()
CLEARED = replace(
    SENSED,
    orderings=tuple(
        replace(one, kept_by=Keeping.CLEARANCE) if one.kept_by is Keeping.SENSING else one
        for one in SENSED.orderings
    ),
)
RELEASE = next(a.id for a in SENSED.actions if a.tag == "RELEASE2" and a.agents == ("yard_1",))
BRING = next(a.id for a in SENSED.actions if a.tag == "TRANSPORT" and a.agents == ("yard_1",))
DOCK = next(a.id for a in SENSED.actions if a.tag == "DOCK" and a.agents == ("store_2",))


def running(at_s: float) -> dict[str, Any]:
    return {"state": "running", "at_s": at_s, "started_at_s": at_s}


def finished(at_s: float, **more: Any) -> dict[str, Any]:
    return {"state": "finished", "at_s": at_s, "finished_at_s": at_s} | more


def parts(**known: dict[str, Any]) -> Parts:
    robots = {RELEASE: "yard_1", BRING: "yard_1", DOCK: "store_2"}
    return {(action, robots[action]): told for action, told in known.items()}


def found(net: PlanNet, known: Parts) -> list[Contradiction]:
    return list(contradictions(net, known, plan_id="plan-1"))


@pytest.mark.parametrize("late_s", [-5.0, 0.0, CLOCKS_S])
def test_a_packet_that_begins_after_what_it_waits_for_contradicts_nothing(late_s: float) -> None:
    known = parts(**{RELEASE: finished(20.0, started_at_s=15.0), DOCK: running(20.0 - late_s)})
    assert found(CLEARED, known) == []


@pytest.mark.parametrize("told", [running(18.0), finished(18.0), finished(30.0, claimed_at_s=18.0)])
def test_gripping_before_the_other_has_released_is_a_contradiction(told: dict[str, Any]) -> None:
    (one,) = found(CLEARED, parts(**{RELEASE: finished(20.0), DOCK: told}))
    assert (one.later.robot, one.later.at_s) == ("store_2", 18.0)
    assert (one.earlier.robot, one.earlier.at_s) == ("yard_1", 20.0)
    assert one.things == ("sample_1",)
    assert (
        f"store_2 reports to have {'begun' if told != finished(18.0) else 'ended'} {DOCK} DOCK at 18.0 s"
        in str(one)
    )
    assert f"but yard_1 reports to have ended {RELEASE} RELEASE2 at 20.0 s" in str(one)
    assert Contradiction.from_json(one.to_json()) == one


@pytest.mark.parametrize(("known", "said"), [({}, "has reported nothing"), (running(9.0), "have begun")])
def test_gripping_what_has_not_been_reported_released_is_a_contradiction(
    known: dict[str, Any], said: str
) -> None:
    (one,) = found(CLEARED, parts(**{DOCK: running(18.0)}, **({RELEASE: known} if known else {})))
    assert said in str(one)


def test_a_packet_that_has_only_been_claimed_and_does_not_run_contradicts_nothing() -> None:
    waiting = {"state": "waiting", "claimed_at_s": 18.0}
    assert found(CLEARED, parts(**{RELEASE: finished(20.0), DOCK: waiting})) == []


def test_an_end_that_follows_from_the_script_alone_is_no_later_than_that() -> None:
    implied = finished(60.0, implied=True)
    assert found(CLEARED, parts(**{RELEASE: implied, DOCK: running(18.0)})) == []
    begun = implied | {"started_at_s": 25.0}
    assert len(found(CLEARED, parts(**{RELEASE: begun, DOCK: running(18.0)}))) == 1


def test_a_robot_may_sense_a_result_before_the_end_of_the_action_but_not_before_it_begins() -> None:
    slow = {RELEASE: finished(40.0, started_at_s=15.0)}
    assert found(SENSED, parts(**slow, **{DOCK: running(18.0)})) == []
    (one,) = found(SENSED, parts(**slow, **{DOCK: running(12.0)}))
    assert one.later.at_s == 12.0


def test_a_robot_that_still_brings_the_sample_has_not_begun_to_release_it() -> None:
    (one,) = found(SENSED, parts(**{BRING: finished(14.0), DOCK: running(12.0)}))
    assert one.earlier == told_of(SENSED, parts(**{BRING: finished(14.0)}), RELEASE, "yard_1")
    assert found(SENSED, parts(**{BRING: finished(14.0, implied=True), DOCK: running(12.0)})) == []
    assert found(SENSED, parts(**{BRING: finished(11.0), DOCK: running(12.0)})) == []


def test_a_claim_without_clearance_is_held_back_for_a_while() -> None:
    begun = told_of(CLEARED, {}, DOCK, "store_2")
    missing = [told_of(CLEARED, {}, RELEASE, "yard_1")]
    doubt = doubt_of_order(begun, missing, at_s=10.0, now_s=12.0)
    assert doubt == (
        f"reports {DOCK} DOCK at 10.0 s without clearance, but yard_1 has reported nothing of {RELEASE} RELEASE2"
    )
    assert doubt_of_order(begun, missing, at_s=10.0, now_s=10.0 + HELD_S) == ""
