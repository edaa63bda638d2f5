"""On a topic for speech only the robot that it names is believed, and only speech."""

import pytest

from robots.link.mqtt.inbox import Inbox
from robots.link.mqtt.robot_sessions import put_order, robot_publication
from robots.link.mqtt.session import Publication
from robots.wire import Body, Control, ControlVerb, Message, Performative, SpeechAct

HELLO = SpeechAct(content="hello", conversation_id="c")
STOP = Control(script_id="s", verb=ControlVerb.CANCEL)


def message(sender: str, receiver: str, body: Body = HELLO) -> Message:
    return Message(
        performative=Performative.INFORM, sender=sender, receiver=receiver, sent_at_s=0.0, body=body
    )


def test_what_one_robot_says_to_another_goes_over_its_own_topic_for_the_other() -> None:
    publication = robot_publication("hall", message("fred", "ginger"), "run-1")
    assert (publication.topic, publication.qos) == ("macta/v1/hall/fred/speech/ginger", 1)
    inbox = Inbox()
    put_order(publication, inbox, "run-1")
    put_order(publication, inbox, "run-2")
    assert [one.sender for one in inbox.take(0.0)] == ["fred"]
    assert inbox.rejected is None


@pytest.mark.parametrize(
    "said",
    [
        message("basil", "ginger"),
        message("service", "ginger"),
        message("fred", "basil"),
        message("fred", "ginger", STOP),
        message("service", "ginger", STOP),
    ],
    ids=["another robot", "the service", "to another robot", "an order", "an order of the service"],
)
def test_what_the_topic_does_not_allow_is_rejected(said: Message) -> None:
    inbox = Inbox()
    payload = said.model_dump_json().encode()
    put_order(
        Publication(topic="macta/v1/hall/fred/speech/ginger", payload=payload, run="run-1"), inbox, "run-1"
    )
    assert inbox.take(0.0) == ()
    assert inbox.malformed == 1
