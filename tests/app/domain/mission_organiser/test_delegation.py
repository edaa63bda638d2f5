"""Which legs of a script another robot may do, and who: what the plan-net proves must still hold."""

from collections.abc import Collection
from functools import cache

from app.domain.mission_organiser import Organised, load_library, organise
from benchmarks.errands import with_sample
from planner import Fact, PlanNet
from robots.wire import BehaviourScript
from robots.world import LinkSpec, load_world
from tests.app.sample_store import Store


@cache
def store() -> Store:
    plain = with_sample(load_world("sample_store"), "sample_2", "door_2", vacant="bay_3")
    return Store(plain.model_copy(update={"peer_link": LinkSpec()}))


def scripts(
    plan_net: PlanNet, *, delegating: Collection[str] | None = None, but: Collection[Fact] = ()
) -> dict[str, BehaviourScript]:
    known = store()
    organised = organise(
        plan_net,
        load_library(known.base),
        known.repertoires,
        "mission",
        known.base,
        facts=known.facts - frozenset(but),
        clearing=known.world.clearing,
        delegating=known.world.delegating if delegating is None else delegating,
    )
    assert isinstance(organised, Organised), organised
    return {script.robot: script for script in organised.scripts}


def legs(script: BehaviourScript) -> list[tuple[list[str], tuple[str, ...]]]:
    tags = {packet.id: packet.tag for packet in script.packets}
    return [([tags[one] for one in leg.packets], leg.robots) for leg in script.delegable]


CARRY = ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]


def test_a_carry_that_begins_and_ends_with_empty_jaws_may_be_done_by_a_robot_of_the_same_area() -> None:
    made = scripts(store().store_sample_1())
    assert legs(made["yard_1"]) == [(CARRY, ("yard_2",))]
    assert legs(made["store_2"]) == [], "nobody else reaches its aisle"


def test_without_the_grant_scripts_and_waits_are_as_before() -> None:
    granted = scripts(store().store_sample_1())
    plain = scripts(store().store_sample_1(), delegating=())
    assert not any(script.delegable for script in plain.values())
    waits = {name: max(p.wait_timeout_s for p in one.packets) for name, one in plain.items()}
    longer = {name: max(p.wait_timeout_s for p in one.packets) for name, one in granted.items()}
    assert longer["store_2"] > waits["store_2"] + 90.0, "another robot comes later"
    assert longer["yard_1"] == waits["yard_1"]


def test_a_drive_alone_is_not_passed_on_nor_a_leg_that_waits_for_clearance() -> None:
    made = scripts(store().one_interchange_twice())
    assert legs(made["yard_1"]) == [(CARRY, ("yard_2",))], "its way home clears the interchange of itself"
    assert legs(made["yard_2"]) == [], "only yard_2 would be told that the interchange is clear"


def test_only_robots_that_speak_it_and_for_which_its_conditions_hold_are_named() -> None:
    net = store().store_sample_1()
    assert legs(scripts(net, delegating=("yard_1", "store_1"))["yard_1"]) == []
    assert legs(scripts(net, delegating=("yard_2",))["yard_1"]) == [], "it cannot make way"
    unable = Fact("can", ("yard_2", "DOCK"))
    assert unable in store().facts
    assert legs(scripts(net, but=[unable])["yard_1"]) == []


def test_where_a_goal_is_about_the_robot_itself_nobody_takes_its_place() -> None:
    known = store()
    way = {"robots": "yard_1", "rel1": "near", "rel2": "near", "area": "yard"}
    steps = [
        *known.carry("yard_1", "sample_1", "door_1", "interchange_2", came_from="home_yard_1"),
        *known.carry("store_2", "sample_1", "interchange_2", "bay_7", came_from="home_store_2"),
    ]
    empties = known.plan(steps, "in(sample_1, bay_7)", "robot_attribute(yard_1, gripper, empty)")
    assert legs(scripts(empties)["yard_1"]) == []
    leaves = [*steps, ("NAVIGATE", {**way, "ref1": "interchange_2", "ref2": "door_2"})]
    goes_on = known.plan(leaves, "in(sample_1, bay_7)", "near(yard_1, door_2)")
    assert legs(scripts(goes_on)["yard_1"]) == [(CARRY, ("yard_2",))]


def test_robots_whose_home_is_in_a_zone_for_one_robot_make_no_way_for_others() -> None:
    world = load_world("sample_store").model_copy(update={"peer_link": LinkSpec()})
    home = next(place for place in world.locations if place.name == "home_yard_1")
    x_m, y_m = home.at
    zone = {"name": "gate", "x": (x_m - 1, x_m + 1), "y": (y_m - 1, y_m + 1), "rule": "one_robot"}
    narrow = type(world).model_validate({**world.model_dump(mode="json"), "zones": [zone]})
    assert "yard_1" in world.delegating
    assert "yard_1" not in narrow.delegating
    assert not load_world("sample_store").delegating, "robots do not hear each other"
