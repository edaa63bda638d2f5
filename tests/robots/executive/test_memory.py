"""A robot whose power fails goes on where it stood, by what its flash memory holds."""

import json
from dataclasses import replace

import pytest

from robots.executive.agent import BehaviouralAgent
from robots.executive.memory import RobotMemory
from robots.executive.mind_memory import MindMemory
from robots.link import InMemoryLink
from robots.perception.localisation import EstimateMemory
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.wire import (
    Clearance,
    Control,
    ControlVerb,
    FailureCategory,
    Message,
    PacketReport,
    PacketState,
    Retune,
    ScriptReport,
    ScriptState,
    StatusQuery,
    StatusReport,
)
from tests.robots.fake_world import FakeBody, FakeWorld
from tests.robots.stories import EAST, SOUTH, Service, carry, packet, room, run, run_for, script

START = Pose(x_m=4.0, y_m=1.5, heading_rad=EAST)


def robot(world: FakeWorld, pose: Pose = START, *, receipts: bool = True, home: str | None = None) -> Service:
    return Service(world, world.add("fred", pose, home=home), "fred", receipts=receipts)


def restart(
    world: FakeWorld,
    service: Service,
    *,
    memory: RobotMemory | None = None,
    profile: RobotProfile | None = None,
    **changes: object,
) -> None:
    """The power fails and comes back: what was in the air is lost, what is in flash memory is all there is.

    :param memory: what it goes on with; None: all that it had. :param profile: None: the one it had.
    """
    old = world.agents["fred"]
    service.link, theirs = InMemoryLink.pair()
    world.agents["fred"] = BehaviouralAgent(
        profile=profile or old.profile,
        body=world.bodies["fred"],
        link=theirs,
        clock=world.clock,
        memory=RobotMemory.model_validate_json((memory or old.memory()).model_dump_json()),
        **changes,  # type: ignore[arg-type]
    )


def estimate(world: FakeWorld) -> EstimateMemory:
    body = world.agents["fred"].memory().body
    assert body is not None
    return body.estimate


def answer_to(service: Service, request: Message) -> Message:
    return next(message for message in service.heard if message.in_reply_to == request.id)


def states(service: Service) -> list[PacketState]:
    return [state for _, state in service.packets]


def test_a_script_is_carried_on_in_the_packet_that_was_under_way_and_nothing_is_done_twice() -> None:
    world = room({"sample": 1 + 0.4j})
    service = robot(world, Pose(x_m=1, y_m=1.2, heading_rad=SOUTH))
    service.order(carry("fred", "sample", "door", "yard"))
    for tag in ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"):
        assert run(world, [service], lambda tag=tag: (tag, PacketState.RUNNING) in service.packets)  # type: ignore[misc]
        run_for(world, [service], 0.3)
        restart(world, service)
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED
    assert abs(world.samples["sample"] - (5.4 + 1.2j)) < 0.1
    begun = [tag for tag, state in service.packets if state is PacketState.RUNNING]
    assert begun == ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]


def test_what_the_jaws_hold_is_told_also_while_they_are_not_sensed_and_after_a_restart() -> None:
    world = room({"sample": 1 + 0.4j})
    service = robot(world, Pose(x_m=1, y_m=1.2, heading_rad=SOUTH))
    service.order(carry("fred", "sample", "door", "yard"))
    assert run(world, [service], lambda: ("TRANSPORT", PacketState.RUNNING) in service.packets)
    service.send(Control(script_id="script-fred", verb=ControlVerb.CANCEL))
    assert run(world, [service], lambda: service.report is not None)
    for _ in range(2):
        run_for(world, [service], 1.0)
        told = service.telemetry[-1]
        assert "gripper" not in told.sensors
        assert (told.holding, world.bodies["fred"].held) == ("sample", "sample")
        restart(world, service)


def test_a_request_that_comes_again_after_a_restart_gets_the_same_answer_and_runs_once() -> None:
    world = room()
    service = robot(world)
    request = service.order(script("fred", packet("NAVIGATE", ref2="door")))
    assert run(world, [service], lambda: service.report is not None)
    first = answer_to(service, request)
    run_for(world, [service], 0.1)  # the last receipt
    restart(world, service)
    service.heard.clear()
    service.link.send(request)
    run_for(world, [service], 2)
    assert answer_to(service, request) == first
    assert service.packets == []


def test_a_script_in_another_message_is_not_run_again_after_a_restart() -> None:
    world = room()
    service = robot(world)
    order = script("fred", packet("NAVIGATE", ref2="door"))
    service.order(order)
    assert run(world, [service], lambda: service.report is not None)
    run_for(world, [service], 0.1)  # the last receipt
    restart(world, service)
    service.heard.clear()
    again = service.order(order)
    run_for(world, [service], 2)
    assert answer_to(service, again).performative == "agree"
    assert service.packets == []


def test_reports_without_a_receipt_are_sent_again_at_once_under_their_own_ids() -> None:
    world = room()
    service = robot(world, receipts=False)
    service.order(script("fred", packet("NAVIGATE", ref2="door", timeout_s=1)))
    assert run(world, [service], lambda: service.report is not None)
    said = {m.id for m in service.heard if isinstance(m.body, PacketReport | ScriptReport)}
    restart(world, service)
    service.heard.clear()
    run_for(world, [service], 0.1)
    assert {m.id for m in service.heard if isinstance(m.body, PacketReport | ScriptReport)} == said
    service.receipts = True
    run_for(world, [service], 40)
    restart(world, service)
    service.heard.clear()
    run_for(world, [service], 1)
    assert not [m for m in service.heard if isinstance(m.body, PacketReport | ScriptReport)]


def test_a_question_that_was_not_answered_yet_is_answered_when_it_comes_again() -> None:
    world = room()
    service = robot(world)
    run_for(world, [service], 0.2)
    question = service.send(StatusQuery(script_id="mine"))
    world.tick()  # it senses nothing, so it looks round first: the question waits
    restart(world, service)
    service.link.send(question)
    run_for(world, [service], 0.3)
    status = answer_to(service, question).body
    assert isinstance(status, StatusReport)
    assert status.perceived


def test_clearance_and_the_time_waited_for_it_are_remembered() -> None:
    world = room()
    service = robot(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door", after=["a7", "a9"], wait_timeout_s=10)))
    service.send(Clearance(script_id="script-fred", ended=("a7",)))
    run_for(world, [service], 6)
    restart(world, service)
    run_for(world, [service], 3)
    assert states(service) == [PacketState.INITIALIZING]
    assert run(world, [service], lambda: service.report is not None, limit_s=2)
    assert service.report is not None
    assert service.report.category is FailureCategory.DEADLINE
    assert "waits for clearance: a9" in service.report.detail


def test_a_packets_time_runs_on_over_a_restart() -> None:
    world = room()
    service = robot(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door", timeout_s=3)))
    run_for(world, [service], 2)
    restart(world, service)
    assert run(world, [service], lambda: service.report is not None, limit_s=1.5)
    assert service.report is not None
    assert service.report.category is FailureCategory.DEADLINE


def test_a_paused_robot_stays_paused_over_a_restart() -> None:
    world = room()
    service = robot(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 1)
    service.send(Control(script_id="script-fred", verb=ControlVerb.PAUSE))
    run_for(world, [service], 0.2)
    restart(world, service)
    there = world.bodies["fred"].at
    run_for(world, [service], 5)
    assert world.bodies["fred"].at == there
    service.send(Control(script_id="script-fred", verb=ControlVerb.RESUME))
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED


def test_a_robot_still_knows_where_it_is() -> None:
    world = room(noise=0.0)
    service = robot(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 3)
    before = estimate(world)
    restart(world, service)
    assert estimate(world) == before
    run_for(world, [service], 0.2)
    last = service.telemetry[-1]
    assert abs(complex(last.x_m, last.y_m) - world.bodies["fred"].at) < 0.05


def test_tuning_is_kept_with_its_version() -> None:
    world = room()
    service = robot(world)
    gentle = {"NAVIGATE": {"translate/obstacle_avoid": {"stimulus.reach_m": 0.4}}}
    service.send(Retune(version=3, tuning=gentle))
    run_for(world, [service], 0.2)
    restart(world, service)
    service.send(Retune(version=2, tuning={}))  # an old one, late: it changes nothing
    run_for(world, [service], 0.2)
    mind = world.agents["fred"].memory().mind
    assert (mind.tuning_version, mind.tuning) == (3, gentle)


def test_a_robot_on_its_way_to_its_charger_goes_on_and_counts_its_own_scripts_on() -> None:
    world = room()
    service = robot(world, home="yard")
    world.bodies["fred"].battery = 0.2
    run_for(world, [service], 1)
    before = world.agents["fred"].memory().mind
    assert before.upkeep.count == 1
    restart(world, service)
    run_for(world, [service], 1)
    after = world.agents["fred"].memory().mind
    assert after.upkeep == before.upkeep
    assert before.executive.script is not None
    assert after.executive.script is not None
    assert after.executive.script.script == before.executive.script.script


def test_a_script_that_the_software_knows_no_more_has_failed_and_says_why() -> None:
    world = room()
    service = robot(world)
    service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 1)
    specs = {tag: spec for tag, spec in load_repertoire().specs.items() if tag != "NAVIGATE"}
    restart(world, service, repertoire=type(load_repertoire())(specs))
    run_for(world, [service], 0.3)
    assert service.report is not None
    assert (service.report.state, service.report.category) == (ScriptState.FAILED, FailureCategory.ROBOT)
    assert "cannot go on after a restart: unknown packet NAVIGATE" in service.report.detail


@pytest.mark.parametrize("after_s", [0.05, 3.0])
def test_memory_is_data_that_json_holds_to_the_last_bit(after_s: float) -> None:
    world = room({"sample": 1 + 0.4j})
    service = robot(world, Pose(x_m=1, y_m=1.2, heading_rad=SOUTH), receipts=False)
    service.order(carry("fred", "sample", "door", "yard"))
    run_for(world, [service], after_s)
    memory = world.agents["fred"].memory()
    assert RobotMemory.model_validate_json(memory.model_dump_json()) == memory


@pytest.mark.parametrize("has_rules", [False, True])
def test_a_memory_of_earlier_versions_in_one_piece_is_read(has_rules: bool) -> None:
    world = room({"sample": 1 + 0.4j})
    service = robot(world, Pose(x_m=1, y_m=1.2, heading_rad=SOUTH), receipts=False)
    service.order(carry("fred", "sample", "door", "yard"))
    run_for(world, [service], 3.0)
    memory = world.agents["fred"].memory()
    rules = MindMemory(version=4, files={"guard": "AGENT guard;"}) if has_rules else None
    memory = memory.model_copy(update={"mind": memory.mind.model_copy(update={"rules": rules})})
    now = memory.model_dump(mode="json")
    earlier = {**now["mind"], **now["body"], "mind": now["mind"]["rules"]}
    del earlier["rules"]
    assert RobotMemory.model_validate_json(json.dumps(earlier)) == memory


def test_a_mind_goes_on_with_its_script_in_another_body_and_does_and_tells_nothing_twice() -> None:
    world = room({"sample": 1 + 0.4j})
    service = robot(world, Pose(x_m=4, y_m=1.2, heading_rad=SOUTH), receipts=False)
    request = service.order(carry("fred", "sample", "door", "yard"))
    assert run(world, [service], lambda: ("NAVIGATE", PacketState.RUNNING) in service.packets)
    run_for(world, [service], 0.5)
    told = {one.id for one in service.heard if isinstance(one.body, PacketReport)}
    start = Pose(x_m=1.5, y_m=1.8, heading_rad=EAST)
    world.bodies["fred"] = FakeBody(world, "fred", start)
    here = replace(world.agents["fred"].profile, start=start)
    restart(world, service, memory=RobotMemory(mind=world.agents["fred"].memory().mind), profile=here)
    service.receipts = True
    service.heard.clear()
    service.link.send(request)
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED
    assert abs(world.samples["sample"] - (5.4 + 1.2j)) < 0.1
    begun = {one.id: one.body for one in service.heard if isinstance(one.body, PacketReport)}
    assert told <= begun.keys(), "what had no receipt is told again under its own id"
    tags = [one.packet_id for one in begun.values() if one.state is PacketState.RUNNING]
    assert len(tags) == len(set(tags)) == 4
    assert answer_to(service, request).performative == "agree"
