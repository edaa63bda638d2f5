"""A simulation that is built while the service already knows its world."""

import threading
from collections.abc import Callable

import pytest

from app.agents.late_simulation import LateSimulation
from app.domain.errors import Unavailable
from robots.link import LinkClosed
from robots.wire import Message, Performative, Telemetry
from tests.waiting import until

MESSAGE = Message(
    id="1",
    sender="service",
    receiver="yard_1",
    performative=Performative.INFORM,
    sent_at_s=0.0,
    body=Telemetry(at_s=0.0, x_m=0.0, y_m=0.0, heading_rad=0.0),
)


class Built:
    """A simulation that says what was done with it."""

    run = "run-1"
    not_resumed_because = "its snapshot is torn"

    def __init__(self) -> None:
        self.paused = True
        self.stopped = False
        self.sent: list[Message] = []

    def pause(self, paused: bool = True) -> None:
        self.paused = paused

    def stop(self) -> None:
        self.stopped = True

    def now_s(self) -> float:
        return 7.0

    def send(self, message: Message) -> None:
        self.sent.append(message)

    def receive(self, timeout_s: float = 0.0) -> list[Message]:
        return [MESSAGE]

    def close(self) -> None: ...


def late(built: Built, may_build: threading.Event | None = None, began_s: float = 0.0) -> LateSimulation:
    def start(tell: Callable[[str], None]) -> Built:
        tell("walls are put up")
        if may_build is not None:
            may_build.wait()
        return built

    return LateSimulation("hall", start, began_s=began_s)


def test_the_clock_of_a_resumed_world_stands_where_it_was_until_it_is_built() -> None:
    may_build = threading.Event()
    world = late(Built(), may_build, began_s=6.5)
    assert world.now_s() == 6.5
    may_build.set()
    until(lambda: world.now_s() == 7.0)
    world.close()


def test_nothing_passes_before_its_run_is_taken_up() -> None:
    built, may_build = Built(), threading.Event()
    world = late(built, may_build)
    until(lambda: world.doing == "walls are put up")
    world.send(MESSAGE)
    assert (world.run, world.now_s(), world.receive()) == (None, 0.0, ())
    may_build.set()
    until(lambda: world.run == "run-1")
    world.send(MESSAGE)
    assert (world.taken_up, world.now_s(), world.receive(), built.sent) == (None, 7.0, (), [])
    assert built.paused
    world.take_up("run-1")
    world.send(MESSAGE)
    assert (world.taken_up, world.receive(), built.sent) == ("run-1", [MESSAGE], [MESSAGE])
    assert not built.paused
    assert world.new_run_reason == "its snapshot is torn"
    world.close()
    assert built.stopped


def test_one_that_is_closed_while_it_is_built_is_stopped_once_it_is() -> None:
    built, may_build = Built(), threading.Event()
    world = late(built, may_build)
    closing = threading.Thread(target=world.close)
    closing.start()
    with pytest.raises(LinkClosed, match="was removed"):
        until(world.receive)
    may_build.set()
    closing.join()
    until(lambda: built.stopped)
    assert world.run is None


@pytest.mark.parametrize(
    ("error", "words"),
    [(Unavailable("no room for the walls"), "no room for the walls"), (KeyError("x"), "log says why")],
)
def test_one_that_cannot_be_built_says_why(error: Exception, words: str) -> None:
    def start(_: Callable[[str], None]) -> Built:
        raise error

    world = LateSimulation("hall", start)
    until(lambda: world.failure)
    assert words in world.failure
    with pytest.raises(LinkClosed, match=words):
        world.receive()
    world.close()
