"""What packets bring is attached to the mission, told by an event, and kept in the recording."""

import io
from base64 import b64encode
from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from robots.wire import ImageResult, ReadingResult
from tests.app.fake_robots import FakeTeam
from tests.waiting import read_until

Follow = Callable[..., dict[str, Any]]
PNG = b"\x89PNG\r\n\x1a\n and what follows"


def test_a_missions_results_are_listed_shown_told_and_recorded(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.brings["RELEASE2"] = (
        ImageResult(name="camera", of="bay_7", media_type="image/png", data=PNG),
        ReadingResult(name="light_lx", of="bay_7", value=412.0, unit="lx"),
    )
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    mission = follow(f"/v1/goals/{goal['id']}", "finished")["mission_id"]
    path = f"/v1/missions/{mission}"
    listed = api.get(f"{path}/results").json()["items"]
    assert [one["kind"] for one in listed].count("image") == 2, "two robots hand the sample over"
    items = {one["kind"]: one for one in listed}
    image = items["image"]
    assert {"name": "camera", "of": "bay_7", "size_bytes": len(PNG), "value": None}.items() <= image.items()
    assert {"name": "light_lx", "value": 412.0, "unit": "lx"}.items() <= items["reading"].items()

    shown = api.get(f"{path}/results/{image['id']}")
    assert shown.content == PNG
    assert shown.headers["content-type"] == "image/png"
    assert shown.headers["x-content-type-options"] == "nosniff"
    assert shown.headers["content-disposition"] == f'inline; filename="{image["id"]}.png"'
    assert api.get(f"{path}/results/{items['reading']['id']}").json() == items["reading"]
    assert api.get(f"{path}/results/{image['id']}", headers={"authorization": ""}).status_code == 401
    assert api.get(f"{path}/results/result-unknown").json()["type"].endswith("unknown-result")
    assert api.get("/v1/missions/mission-unknown/results").status_code == 404

    replay = read_until(  # an event is written after the result that it tells of
        api, f"{path}/replay", lambda replay: len(_told(replay)) >= len(listed)
    )
    assert {(one["result"], one["value"]) for one in _told(replay)} == {
        (one["id"], one["value"]) for one in listed
    }
    recorded = {one["id"]: one for one in replay["results"]}
    assert recorded[image["id"]] == {**image, "image": f"data:image/png;base64,{b64encode(PNG).decode()}"}
    assert recorded[items["reading"]["id"]] == items["reading"]
    reader = make_reader(
        io.BytesIO(api.get(f"{path}/recording").content), decoder_factories=[DecoderFactory()]
    )
    topic = f"/images/{image['robot']}/camera"
    ((schema, _, _, message),) = reader.iter_decoded_messages(topics=[topic])
    assert schema.name == "foxglove.CompressedImage"
    assert (message.data, message.format, message.frame_id) == (PNG, "png", image["robot"])


def _told(replay: dict[str, Any]) -> list[dict[str, Any]]:
    return [one["data"] for one in replay.get("events", ()) if one["type"] == "packet.result"]
