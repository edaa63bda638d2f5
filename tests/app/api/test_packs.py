from fastapi.testclient import TestClient


def test_the_service_tells_which_packs_it_runs_with(shared_api: TestClient) -> None:
    body = shared_api.get("/v1/packs").json()
    assert body["next"] is None
    (store,) = body["items"]
    assert (store["name"], store["source"]) == ("store", "ships with Macta")
    assert "TRANSPORT" in store["packets"]
    assert "sample_store" in store["worlds"]
