"""Orders overtake each other on their way: the one with the greatest number holds, a cancel always."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.executive.agent import BehaviouralAgent
from robots.executive.memory import RobotMemory, ScriptMemory
from robots.link import InMemoryLink
from robots.physical.body import Pose
from robots.wire import (
    Acknowledgement,
    Control,
    ControlVerb,
    Message,
    Performative,
    Refusal,
    ScriptState,
    StatusQuery,
    StatusReport,
)
from tests.robots.fake_world import STEP_S, FakeWorld
from tests.robots.stories import EAST, Service, packet, room, run_for, script

START = Pose(x_m=1.0, y_m=1.5, heading_rad=EAST)
CANCEL, PAUSE, RESUME = ControlVerb.CANCEL, ControlVerb.PAUSE, ControlVerb.RESUME
VERBS = (PAUSE, RESUME) * 3
SCRIPT = "script-fred"


def at_work() -> tuple[FakeWorld, Service]:
    """A robot on a way of some seconds."""
    world = room()
    service = Service(world, world.add("fred", START), "fred")
    service.order(script("fred", packet("NAVIGATE", ref2="yard")))
    run_for(world, [service], 4 * STEP_S)
    return world, service


def order(number: int, verb: ControlVerb) -> Message:
    """The service's, under the same id however often it is sent."""
    return Message(
        id=f"{SCRIPT}:{verb.value}:{number}",
        performative=Performative.CANCEL if verb is CANCEL else Performative.REQUEST,
        sender="service",
        receiver="fred",
        sent_at_s=0.0,
        body=Control(script_id=SCRIPT, verb=verb, number=number),
    )


def power_fails(world: FakeWorld, service: Service) -> None:
    old = world.agents["fred"]
    memory = RobotMemory.model_validate_json(old.memory().model_dump_json())
    service.link, theirs = InMemoryLink.pair()
    world.agents["fred"] = BehaviouralAgent(
        profile=old.profile, body=world.bodies["fred"], link=theirs, clock=world.clock, memory=memory
    )


def status(world: FakeWorld, service: Service) -> StatusReport:
    asked = service.send(StatusQuery(script_id=SCRIPT), Performative.QUERY)
    run_for(world, [service], 4 * STEP_S)
    (answer,) = (m.body for m in service.heard if m.in_reply_to == asked.id)
    assert isinstance(answer, StatusReport)
    return answer


ARRIVALS = st.lists(st.integers(1, len(VERBS)), max_size=8).flatmap(
    lambda again: st.permutations([*range(1, len(VERBS) + 1), *again])
)


@settings(deadline=None, max_examples=15)
@given(arrivals=ARRIVALS, fails_after=st.integers(0, 14))
def test_in_whatever_order_and_however_often_they_come_the_last_order_holds(
    arrivals: list[int], fails_after: int
) -> None:
    world, service = at_work()
    for place, number in enumerate(arrivals):
        if place == fails_after:
            power_fails(world, service)
        service.link.send(order(number, VERBS[number - 1]))
        run_for(world, [service], 4 * STEP_S)
        told = max(arrivals[: place + 1])
        paused = service.telemetry[-1].script_state is ScriptState.PAUSED
        assert paused == (VERBS[told - 1] is PAUSE), arrivals[: place + 1]
    assert status(world, service).order == len(VERBS)


@settings(deadline=None, max_examples=20)
@given(arrivals=ARRIVALS, before=st.integers(0, 14))
def test_a_cancel_holds_whatever_its_number_and_whatever_comes_before_and_after(
    arrivals: list[int], before: int
) -> None:
    world, service = at_work()
    orders = [order(number, VERBS[number - 1]) for number in arrivals]
    orders.insert(before, order(1, CANCEL))
    for one in orders:
        service.link.send(one)
        run_for(world, [service], STEP_S)
    run_for(world, [service], 2 * STEP_S)
    assert service.report is not None
    assert service.report.state is ScriptState.CANCELLED
    assert world.bodies["fred"].velocity == (0, 0)


def test_an_overtaken_order_is_refused_and_says_by_which() -> None:
    world, service = at_work()
    late, newest = order(1, PAUSE), order(2, RESUME)
    for one in (newest, late):
        service.link.send(one)
        run_for(world, [service], 2 * STEP_S)
    answers = {m.in_reply_to: m.body for m in service.heard}
    assert isinstance(answers[newest.id], Acknowledgement)
    refusal = answers[late.id]
    assert isinstance(refusal, Refusal)
    assert refusal.reason == f"order 1 to pause script {SCRIPT} was overtaken by order 2"


@pytest.mark.parametrize("verb", [PAUSE, RESUME])
def test_orders_without_a_number_are_followed_as_they_come(verb: ControlVerb) -> None:
    """As a service sends them that does not number them."""
    world, service = at_work()
    for number, one in enumerate((PAUSE, RESUME, verb)):
        plain = order(0, one).model_copy(update={"id": f"plain-{number}"})
        body = plain.model_dump(mode="json")
        del body["body"]["number"]
        service.link.send(Message.model_validate(body))
        run_for(world, [service], 2 * STEP_S)
    state = status(world, service).state
    assert state is (ScriptState.PAUSED if verb is PAUSE else ScriptState.RUNNING)


def test_the_numbers_of_one_script_say_nothing_of_the_next() -> None:
    world, service = at_work()
    service.link.send(order(7, CANCEL))
    run_for(world, [service], 2 * STEP_S)
    service.order(script("fred", packet("NAVIGATE", ref2="yard"), name="next"))
    service.send(Control(script_id="next", verb=PAUSE, number=1))
    run_for(world, [service], 4 * STEP_S)
    assert service.telemetry[-1].script_state is ScriptState.PAUSED


def test_a_memory_from_before_orders_had_numbers_is_read() -> None:
    kept = ScriptMemory(script=script("fred", packet("NAVIGATE", ref2="yard")), index=0, packets=())
    before = kept.model_dump(mode="json", exclude={"order"})
    assert ScriptMemory.model_validate(before).order == 0
