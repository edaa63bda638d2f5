"""The loop of a world's process, run in this process and stepped by a manual wall clock."""

from collections.abc import Iterator
from dataclasses import replace
from multiprocessing import Pipe
from types import SimpleNamespace

import pytest

from robots.clock import ManualClock
from robots.executive.breakpoints import Debugging
from robots.link import PipeLink
from robots.wire import Message, Performative, Receipt, StatusQuery, Telemetry, ToldAgent
from robots.world import WorldFile
from sim import SimulationError, Truth
from sim.clock import CONTROL_S
from sim.process.control import AskDebugging, AskTruth, BreakAt, Done, GoOn, Pause, Ready, Stop
from sim.process.debugger import STANDS_AT_MOST_S
from sim.process.world_loop import REST_AFTER_S, REST_S, TELEMETRY_GAP_S, Channels, WorldLoop, WorldOrder
from tests.sim.rig import two_rooms


class LoopUnderTest:
    """A loop with the far ends of its channels."""

    def __init__(
        self, speed: float | None, clock: ManualClock | None = None, world: WorldFile | None = None
    ) -> None:
        self.clock = clock or ManualClock()
        self.now = SimpleNamespace(value=0.0)
        self.control, control = Pipe()
        link, robots_link = Pipe()
        self.link = PipeLink(link)
        file = world or two_rooms(samples={"rock": "corner"})
        order = WorldOrder(world=file, seed=1, speed=speed, jitter_m=0.4)
        self.channels = Channels(control, robots_link, self.now)
        self.loop = WorldLoop(order, self.channels, self.clock)

    def run(self, wall_s: float, step_s: float = 0.05) -> None:
        for _ in range(round(wall_s / step_s)):
            self.clock.advance(step_s)
            self.loop.cycle()

    def answer(self) -> None:
        """Acknowledge what the robots have told, as the service does: they repeat it until then."""
        for message in self.link.receive():
            if not isinstance(message.body, Telemetry):
                self.link.send(
                    Message(
                        performative=Performative.CONFIRM,
                        sender="service",
                        receiver=message.sender,
                        sent_at_s=0.0,
                        in_reply_to=message.id,
                        body=Receipt(),
                    )
                )

    def command(self, command: object) -> object:
        self.control.send(command)
        self.loop.cycle()
        return self.control.recv()


@pytest.fixture
def double() -> Iterator[LoopUnderTest]:
    yield from closing(LoopUnderTest(2.0))


def closing(loop: LoopUnderTest) -> Iterator[LoopUnderTest]:
    yield loop
    for connection in (loop.control, loop.link, loop.channels.control, loop.channels.link):
        connection.close()


def test_the_world_follows_its_speed(double: LoopUnderTest) -> None:
    double.run(1.0)
    assert double.now.value == pytest.approx(2.0, abs=1.1 * CONTROL_S)


def test_a_paused_world_stands_and_then_continues_without_catching_up(double: LoopUnderTest) -> None:
    double.run(0.5)
    assert double.command(Pause(True)) == Done()
    stood_s = double.now.value
    double.clock.advance(60.0)
    assert double.command(Pause(False)) == Done()
    assert double.now.value == stood_s
    double.run(0.5)
    assert double.now.value == pytest.approx(stood_s + 1.0, abs=1.1 * CONTROL_S)


def test_the_truth_is_answered_on_the_control_channel(double: LoopUnderTest) -> None:
    truth = double.command(AskTruth())
    assert isinstance(truth, Truth)
    assert truth.samples["rock"].place == "corner"
    assert set(truth.robots) == {"fred"}


def test_the_first_message_says_ready_and_stop_ends_the_loop(double: LoopUnderTest) -> None:
    double.control.send(Stop())
    double.loop.run()
    assert isinstance(double.control.recv(), Ready)
    assert double.loop.stopped


class BusyClock(ManualClock):
    """Wall time passes with every reading, as if the ticks took it."""

    def now_s(self) -> float:
        self.advance(0.001)
        return super().now_s()


def test_a_world_without_a_speed_runs_on_between_polls_and_telemetry_is_thinned_to_the_wall_clock() -> None:
    for fast in closing(LoopUnderTest(None, BusyClock())):
        began_s = fast.clock.now_s()
        for _ in range(40):
            fast.loop.cycle()
        wall_s = fast.clock.now_s() - began_s
        told = [one for one in fast.link.receive(0.0) if isinstance(one.body, Telemetry)]
        assert fast.now.value > 5 * wall_s
        assert wall_s / TELEMETRY_GAP_S - 2 <= len(told) <= wall_s / TELEMETRY_GAP_S + 1
        assert told[-1].sent_at_s - told[0].sent_at_s > 2


@pytest.fixture
def resting() -> Iterator[LoopUnderTest]:
    yield from closing(LoopUnderTest(1.0))


def test_a_world_at_rest_sleeps_until_a_message_arrives(
    resting: LoopUnderTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    slept_s: list[float] = []

    def sleep(connections: object, timeout_s: float) -> list[object]:
        if resting.channels.link.poll():
            return [resting.channels.link]
        resting.clock.advance(timeout_s)
        slept_s.append(timeout_s)
        return []

    monkeypatch.setattr("sim.process.world_loop.wait", sleep)
    resting.run(2 * CONTROL_S)
    resting.answer()
    resting.run(REST_AFTER_S - 0.1)
    assert slept_s == []
    resting.run(0.2)
    began_s = resting.now.value
    slept_s.clear()
    for _ in range(50):
        resting.loop.cycle()
    assert slept_s == [REST_S] * 50
    assert resting.now.value - began_s == pytest.approx(50 * REST_S, abs=REST_S)

    slept_s.clear()
    resting.link.receive()
    query = StatusQuery(script_id="unknown")
    resting.link.send(
        Message(performative=Performative.QUERY, sender="service", receiver="fred", sent_at_s=0.0, body=query)
    )
    resting.run(2 * CONTROL_S)
    assert [one for one in resting.link.receive() if not isinstance(one.body, Telemetry)]
    resting.run(REST_AFTER_S - 0.2)
    assert slept_s == []


def test_a_speed_of_nothing_is_refused() -> None:
    with pytest.raises(SimulationError, match="speed must be above 0"):
        LoopUnderTest(0.0)


RULES = """AGENT guard;
BELIEF(startup) => COMMIT(SEQ(DELAY(0.5), adoptBelief(alarm(door))));
BELIEF(alarm(?where)) => COMMIT(adoptBelief(gone(?where)));
"""


@pytest.fixture
def guarded() -> Iterator[LoopUnderTest]:
    """At real time; fred follows `RULES`."""
    document = two_rooms().model_dump(mode="json")
    document["robots"][0]["rules"] = {"guard": RULES}
    yield from closing(LoopUnderTest(1.0, world=WorldFile.model_validate(document)))


def until_it_stands(loop: LoopUnderTest) -> Debugging:
    for _ in range(40):
        loop.clock.advance(0.05)
        state = loop.command(AskDebugging())
        assert isinstance(state, Debugging)
        if state.halts:
            return state
    raise AssertionError("no breakpoint was met")


def guard_of(state: object) -> ToldAgent:
    assert isinstance(state, Debugging)
    (halt,) = state.halts
    (guard,) = halt.agents
    return guard


def believed(state: object) -> set[str]:
    return {one.term for one in guard_of(state).beliefs}


def test_the_world_stands_at_a_breakpoint_before_its_rule_takes_effect(guarded: LoopUnderTest) -> None:
    guarded.command(BreakAt("fred", frozenset({"guard:3"})))
    state = until_it_stands(guarded)
    (halt,) = state.halts
    (firing,) = halt.firings
    assert (halt.robot, firing.rule, firing.bindings) == ("fred", "guard:3", {"where": "door"})
    assert "alarm(door)" in believed(state)
    assert "gone(door)" not in believed(state)
    assert state.left_s == STANDS_AT_MOST_S
    stood_s = guarded.now.value
    guarded.clock.advance(STANDS_AT_MOST_S / 2)
    later = guarded.command(AskDebugging())
    assert isinstance(later, Debugging)
    assert later.left_s == pytest.approx(STANDS_AT_MOST_S / 2)
    assert replace(later, left_s=state.left_s) == state
    assert guarded.now.value == stood_s, "whatever is timed by the world's clock stands, too"


def test_a_step_is_one_control_cycle_after_which_the_world_stands_again(guarded: LoopUnderTest) -> None:
    guarded.command(BreakAt("fred", frozenset({"guard:3"})))
    until_it_stands(guarded)
    stood_s = guarded.now.value
    stepped = guarded.command(GoOn(one_cycle=True))
    assert guarded.now.value == pytest.approx(stood_s + CONTROL_S)
    assert "gone(door)" in believed(stepped)
    assert next((one.rule, one.state) for one in guard_of(stepped).commitments) == ("guard:3", "fulfilled")
    assert guarded.command(GoOn(one_cycle=False)) == Debugging(rules={"fred": frozenset({"guard:3"})})
    guarded.run(0.5)
    assert guarded.now.value == pytest.approx(stood_s + 0.5, abs=2.1 * CONTROL_S)


def test_a_world_without_breakpoints_goes_on(guarded: LoopUnderTest) -> None:
    guarded.command(BreakAt("fred", frozenset({"guard:3"})))
    until_it_stands(guarded)
    stood_s = guarded.now.value
    assert guarded.command(BreakAt("fred", frozenset())) == Debugging()
    guarded.run(0.5)
    assert guarded.now.value > stood_s + 0.3


def test_a_world_that_nobody_lets_go_on_does_so_by_itself(guarded: LoopUnderTest) -> None:
    guarded.command(BreakAt("fred", frozenset({"guard:3"})))
    until_it_stands(guarded)
    stood_s = guarded.now.value
    guarded.clock.advance(STANDS_AT_MOST_S)
    guarded.run(0.5)
    state = guarded.command(AskDebugging())
    assert isinstance(state, Debugging)
    assert (state.rules, state.halts) == ({}, ())
    assert "nobody went on for 600 s" in state.ended
    assert guarded.now.value > stood_s + 0.3


def test_a_paused_world_makes_no_step_and_stands_at_its_breakpoint_afterwards(guarded: LoopUnderTest) -> None:
    guarded.command(BreakAt("fred", frozenset({"guard:3"})))
    until_it_stands(guarded)
    stood_s = guarded.now.value
    guarded.command(Pause(True))
    guarded.command(GoOn(one_cycle=True))
    guarded.command(Pause(False))
    guarded.clock.advance(1.0)
    guarded.command(AskDebugging())
    assert guarded.now.value == stood_s
