"""The plan body of the API."""

import json
from dataclasses import replace

import pytest

from app.domain.plan_document import PlanBody
from planner import PlanNet, PlanningResult, PlanningStatus
from robots.wire import SymbolicFact
from tests.app.sample_store import Store

STORE = Store()


def two_robots_one_after_the_other() -> PlanNet:
    """Stores a sample, then brings another out over the same interchange."""
    return STORE.plan(
        [
            *STORE.carry("yard_1", "sample_1", "door_1", "interchange_1", came_from="home_yard_1"),
            *STORE.carry("store_1", "sample_1", "interchange_1", "bay_1", came_from="home_store_1"),
            *STORE.carry("store_1", "sample_2", "bay_2", "interchange_1", came_from="bay_1"),
            *STORE.carry("yard_1", "sample_2", "interchange_1", "door_2"),
        ],
        "in(sample_1, bay_1)",
        "in(sample_2, door_2)",
    )


def goal_that_is_true_already() -> PlanNet:
    return STORE.plan([], "in(sample_2, bay_2)", "near(yard_1, home_yard_1)")


@pytest.mark.parametrize(
    "net", [STORE.store_sample_1(), two_robots_one_after_the_other(), goal_that_is_true_already()]
)
def test_a_plan_net_comes_back_from_json_as_it_was(net: PlanNet) -> None:
    text = PlanBody.of_plan_net(net, STORE.base, id="plan-1").model_dump_json()
    assert PlanBody.model_validate_json(text).to_plan_net(STORE.base) == net


def test_facts_are_shown_in_the_form_that_goals_are_stated_in() -> None:
    body = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base)
    assert body.goals == (SymbolicFact(predicate="in", args=("sample_1", "bay_7")),)
    dock = next(action for action in body.actions if action.tag == "DOCK")
    assert SymbolicFact(predicate="in", args=("sample_1", "door_1")) in dock.deletes
    assert SymbolicFact(predicate="at", args=("yard_1", "door_1")) in dock.intended_effects
    assert "object_position" not in body.model_dump_json()


def test_time_windows_and_the_whole_span_are_the_plan_nets() -> None:
    net = STORE.store_sample_1()
    body = PlanBody.of_plan_net(net, STORE.base)
    assert body.makespan_s == net.makespan_s
    for shown, action in zip(body.actions, net.actions, strict=True):
        assert shown.earliest_end_s == action.earliest_end_s
        assert shown.slack_s == action.slack_s


def test_what_the_plan_takes_is_shown_by_action_and_in_all() -> None:
    net = two_robots_one_after_the_other()
    body = PlanBody.of_plan_net(net, STORE.base)
    assert body.distance_m == pytest.approx(sum(action.distance_m for action in body.actions))
    assert body.energy_j == pytest.approx(sum(action.energy_j for action in body.actions))
    drives = {action.tag for action in body.actions if action.distance_m > 0}
    assert drives == {"NAVIGATE", "TRANSPORT"}
    assert body.critical_path == net.critical_path
    assert set(body.critical_path) <= {action.id for action in body.actions if action.critical}


def test_a_goal_after_its_deadline_is_shown_and_comes_back() -> None:
    net = STORE.store_sample_1()
    late = replace(net, late={net.goals[0]: 12.5})
    body = PlanBody.of_plan_net(late, STORE.base)
    assert [(str(one.goal), one.late_s) for one in body.late] == [(str(body.goals[0]), 12.5)]
    assert PlanBody.model_validate_json(body.model_dump_json()).to_plan_net(STORE.base) == late


def test_a_body_recorded_before_these_figures_were_known_can_still_be_read() -> None:
    body = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base).model_dump(mode="json")
    for name in ("distance_m", "energy_j", "critical_path", "late"):
        del body[name]
    for action in body["actions"]:
        del action["distance_m"], action["energy_j"], action["critical"]
    assert PlanBody.model_validate(body).to_plan_net(STORE.base).energy_j == 0.0


def test_an_engines_result_gives_its_name_time_and_bound() -> None:
    result = PlanningResult(
        status=PlanningStatus.SOLVED,
        engine="by hand",
        planning_s=0.25,
        plan_net=STORE.store_sample_1(),
        lower_bound_s=40.0,
    )
    body = json.loads(
        PlanBody.of_result(result, STORE.base, id="plan-1", world="sample_store").model_dump_json()
    )
    assert (body["engine"], body["planning_s"], body["lower_bound_s"]) == ("by hand", 0.25, 40.0)
    assert (body["id"], body["world"], body["state"]) == ("plan-1", "sample_store", "proposed")


def test_a_result_without_a_plan_has_no_body() -> None:
    result = PlanningResult(
        status=PlanningStatus.UNSOLVABLE, engine="by hand", planning_s=0.1, reason="no robot reaches bay_13"
    )
    with pytest.raises(ValueError, match="no robot reaches bay_13"):
        PlanBody.of_result(result, STORE.base)
