"""A script that must not be begun any longer is refused, however late it comes: cancelled in advance, or superseded."""

import pytest

from robots.contract.known_scripts import REMEMBERED, StaleScripts
from robots.contract.memory import StaleMemory
from robots.physical.body import Pose
from robots.wire import (
    Acknowledgement,
    BehaviourScript,
    Control,
    ControlVerb,
    FailureCategory,
    Message,
    PacketState,
    Performative,
    Refusal,
    ScriptReport,
    ScriptState,
    StatusQuery,
    StatusReport,
)
from tests.robots.fake_world import FakeWorld
from tests.robots.stories import EAST, SOUTH, Service, carry, packet, room, run, run_for, script

START = Pose(x_m=4.0, y_m=1.5, heading_rad=EAST)


def fred(world: FakeWorld, pose: Pose = START) -> Service:
    return Service(world, world.add("fred", pose), "fred")


def answer(service: Service, request: Message) -> object:
    return next(message.body for message in service.heard if message.in_reply_to == request.id)


def revised(revision: int, name: str) -> BehaviourScript:
    way = script("fred", packet("NAVIGATE", ref2="door"), name=name)
    return way.model_copy(update={"revision": revision})


def cancel(service: Service, name: str) -> Message:
    return service.send(Control(script_id=name, verb=ControlVerb.CANCEL), Performative.CANCEL)


def test_a_script_that_was_cancelled_before_it_arrived_is_reported_cancelled_and_then_refused() -> None:
    world = room()
    service = fred(world)
    order = cancel(service, "late")
    run_for(world, [service], 0.3)
    assert isinstance(answer(service, order), Acknowledgement)
    report = service.report
    assert report is not None
    assert (report.script_id, report.state) == ("late", ScriptState.CANCELLED)
    assert report.category is FailureCategory.CANCELLED
    assert report.perceived, "what the robot perceives reconciles the world model"

    request = service.order(script("fred", packet("NAVIGATE", ref2="door"), name="late"))
    asked = service.send(StatusQuery(script_id="late"), Performative.QUERY)
    run_for(world, [service], 2)
    refusal, status = answer(service, request), answer(service, asked)
    assert isinstance(refusal, Refusal)
    assert refusal.reason == "stale: script late was cancelled before it arrived"
    assert isinstance(status, StatusReport)
    assert status.state is ScriptState.CANCELLED
    assert service.packets == []


def test_after_a_cancel_in_advance_the_robot_takes_another_script() -> None:
    world = room()
    service = fred(world)
    cancel(service, "late")
    request = service.order(script("fred", packet("NAVIGATE", ref2="door"), name="other"))
    run_for(world, [service], 0.3)
    assert isinstance(answer(service, request), Acknowledgement)


@pytest.mark.parametrize("verb", [ControlVerb.PAUSE, ControlVerb.RESUME])
def test_only_a_cancel_holds_for_a_script_that_has_not_come(verb: ControlVerb) -> None:
    world = room()
    service = fred(world)
    order = service.send(Control(script_id="late", verb=verb))
    run_for(world, [service], 0.3)
    request = service.order(script("fred", packet("NAVIGATE", ref2="door"), name="late"))
    run_for(world, [service], 0.3)
    assert isinstance(answer(service, order), Refusal)
    assert isinstance(answer(service, request), Acknowledgement)


def test_a_cancel_of_a_script_that_was_refused_changes_nothing() -> None:
    world = room()
    service = fred(world)
    service.order(script("fred", packet("FLY"), name="unfit"))
    order = cancel(service, "unfit")
    run_for(world, [service], 0.3)
    assert isinstance(answer(service, order), Refusal)


def test_a_later_script_of_the_mission_supersedes_the_one_under_way() -> None:
    world = room({"sample": 1 + 0.4j})
    service = fred(world, Pose(x_m=1, y_m=1.2, heading_rad=SOUTH))
    service.order(carry("fred", "sample", "door", "yard"))
    assert run(world, [service], lambda: ("TRANSPORT", PacketState.RUNNING) in service.packets)
    request = service.order(revised(1, "second"))
    run_for(world, [service], 0.3)
    assert isinstance(answer(service, request), Acknowledgement)
    ended = [m.body for m in service.heard if isinstance(m.body, ScriptReport)]
    assert {(body.script_id, body.state) for body in ended} == {("script-fred", ScriptState.CANCELLED)}
    assert ended[0].detail == "superseded by revision 1 of its mission"
    assert ended[0].perceived
    assert world.bodies["fred"].held == "sample", "what it holds it goes on holding"


def test_an_earlier_script_of_the_mission_that_comes_late_is_refused() -> None:
    world = room()
    service = fred(world)
    service.order(revised(2, "third"))
    assert run(world, [service], lambda: service.report is not None)
    late = service.order(revised(1, "second"))
    first = service.order(revised(0, "first"))
    run_for(world, [service], 0.3)
    for request, name in ((late, "second"), (first, "first")):
        refusal = answer(service, request)
        assert isinstance(refusal, Refusal)
        assert refusal.reason == f"stale: script {name} is superseded by revision 2 of mission mission"


def test_a_revision_says_nothing_of_other_missions() -> None:
    stale = StaleScripts()
    assert stale.refusal(revised(3, "one")) is None
    other = revised(0, "other").model_copy(update={"mission_id": "another"})
    assert stale.refusal(other) is None


def test_what_is_remembered_is_bounded_and_the_newest_stays() -> None:
    stale = StaleScripts()
    for number in range(REMEMBERED + 10):
        stale.cancel(f"s{number}")
        stale.refusal(revised(1, "one").model_copy(update={"mission_id": f"m{number}"}))
    memory = stale.memory()
    assert (len(memory.cancelled), len(memory.revisions)) == (REMEMBERED, REMEMBERED)
    assert memory.cancelled[-1] == f"s{REMEMBERED + 9}"
    assert "s0" not in memory.cancelled


def test_what_is_stale_is_still_stale_after_a_power_failure() -> None:
    before, after = StaleScripts(), StaleScripts()
    before.cancel("late")
    before.refusal(revised(2, "third"))
    after.recall(StaleMemory.model_validate_json(before.memory().model_dump_json()))
    assert "cancelled before it arrived" in (after.refusal(revised(0, "late")) or "")
    assert "superseded" in (after.refusal(revised(1, "second")) or "")
