"""What the robots of a mission have said to each other, over the API."""

from fastapi.testclient import TestClient

from app.composition import Service
from app.domain.events import SpeechHeard, SpeechSaid
from robots.wire import Performative
from tests.app.api.test_main_job import Follow, approved


def heard(mission_id: str, sent_at_s: float) -> SpeechHeard:
    return SpeechHeard(
        subject=mission_id,
        robot="store_2",
        sender="yard_1",
        performative=Performative.INFORM,
        content=f"ended({mission_id}-store_2, a5)",
        protocol="macta-inform",
        conversation="c1",
        sent_at_s=sent_at_s,
        at_s=sent_at_s + 0.2,
        attempt=2,
        answer=Performative.CONFIRM,
        answer_content="noted",
    )


def test_what_robots_have_said_is_listed_as_it_was_said_however_late_it_was_reported(
    service: Service, api: TestClient, follow: Follow
) -> None:
    mission_id = approved(api, follow)["id"]
    assert api.get(f"/v1/missions/{mission_id}/conversation").json()["items"] == []
    with service.database.write() as session:
        for sent_at_s in (8.0, 3.0):
            service.events.append(session, heard(mission_id, sent_at_s))
    items = api.get(f"/v1/missions/{mission_id}/conversation").json()["items"]
    assert [one["sent_at_s"] for one in items] == [3.0, 8.0]
    assert items[0]["content"] == f"ended({mission_id}-store_2, a5)"
    assert (items[0]["sender"], items[0]["robot"], items[0]["answer"]) == ("yard_1", "store_2", "confirm")
    assert items[0]["attempt"] == 2


def test_what_the_service_says_about_the_plan_belongs_to_the_mission(
    service: Service, api: TestClient, follow: Follow
) -> None:
    mission = approved(api, follow)
    said = SpeechSaid(
        subject=mission["plan_id"],
        world="sample_store",
        sender="macta",
        receiver="yard_1",
        performative=Performative.CFP,
        content="call(a)",
        protocol="fipa-contract-net",
        conversation="c2",
        message="m1",
        in_reply_to="",
        speaker="",
        sent_at_s=1.0,
        at_s=1.0,
    )
    with service.database.write() as session:
        service.events.append(session, said)
    (item,) = api.get(f"/v1/missions/{mission['id']}/conversation").json()["items"]
    assert (item["robot"], item["performative"]) == ("yard_1", "cfp")


def test_there_is_no_conversation_of_a_mission_that_is_not_known(api: TestClient) -> None:
    answer = api.get("/v1/missions/nowhere/conversation")
    assert answer.status_code == 404
    assert "nowhere" in answer.json()["detail"]


def test_nobody_reads_a_conversation_without_a_token(service: Service) -> None:
    assert TestClient(service.api).get("/v1/missions/any/conversation").status_code == 401
