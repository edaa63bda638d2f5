"""The service's end of one robot's topics, with everything that the robot says kept in order."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from pydantic import ValidationError

from robots.link.mqtt.session import Publication
from robots.link.mqtt.topics import SERVICE, Channel, robot_and_channel, robot_topic
from robots.wire import Body, Message, Performative, new_message_id

POLL_S = 0.1
RUN = "run-of-the-check"
ANOTHER_RUN = "run-of-another-world"


class Broker(Protocol):
    """What passes between the check and the robot. Its time is the world's, too."""

    def publish(self, publication: Publication) -> None: ...

    def receive(self, timeout_s: float) -> Sequence[Publication]:
        """What has arrived, waiting up to `timeout_s` for the first; announces the world meanwhile."""
        ...

    def now_s(self) -> float: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """A publication of the robot, and the message that it carries; None if it is none, and `fault` says why."""

    channel: Channel
    publication: Publication
    message: Message | None
    fault: str = ""


class Line:
    """Sends to one robot and hears it. Reports get their receipts unless `withholds_receipts`."""

    def __init__(self, broker: Broker, world: str, robot: str) -> None:
        self._broker = broker
        self._world = world
        self.robot = robot
        self.heard: list[Heard] = []
        self.withholds_receipts = False

    def now_s(self) -> float:
        return self._broker.now_s()

    def send(
        self,
        performative: Performative,
        body: Body | dict[str, Any],
        *,
        message_id: str | None = None,
        reply: str | None = None,
        run: str = RUN,
        channel: Channel = Channel.INSTANT_ACTIONS,
    ) -> str:
        """Send a message; the id that it has."""
        known = message_id or new_message_id()
        message = {
            "id": known,
            "performative": performative.value,
            "sender": SERVICE,
            "receiver": self.robot,
            "sent_at_s": self.now_s(),
            "in_reply_to": reply,
            "body": body if isinstance(body, dict) else body.model_dump(mode="json"),
        }
        self._broker.publish(
            Publication(
                topic=robot_topic(self._world, self.robot, channel),
                payload=json.dumps(message).encode(),
                run=run,
            )
        )
        return known

    def until(self, holds: Callable[[], Any], within_s: float) -> bool:
        """Hear the robot until that holds; False if it does not within that time."""
        end_s = self.now_s() + within_s
        while not holds():
            if self.now_s() >= end_s:
                return False
            self._hear(POLL_S)
        return True

    def listen(self, for_s: float) -> None:
        """Hear the robot for some time."""
        self.until(lambda: False, for_s)

    def messages(self, since: int = 0) -> Sequence[Message]:
        """The robot's valid messages, from the heard publication of that number on."""
        return [one.message for one in self.heard[since:] if one.message is not None]

    def answer(self, request: str) -> Message | None:
        """The first answer to a request."""
        return next((one for one in self.messages() if one.in_reply_to == request), None)

    def confirm(self, report: str) -> None:
        """Send the receipt of a report."""
        self.send(Performative.CONFIRM, {"kind": "receipt"}, reply=report)

    def _hear(self, timeout_s: float) -> None:
        for publication in self._broker.receive(timeout_s):
            robot, channel = robot_and_channel(publication.topic) or ("", Channel.STATE)
            if robot != self.robot:
                continue
            heard = _read(channel, publication)
            self.heard.append(heard)
            message = heard.message
            if message is None or message.in_reply_to is not None or self.withholds_receipts:
                continue
            self.confirm(message.id)


def _read(channel: Channel, publication: Publication) -> Heard:
    if channel in (Channel.VISUALIZATION, Channel.CONNECTION) or not publication.payload:
        return Heard(channel=channel, publication=publication, message=None)
    try:
        message = Message.model_validate_json(publication.payload)
    except ValidationError as error:
        fault = error.errors(include_url=False, include_input=False)[0]
        where = [str(part) for part in fault["loc"] if not str(part).startswith("tagged-union")]
        return Heard(
            channel=channel,
            publication=publication,
            message=None,
            fault=f"{'.'.join(where) or 'payload'}: {fault['msg']}",
        )
    return Heard(channel=channel, publication=publication, message=message)
