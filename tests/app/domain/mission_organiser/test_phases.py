"""Scripts of plans whose actions have phases: a packet for each, and couplings that rest on one."""

from functools import cache

import pytest

from app.domain.mission_organiser import Organised, OrganiserFailure, load_library, organise, shipped_library
from app.domain.plan_document import PlanBody
from benchmarks.planner.timed_store import timed_store
from planner import PlanNet, keep_in_step
from robots.world import LinkSpec, load_world
from robots.world.parts import PHASE_TAGS, STORE_TAGS
from tests.app.sample_store import Store

TAGS = ("NAVIGATE_OFF", "NAVIGATE_UP", "NAVIGATE_IN")


@cache
def store() -> Store:
    return Store(base=timed_store())


@cache
def handing_over_a_place() -> PlanNet:
    """yard_2 drives to door_1, where yard_1 stands, which leaves for door_2."""
    facts = store().facts - {store().fact("near(yard_1, home_yard_1)")} | {
        store().fact("near(yard_1, door_1)")
    }
    facts -= {store().fact("clear(door_1, yard)")}
    way = {"rel1": "near", "rel2": "near", "area": "yard"}
    return store().plan(
        [
            ("NAVIGATE", {**way, "robots": "yard_1", "ref1": "door_1", "ref2": "door_2"}),
            ("NAVIGATE", {**way, "robots": "yard_2", "ref1": "home_yard_2", "ref2": "door_1"}),
        ],
        *("near(yard_1, door_2)", "near(yard_2, door_1)"),
        facts=facts,
    )


def test_the_robot_that_comes_waits_with_its_last_packet_for_the_first_of_the_one_that_leaves() -> None:
    net = handing_over_a_place()
    found = organise(net, load_library(store().base), dict.fromkeys(net.robots, TAGS), "m", store().base)
    assert isinstance(found, Organised), found
    leaves, comes = found.scripts
    assert [packet.tag for packet in leaves.packets] == list(TAGS)
    assert [packet.tag for packet in comes.packets] == list(TAGS)
    awaits = [[str(fact) for fact in packet.awaits] for packet in comes.packets]
    assert awaits == [[], [], ["clear(door_1, yard)"]]
    assert [packet.after for packet in comes.packets] == [(), (), ()]
    assert comes.packets[2].expected_start_s >= leaves.packets[0].expected_duration_s
    assert sum(p.expected_duration_s for p in comes.packets) == pytest.approx(
        net.action(comes.packets[2].id).earliest_end_s, abs=0.01
    )


def test_a_robot_that_cannot_see_the_place_is_cleared_by_the_phase_that_leaves_it() -> None:
    net = handing_over_a_place()
    facts = frozenset(link.fact for link in net.causal_links if link.producer == "initial")
    objects = {"yard_1": "robot", "yard_2": "robot", "door_1": "location", "yard": "area"}
    blind = keep_in_step(net, facts, objects, store().base, {"yard_2": frozenset()})
    found = organise(blind, load_library(store().base), dict.fromkeys(net.robots, TAGS), "m", store().base)
    assert isinstance(found, Organised), found
    leaves, comes = found.scripts
    assert [packet.after for packet in comes.packets] == [(), (), (leaves.packets[0].id,)]


def test_a_packet_of_a_phase_has_the_time_of_the_whole_action() -> None:
    net = handing_over_a_place()
    found = organise(net, load_library(store().base), dict.fromkeys(net.robots, TAGS), "m", store().base)
    assert isinstance(found, Organised), found
    for script in found.scripts:
        whole_s = sum(packet.expected_duration_s for packet in script.packets)
        assert [packet.timeout_s for packet in script.packets] == pytest.approx([max(30, 4 * whole_s)] * 3)


@pytest.mark.parametrize("tags", [(), PHASE_TAGS])
def test_robots_that_know_its_packets_do_an_action_in_phases_and_others_do_it_as_one(
    tags: tuple[str, ...],
) -> None:
    plain = load_world("sample_store")
    robots = tuple(r.model_copy(update={"repertoire": (*STORE_TAGS, *tags)}) for r in plain.robots)
    world = plain.model_copy(update={"robots": robots, "peer_link": LinkSpec()})
    known = Store(world)
    net = known.plan(
        known.carry("yard_2", "sample_1", "door_1", "interchange_2", came_from="home_yard_2"),
        "in(sample_1, interchange_2)",
    )
    found = organise(
        net,
        load_library(known.base),
        known.repertoires,
        "m",
        known.base,
        facts=known.facts,
        clearing=world.clearing,
        delegating=world.delegating,
    )
    assert isinstance(found, Organised), found
    (script,) = found.scripts
    whole = ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]
    in_phases = [*TAGS, "DOCK", "TRANSPORT_OFF", "TRANSPORT_UP", "TRANSPORT_IN", "RELEASE2"]
    assert [packet.tag for packet in script.packets] == (in_phases if tags else whole)
    assert bool(script.delegable) is not bool(tags)  # a leg with phases is not passed on


def test_without_packets_for_its_phases_an_action_is_refused() -> None:
    net = handing_over_a_place()
    shipped = load_library(store().base, shipped_library())
    found = organise(net, shipped, dict.fromkeys(net.robots, ("NAVIGATE",)), "m", store().base)
    assert isinstance(found, OrganiserFailure)
    assert "yard_1 has no NAVIGATE_OFF in its repertoire" in found.reason


def test_a_plan_with_phases_is_the_same_when_it_has_been_stored() -> None:
    net = handing_over_a_place()
    body = PlanBody.of_plan_net(net, store().base)
    assert {action.phase for action in body.actions} == {1, 2, 3}
    assert PlanBody.model_validate_json(body.model_dump_json()).to_plan_net(store().base) == net
