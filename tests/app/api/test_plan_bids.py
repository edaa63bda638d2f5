"""Robots are asked for bids for a proposed plan over the API."""

from fastapi.testclient import TestClient

from tests.app.api.test_main_job import Follow, planned


def test_a_plan_is_put_to_the_robots_until_it_is_decided(api: TestClient, follow: Follow) -> None:
    path = f"/v1/plans/{planned(api, follow)['plan_id']}"
    assert api.get(f"{path}/bids").json()["items"] == []
    called = api.post(f"{path}:call_for_bids")
    assert called.status_code == 202, called.text
    again = api.post(f"{path}:call_for_bids")
    assert again.status_code in (202, 409), again.text  # 409 until all have answered
    parts = api.get(f"{path}/bids").json()["items"]
    assert {bid["robot"] for bid in parts[0]["bids"]} == {"yard_1", "yard_2", "store_1", "store_2"}
    assert {part["cheapest"] for part in parts} == {None}
    assert api.post(f"{path}:reject", json={}).status_code == 202
    answer = api.post(f"{path}:call_for_bids")
    assert answer.status_code == 409
    assert "robots bid for proposed plans only" in answer.json()["detail"]
    assert api.post("/v1/plans/nowhere:call_for_bids").status_code == 404
