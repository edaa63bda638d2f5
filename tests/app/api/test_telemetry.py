"""The stream of what robots tell: all that is new, and little of robots that stand as they stood."""

import asyncio
import threading
from collections.abc import Sequence
from typing import Any, cast

import anyio
import pytest
from fastapi import Request

from app.agents import RobotBoard
from app.api import streams
from app.api.streams import Streams
from app.store.event_log import EventLog
from robots.clock import ManualClock
from robots.wire import Telemetry

FIRST = Telemetry(at_s=1.0, x_m=2.0, y_m=3.0, heading_rad=0.0, ranges_m=(1.0, None), battery=0.9)
LATER = FIRST.model_copy(update={"at_s": 1.1, "battery": 0.8, "sensing_j": 1.0, "sensing_saved_j": 2.0})


class Telling(RobotBoard):
    """Of one robot that says these things in turn, one whenever the stream waits for news; and then it is left."""

    def __init__(self, said: Sequence[Telemetry]) -> None:
        super().__init__([("fred", "yard")], clocks={"yard": ManualClock()})
        self._said = list(said)

    def wait(self, generation: int, timeout_s: float) -> int:
        self.heard("fred", self._said.pop(0))
        return super().wait(generation, timeout_s)

    async def is_disconnected(self) -> bool:
        return not self._said


async def _sent(board: Telling) -> list[dict[str, Any]]:
    """What the stream sends of the robot."""
    telling = Streams(
        events=cast(EventLog, None),
        board=board,
        clocks={"yard": ManualClock()},
        stopping=threading.Event(),
        snapshot=list,
        waiting=anyio.CapacityLimiter(1),
        max_open=1,
    )
    events = telling.telemetry(cast(Request, board), "yard")
    return [event.data["robots"]["fred"] async for event in events if event.data is not None]


@pytest.fixture(autouse=True)
def _at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streams, "TELEMETRY_INTERVAL_S", 0.0)


@pytest.mark.parametrize(
    "news",
    [
        {"x_m": 2.1},
        {"ranges_m": (1.0, 0.9)},
        {"holding": "sample_1"},
        {"charging": True},
        {"driven_by": "ann"},
    ],
)
def test_a_robot_that_stands_as_it_stood_is_sent_again_once_it_has_changed(
    news: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(streams, "AT_REST_INTERVAL_S", 3600.0)
    board = Telling([FIRST, LATER, LATER, LATER.model_copy(update=news), LATER])
    sent = asyncio.run(_sent(board))
    (name,) = news
    assert [told["at_s"] for told in sent] == [1.0, 1.1, 1.1]
    assert sent[1][name] != sent[0][name] == sent[2][name]


def test_a_robot_at_rest_is_sent_now_and_then_as_heard(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streams, "AT_REST_INTERVAL_S", 0.0)
    sent = asyncio.run(_sent(Telling([FIRST, LATER, LATER])))
    assert [told["battery"] for told in sent] == [0.9, 0.8, 0.8]
