"""Operators give robots roles: rules on board, what they are recruited for, and a home."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.cli.role import role
from app.composition import Service
from app.domain.errors import Invalid
from robots.deliberative.terms import Term
from robots.world import load_world
from robots.world.rule_files import shipped_rules
from tests.app.api.test_rules import deliberate, told
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH
from tests.waiting import read_until, until

Follow = Callable[..., dict[str, Any]]
GUARD = "ROLE guard;\nBELIEF(role(guard)) => COMMIT(adoptBelief(on_duty));\n"
NEEDS_STORE_2 = "move sample_1 to bay_7"


def path(robot: str) -> str:
    return f"/v1/robots/{robot}/role"


def give(
    api: TestClient, robot: str, role: str = "guard", headers: dict[str, str] | None = None, **more: Any
) -> Any:
    return api.put(path(robot), json={"role": role, **more}, headers=headers or {})


def problem(answer: Any) -> tuple[int, str]:
    return answer.status_code, answer.json()["type"].rpartition(":")[2]


def stated(api: TestClient, text: str, **more: Any) -> str:
    return f"/v1/goals/{api.post('/v1/goals', json={'text': text, **more}).raise_for_status().json()['id']}"


def home_of(api: TestClient, robot: str) -> str | None:
    layout = api.get("/v1/worlds/sample_store").json()["layout"]
    home: str | None = next(one["home"] for one in layout["robots"] if one["name"] == robot)
    return home


def test_a_robot_is_told_its_role_with_its_rules_and_believes_it(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    mind = deliberate(team)
    before = api.get(path("yard_1"))
    assert (before.headers["etag"], before.json()["role"]) == ('"0"', None)
    given = give(api, "yard_1", tags=["NAVIGATE"], rules=GUARD, comment="at night")
    assert (given.status_code, given.headers["etag"]) == (200, '"1"')
    known = read_until(api, path("yard_1"), lambda one: one["delivery"] == "acknowledged")
    assert (known["role"], known["tags"], known["played"]) == ("guard", ["NAVIGATE"], "guard")
    assert [agent.name for agent in mind.agents] == ["duty"], "the robot had no agent to play it"
    assert Term("role", ("guard",)) in mind.agents[0].beliefs
    assert api.get("/v1/robots/yard_1").json()["role"] == "guard"
    (event,) = told(service, "role.set")
    assert (event["role"], event["tags"], event["actor"]) == ("guard", ["NAVIGATE"], "administrator")
    assert (event["comment"], event["rules_version"]) == ("at night", known["rules_version"])

    ended = api.delete(path("yard_1"), headers={"if-match": '"1"'})
    assert (ended.status_code, ended.json()["role"]) == (200, None)
    read_until(api, path("yard_1"), lambda one: one["delivery"] == "acknowledged" and one["played"] == "")
    assert not mind.agents
    assert [one["role"] for one in told(service, "role.cleared")] == ["guard"]


def test_the_role_stays_while_the_robots_own_rules_are_replaced(api: TestClient, team: FakeTeam) -> None:
    mind = deliberate(team)
    give(api, "yard_1", rules=GUARD).raise_for_status()
    own = {"sentry": "AGENT sentry;\nBELIEF(role(guard)) => COMMIT(adoptBelief(on_watch));\n"}
    api.put("/v1/robots/yard_1/rules", json={"files": own}).raise_for_status()
    ruled = read_until(api, "/v1/robots/yard_1/rules", lambda one: one["delivery"] == "acknowledged")
    assert (ruled["role"], list(ruled["role_files"]), ruled["files"]) == ("guard", ["guard"], own)
    assert [agent.name for agent in mind.agents] == ["sentry"]
    assert Term("role", ("guard",)) in mind.agents[0].beliefs


def test_a_role_of_a_shipped_file_needs_no_text_and_one_without_a_file_is_only_believed(
    api: TestClient, team: FakeTeam
) -> None:
    mind = deliberate(team)
    team_rules = {
        name: shipped_rules()[name].read_text(encoding="utf-8") for name in ("soccer_player", "attacker")
    }
    api.put("/v1/robots/yard_1/rules", json={"files": team_rules}).raise_for_status()
    give(api, "yard_1", "left_defender").raise_for_status()
    ruled = read_until(api, "/v1/robots/yard_1/rules", lambda one: one["delivery"] == "acknowledged")
    assert (set(ruled["role_files"]), mind.role) == ({"left_defender"}, "left_defender")
    sentry = {"files": {"sentry": "AGENT sentry;"}}
    unfit = api.put("/v1/robots/yard_1/rules", json=sentry)
    assert unfit.status_code == 422, "its role's rules need what the player's believe"
    give(api, "yard_1", "porter").raise_for_status()
    api.put("/v1/robots/yard_1/rules", json=sentry).raise_for_status()
    ruled = read_until(api, "/v1/robots/yard_1/rules", lambda one: one["delivery"] == "acknowledged")
    assert (ruled["role"], ruled["role_files"], mind.role) == ("porter", {}, "porter")


@ON_BOTH
def test_a_robot_is_not_recruited_for_what_its_role_leaves_out_and_the_goal_says_so(
    api: TestClient, follow: Follow
) -> None:
    give(api, "store_2", tags=["NAVIGATE"]).raise_for_status()
    goal = stated(api, NEEDS_STORE_2)
    waiting = follow(goal, "waiting")
    assert waiting["reason"].startswith("waits for store_2, which plays guard and is not recruited for ")
    assert "TRANSPORT" in waiting["reason"]
    follow(stated(api, "send store_2 to bay_9"), "planned")
    give(api, "store_2", tags=None).raise_for_status()
    follow(goal, "planned")


def test_a_goal_that_names_a_role_is_for_whoever_plays_it_when_it_is_planned(
    api: TestClient, follow: Follow
) -> None:
    give(api, "yard_1").raise_for_status()
    api.post("/v1/robots/yard_1:take_out_of_service", json={"reason": "cleaning"}).raise_for_status()
    goal = stated(api, "send the guard to door_2")
    assert api.get(goal).json()["goal"] == [{"predicate": "near", "args": ["guard", "door_2"]}]
    assert follow(goal, "waiting")["reason"].startswith("waits for yard_1")
    give(api, "yard_2").raise_for_status()
    both_at_once = follow(goal, "unsolvable")["reason"]  # planned anew, for those that play it now
    assert both_at_once == "yard_1 is near door_2 or yard_2 is near door_2, not both"
    api.delete(path("yard_1")).raise_for_status()
    plan = api.get(
        f"/v1/plans/{follow(stated(api, 'send the guard to door_2'), 'planned')['plan_id']}"
    ).json()
    assert plan["goals"] == [{"predicate": "near", "args": ["yard_2", "door_2"]}]

    give(api, "store_2").raise_for_status()
    both = {"text": "send yard_2 to door_1 with guards", "constraints": {"robots": ["yard_2", "store_1"]}}
    agreed = api.post("/v1/goals:check", json=both).raise_for_status().json()["constraints"]
    assert set(agreed["robots"]) - {*agreed["without"]} == {"yard_2"}, "those that both allow"

    limited = {
        "goal": [{"predicate": "near", "args": ["store_1", "bay_1"]}],
        "constraints": {"without": ["guard"]},
    }
    api.post("/v1/goals", json=limited).raise_for_status()
    only = {
        "goal": [{"predicate": "near", "args": ["yard_1", "door_1"]}],
        "constraints": {"robots": ["guard"]},
    }
    assert problem(api.post("/v1/goals", json=only)) == (422, "constraint-contradicts-goal")


def test_a_role_that_nobody_plays_any_longer_ends_its_goal_with_the_roles_that_there_are(
    api: TestClient, follow: Follow
) -> None:
    refused = api.post("/v1/goals", json={"goal": [{"predicate": "near", "args": ["guard", "door_2"]}]})
    assert problem(refused) == (422, "unknown-robot")
    give(api, "yard_1").raise_for_status()
    give(api, "store_1", "porter").raise_for_status()
    unknown = api.post("/v1/goals", json={"goal": [{"predicate": "near", "args": ["keeper", "door_2"]}]})
    assert "the roles that robots play are guard (yard_1) and porter (store_1)" in unknown.json()["detail"]
    api.post("/v1/robots/yard_1:take_out_of_service", json={"reason": "cleaning"}).raise_for_status()
    goal = stated(api, "send the guard to door_2")
    follow(goal, "waiting")
    api.delete(path("yard_1")).raise_for_status()
    ended = follow(goal, "unsolvable")
    assert "there is no robot 'guard'" in ended["reason"]
    assert "the roles that robots play are porter (store_1)" in ended["reason"]


def test_the_explanation_says_that_a_role_keeps_a_robot_from_an_action(
    api: TestClient, follow: Follow
) -> None:
    give(api, "yard_2", tags=["NAVIGATE"]).raise_for_status()
    plan = follow(stated(api, NEEDS_STORE_2), "planned")["plan_id"]
    told_of = api.get(f"/v1/plans/{plan}/explanation").json()
    reasons = [why for action in told_of["actions"] for why in action["robots"].values()]
    assert any("yard_2 plays guard, which is not recruited for DOCK" in why for why in reasons), reasons
    assert not any("yard_2" in action["robots"] for action in told_of["actions"])


def test_a_plan_that_uses_a_robot_against_its_role_is_out_of_date(api: TestClient, follow: Follow) -> None:
    plan = follow(stated(api, NEEDS_STORE_2), "planned")["plan_id"]
    give(api, "store_2", tags=["NAVIGATE"]).raise_for_status()
    refused = api.post(f"/v1/plans/{plan}:approve", json={})
    assert refused.status_code == 409
    assert "store_2 plays guard now, which is not recruited for" in refused.json()["detail"]


def test_the_home_that_a_role_brings_is_given_back_with_the_role(api: TestClient) -> None:
    give(api, "store_1", home="bay_3").raise_for_status()
    assert home_of(api, "store_1") == "bay_3"
    give(api, "store_1", "porter", home="bay_6").raise_for_status()
    assert home_of(api, "store_1") == "bay_6"
    assert api.get(path("store_1")).json()["home"] == "bay_6"
    api.delete(path("store_1")).raise_for_status()
    assert home_of(api, "store_1") == "home_store_1"


def change(api: TestClient, **edit: Any) -> None:
    body = {"edits": [edit], "reason": "an operator"}
    api.post("/v1/worlds/sample_store/changes", json=body).raise_for_status()


def test_a_home_that_an_operator_has_given_since_outlasts_the_role(api: TestClient) -> None:
    give(api, "store_1", home="bay_3").raise_for_status()
    change(api, edit="change_robot", name="store_1", home="bay_5")
    ended = api.delete(path("store_1")).raise_for_status().json()
    assert (home_of(api, "store_1"), ended["home_kept"]) == ("bay_5", "store_1 has been given bay_5 since")
    give(api, "store_1", home="bay_3").raise_for_status()
    ended = api.delete(path("store_1")).raise_for_status().json()
    assert (home_of(api, "store_1"), ended["home_kept"]) == ("bay_5", ""), "what it was before this role"


def test_a_role_ends_and_the_home_stays_if_the_former_one_is_gone_or_taken(api: TestClient) -> None:
    give(api, "store_1", home="bay_3").raise_for_status()
    change(api, edit="remove_place", name="home_store_1")
    ended = api.delete(path("store_1")).raise_for_status().json()
    assert (ended["role"], home_of(api, "store_1")) == (None, "bay_3")
    assert ended["home_kept"] == "store_1 does not reach home_store_1"
    give(api, "yard_1", home="door_1").raise_for_status()
    change(api, edit="change_robot", name="yard_2", home="home_yard_1")
    assert role(api, "yard_1", None, clear=True) == (
        "yard_1 plays no role; its home stays: home_yard_1 is the home of yard_2"
    )
    assert home_of(api, "yard_1") == "door_1"


def test_a_role_that_does_not_fit_is_refused_and_nothing_of_it_is_done(
    api: TestClient, team: FakeTeam, follow: Follow
) -> None:
    refusals = (
        ({"tags": ["FLY"]}, (422, "unfit-role"), "tags: yard_1 has no packet FLY; its packets: NAVIGATE"),
        ({"home": "bay_3"}, (422, "unfit-role"), "home: yard_1 does not reach bay_3"),
        ({"home": "home_yard_2"}, (409, "home-in-use"), "home: home_yard_2 is the home of yard_2"),
        ({"rules": "AGENT guard;"}, (422, "unfit-rules"), "a role's begin with ROLE guard;"),
        ({"rules": "ROLE guard;\nBELIEF(start) =>"}, (422, "unfit-rules"), "guard:2:17:"),
    )
    for body, expected, words in refusals:
        refused = give(api, "yard_1", **body)
        assert problem(refused) == expected
        assert words in refused.json()["detail"]
    assert problem(give(api, "yard_1", headers={"if-match": '"7"'})) == (412, "role-changed")
    assert give(api, "nobody").status_code == 404
    team.faults.silent.add("yard_1")
    plan = follow(stated(api, "send yard_1 to door_2"), "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).raise_for_status().json()["mission_id"]
    follow(f"/v1/missions/{mission}", "dispatching", "running", "unknown")
    needed = give(api, "yard_1", home="door_1")
    assert problem(needed) == (409, "needed-by-mission")
    assert needed.json()["detail"].startswith("home: mission ")
    assert api.get(path("yard_1")).json()["version"] == 0
    assert give(api, "yard_1", tags=["NAVIGATE"]).status_code == 200, "its home stays"


def test_a_world_file_may_state_a_role(api: TestClient, follow: Follow) -> None:
    robot = {
        "name": "yard_9",
        "compartment": "yard",
        "start": [4, 2.4, 0],
        "rules": {"sentry": "AGENT sentry;"},
        "role": {"name": "guard", "tags": ["NAVIGATE"], "rules": GUARD},
    }
    edit = {"edit": "add_robot", "robot": robot}
    api.post("/v1/worlds/sample_store/changes", json={"reason": "more", "edits": [edit]}).raise_for_status()
    known = api.get(path("yard_9")).json()
    assert (known["version"], known["role"], known["tags"]) == (0, "guard", ["NAVIGATE"])
    assert api.get("/v1/robots/yard_9/rules").json()["role_files"] == {"guard": GUARD}
    api.delete(path("yard_9")).raise_for_status()
    assert api.get(path("yard_9")).json()["role"] is None
    until(lambda: api.get("/v1/robots/yard_9").json()["role"] is None)


def test_the_roles_of_robots_that_are_gone_are_forgotten(api: TestClient) -> None:
    give(api, "yard_2", tags=["NAVIGATE"]).raise_for_status()
    edit = {"edit": "remove_robot", "name": "yard_2"}
    api.post("/v1/worlds/sample_store/changes", json={"reason": "sold", "edits": [edit]}).raise_for_status()
    spec = load_world("sample_store").robot("yard_2").model_dump(mode="json")
    again = {"edit": "add_robot", "robot": spec}
    api.post("/v1/worlds/sample_store/changes", json={"reason": "back", "edits": [again]}).raise_for_status()
    assert api.get(path("yard_2")).json()["role"] is None


def test_the_command_gives_shows_and_ends_a_role_and_says_why_it_may_not(
    api: TestClient, tmp_path: Path
) -> None:
    assert role(api, "yard_1", None) == "yard_1 plays no role"
    rules = tmp_path / "guard.rules"
    rules.write_text(GUARD)
    given = role(api, "yard_1", "guard", tags=["NAVIGATE"], home="door_1", rules=rules)
    assert given.startswith("yard_1 plays guard; recruited for NAVIGATE; home door_1; rules ")
    assert api.get(path("yard_1")).json()["rules"] == GUARD
    with pytest.raises(Invalid, match="yard_1 has no packet FLY"):
        role(api, "yard_1", "guard", tags=["FLY"])
    with pytest.raises(Invalid, match="name the role"):
        role(api, "yard_1", None, home="door_1")
    with pytest.raises(Invalid, match="--clear"):
        role(api, "yard_1", "guard", clear=True)
    assert role(api, "yard_1", None, clear=True) == "yard_1 plays no role"
