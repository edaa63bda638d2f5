"""A robot that has nothing to do looks after its battery, and does not take on what it is too weak for."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import pi

import pytest

from robots.deliberative.mind import Mind
from robots.deliberative.reader import read_rules, rules_of
from robots.executive.executive import Executive
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire, load_self_level
from robots.repertoire.self_level import SelfLevel
from robots.wire import (
    FailureCategory,
    Message,
    PacketState,
    Performative,
    Refusal,
    ScriptState,
    SymbolicFact,
)
from robots.world.rule_files import shipped_rules
from tests.robots.fake_world import FakeBody, FakeWorld
from tests.robots.sensed import watch
from tests.robots.stories import NORTH, Service, carry, packet, room, run, run_for, script

LEVELS = load_self_level()
START = Pose(x_m=1.0, y_m=1.5, heading_rad=NORTH)
NEAR_HOME = SymbolicFact(predicate="near", args=("fred", "yard"))


Fred = Callable[..., tuple[Service, FakeBody]]


def charging_rules(profile: RobotProfile) -> Mind:
    return Mind(profile, load_repertoire(), [read_rules(shipped_rules()["charging"])])


@pytest.fixture(params=[None, charging_rules], ids=["software", "rules"])
def fred(request: pytest.FixtureRequest) -> Fred:
    """Places fred by the door, his charger in the yard: without rules, and with those that do the same."""
    return partial(_fred, makes_mind=request.param)


def _fred(
    world: FakeWorld,
    battery: float,
    *,
    home: str | None = "yard",
    makes_mind: Callable[[RobotProfile], Mind] | None = None,
) -> tuple[Service, FakeBody]:
    link = world.add("fred", START, ["ginger"], home=home, mind=makes_mind)
    service = Service(world, link, "fred")
    world.bodies["fred"].battery = battery
    return service, world.bodies["fred"]


def told(service: Service) -> list[tuple[str, PacketState]]:
    return [(one.tag, one.state) for one in service.upkeep]


def answer(service: Service, request: Message) -> Message:
    return next(message for message in service.heard if message.in_reply_to == request.id)


def test_an_idle_robot_with_a_low_battery_drives_home_is_charged_and_tells_so(fred: Fred) -> None:
    world = room()
    service, body = fred(world, 0.24)
    assert run(world, [service], lambda: ("SEEK_CHARGER", PacketState.FINISHED) in told(service))
    assert NEAR_HOME in service.upkeep[-1].perceived
    body.charging = True
    run_for(world, [service], 5)
    assert service.telemetry[-1].packet_tag == "CHARGE"
    assert body.velocity == (0.0, 0.0)
    body.battery = 0.91
    run_for(world, [service], 1)
    assert told(service) == [
        ("SEEK_CHARGER", PacketState.RUNNING),
        ("SEEK_CHARGER", PacketState.FINISHED),
        ("CHARGE", PacketState.RUNNING),
        ("CHARGE", PacketState.FINISHED),
    ]
    assert not body.running, "with nothing to do it senses nothing"


def test_a_robot_with_enough_battery_or_without_a_home_stays_where_it_is(fred: Fred) -> None:
    for battery, home in ((0.26, "yard"), (0.1, None)):
        world = room()
        service, body = fred(world, battery, home=home)
        run_for(world, [service], 3)
        assert (told(service), body.pose) == ([], START)


def test_a_script_that_comes_on_the_way_home_goes_on_from_there(fred: Fred) -> None:
    world = room()
    service, _ = fred(world, 0.24)
    run_for(world, [service], 4)
    assert service.telemetry[-1].packet_tag == "SEEK_CHARGER"
    request = service.order(script("fred", packet("NAVIGATE", ref2="door")))
    assert run(world, [service], lambda: service.report is not None)
    assert answer(service, request).performative is Performative.AGREE
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED
    assert told(service) == [("SEEK_CHARGER", PacketState.RUNNING)]


def test_a_robot_that_is_too_weak_refuses_a_script_and_says_what_is_needed(fred: Fred) -> None:
    world = room()
    service, body = fred(world, 0.06)
    body.charging = True
    request = service.order(script("fred", packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 0.2)
    refused = answer(service, request).body
    assert isinstance(refused, Refusal)
    assert refused.reason == "fred charges, battery at 6%: 20% needed"


def test_a_nearly_empty_battery_ends_the_script_and_the_robot_seeks_its_charger(fred: Fred) -> None:
    world = room()
    service, body = fred(world, 1.0)
    service.order(script("fred", packet("NAVIGATE", ref2="yard"), packet("NAVIGATE", ref2="door")))
    run_for(world, [service], 3)
    body.battery = 0.04
    assert run(world, [service], lambda: ("SEEK_CHARGER", PacketState.FINISHED) in told(service))
    assert service.report is not None
    assert service.report.category is FailureCategory.ROBOT
    assert service.report.detail == "NAVIGATE broke off: battery at 4%"


def test_what_a_robot_carries_it_takes_home_when_its_battery_is_nearly_empty(fred: Fred) -> None:
    world = room({"sample": 1 + 0.4j})
    service, body = fred(world, 1.0)
    service.order(carry("fred", "sample", "door", "hatch"))
    assert run(world, [service], lambda: ("TRANSPORT", PacketState.RUNNING) in service.packets)
    body.battery = 0.07
    assert run(world, [service], lambda: ("SEEK_CHARGER", PacketState.FINISHED) in told(service))
    assert body.held == "sample"
    assert SymbolicFact(predicate="in", args=("sample", "fred")) in service.upkeep[-1].perceived
    assert NEAR_HOME in service.upkeep[-1].perceived


def test_jaws_that_are_at_work_finish_before_a_script_is_broken_off(fred: Fred) -> None:
    world = room({"sample": 1 + 0.4j})
    service, body = fred(world, 1.0)
    service.order(carry("fred", "sample", "door", "hatch"))
    assert run(world, [service], lambda: ("DOCK", PacketState.RUNNING) in service.packets)
    body.battery = 0.07
    assert run(world, [service], lambda: service.report is not None)
    assert ("DOCK", PacketState.FINISHED) in service.packets
    assert service.report is not None
    assert service.report.detail == "TRANSPORT broke off: battery at 7%"
    assert body.held == "sample"


def test_a_robot_that_another_holds_something_with_does_not_drive_off(fred: Fred) -> None:
    world = room({"sample": 1 + 1.84j})
    service, body = fred(world, 0.24)
    world.add("ginger", Pose(x_m=1.0, y_m=2.18, heading_rad=-pi / 2))
    body.set_gripper(closed=True)
    run_for(world, [service], 5)
    assert service.telemetry[-1].packet_state == PacketState.INITIALIZING
    assert body.pose == START


def test_a_robot_that_does_not_get_home_says_so_and_tries_again_later(fred: Fred) -> None:
    world = room()
    service, body = fred(world, 0.24)
    body.stuck = True

    def begun() -> list[float]:
        return [one.at_s for one in service.upkeep if one.state is PacketState.RUNNING and not one.detail]

    assert run(world, [service], lambda: len(begun()) == 2)
    assert begun()[1] - begun()[0] >= 60
    (failed,) = [one for one in service.upkeep if one.state is PacketState.FAILED]
    assert "made no progress after" in failed.detail


def test_a_robot_that_cannot_even_try_says_why(fred: Fred) -> None:
    world = room()
    service, _ = fred(world, 0.24, home="moon")
    run_for(world, [service], 1)
    (failed,) = service.upkeep
    assert (failed.tag, failed.state) == ("SEEK_CHARGER", PacketState.FAILED)
    assert "moon is not a place that fred knows" in failed.detail


def test_what_takes_two_robots_is_not_released_half_way(fred: Fred) -> None:
    world = room({"rock": 1 + 1.84j})
    _, body = fred(world, 1.0)
    profile = replace(world.agents["fred"].profile, lengths_m={"rock": 1.0})
    executive = Executive(profile, load_repertoire())
    body.set_gripper(closed=True)
    order = script("fred", packet("NAVIGATE", ref2="door"))
    assert executive.accept(order) is None
    percepts = watch([replace(body.sense(), battery=0.05)])
    executive.step(replace(percepts, profile=profile), 0.05)
    assert executive.state is not ScriptState.FAILED
    body.set_gripper(closed=False)
    executive.step(replace(watch([replace(body.sense(), battery=0.05)]), profile=profile), 0.05)
    assert executive.state is ScriptState.FAILED


def test_levels_out_of_order_are_refused() -> None:
    with pytest.raises(ValueError, match="critical < needed <= low"):
        SelfLevel.model_validate({**LEVELS.model_dump(), "critical": 0.3})


def test_an_operator_changes_when_a_robot_charges() -> None:
    text = shipped_rules()["charging"].read_text(encoding="utf-8").replace("0.25", "0.6")
    world = room()
    link = world.add(
        "fred",
        START,
        home="yard",
        mind=lambda profile: Mind(profile, load_repertoire(), [rules_of(text, "charging.rules")]),
    )
    service = Service(world, link, "fred")
    world.bodies["fred"].battery = 0.59
    assert run(world, [service], lambda: ("SEEK_CHARGER", PacketState.FINISHED) in told(service))


def test_rules_without_an_agent_for_it_leave_charging_to_the_software() -> None:
    rules = rules_of("AGENT guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));", "guard.rules")
    world = room()
    link = world.add(
        "fred", START, home="yard", mind=lambda profile: Mind(profile, load_repertoire(), [rules])
    )
    service = Service(world, link, "fred")
    world.bodies["fred"].battery = 0.24
    assert run(world, [service], lambda: ("SEEK_CHARGER", PacketState.FINISHED) in told(service))
