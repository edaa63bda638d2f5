"""Scripts of plans whose actions have phases: a packet for each, and couplings that rest on one."""

from functools import cache
from pathlib import Path

import pytest

from app.domain.mission_organiser import Organised, OrganiserFailure, load_library, organise, shipped_library
from app.domain.plan_document import PlanBody
from app.packs.find import load_packs
from benchmarks.holding_off import PACK, PHASE_TAGS, STORE_TAGS
from benchmarks.planner.timed_store import timed_store
from planner import PlanNet, keep_in_step
from robots.world import LinkSpec, load_world
from tests.app.sample_store import Store

LIBRARY = """
packets:
  - tag: SET_OFF
    agent: "?robot"
    requires: ["robot_position(?robot, ?rel1, ?ref1)"]
    achieves: ["under_way_navigate_1(?robot, ?rel1, ?ref1, ?rel2, ?ref2, ?area)"]
  - tag: APPROACH
    agent: "?robot"
    requires: ["under_way_navigate_1(?robot, ?rel1, ?ref1, ?rel2, ?ref2, ?area)"]
    achieves: ["under_way_navigate_2(?robot, ?rel1, ?ref1, ?rel2, ?ref2, ?area)"]
  - tag: GO_IN
    agent: "?robot"
    requires:
      - under_way_navigate_2(?robot, ?rel1, ?ref1, ?rel2, ?ref2, ?area)
      - clear(?ref2, ?area)
    achieves: ["robot_position(?robot, ?rel2, ?ref2)"]
"""
TAGS = ("SET_OFF", "APPROACH", "GO_IN")


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


@pytest.fixture
def library(tmp_path: Path) -> Path:
    file = tmp_path / "library.yaml"
    file.write_text(LIBRARY)
    return file


def test_the_robot_that_comes_waits_with_its_last_packet_for_the_first_of_the_one_that_leaves(
    library: Path,
) -> None:
    net = handing_over_a_place()
    found = organise(
        net, load_library(store().base, library), dict.fromkeys(net.robots, TAGS), "m", store().base
    )
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


def test_a_robot_that_cannot_see_the_place_is_cleared_by_the_phase_that_leaves_it(library: Path) -> None:
    net = handing_over_a_place()
    facts = frozenset(link.fact for link in net.causal_links if link.producer == "initial")
    objects = {"yard_1": "robot", "yard_2": "robot", "door_1": "location", "yard": "area"}
    blind = keep_in_step(net, facts, objects, store().base, {"yard_2": frozenset()})
    found = organise(
        blind, load_library(store().base, library), dict.fromkeys(net.robots, TAGS), "m", store().base
    )
    assert isinstance(found, Organised), found
    leaves, comes = found.scripts
    assert [packet.after for packet in comes.packets] == [(), (), (leaves.packets[0].id,)]


@pytest.mark.parametrize(("carry", "is_passed_on"), [("TRANSPORT", True), ("HAUL", False)])
def test_a_leg_with_phases_is_not_passed_on(carry: str, is_passed_on: bool) -> None:
    packs = load_packs([str(PACK)])
    plain = load_world("sample_store")
    robots = tuple(r.model_copy(update={"repertoire": (*STORE_TAGS, *PHASE_TAGS)}) for r in plain.robots)
    world = plain.model_copy(update={"robots": robots, "peer_link": LinkSpec()})
    known = Store(world, packs.knowledge_base())
    names = {"robot": "yard_1"} if carry == "HAUL" else {"robots": "yard_1"}
    steps = [
        (carry, {**{k: v for k, v in arguments.items() if k != "robots"}, **names})
        if tag == "TRANSPORT"
        else (tag, arguments)
        for tag, arguments in known.carry("yard_1", "sample_1", "door_1", "door_2", came_from="home_yard_1")
    ]
    net = known.plan(steps, "in(sample_1, door_2)")
    found = organise(
        net,
        packs.library(),
        known.repertoires,
        "m",
        known.base,
        facts=known.facts,
        clearing=world.clearing,
        delegating=world.delegating,
    )
    assert isinstance(found, Organised), found
    (script,) = found.scripts
    assert bool(script.delegable) is is_passed_on


def test_without_packets_for_its_phases_an_action_is_refused() -> None:
    net = handing_over_a_place()
    shipped = load_library(store().base, shipped_library())
    found = organise(net, shipped, dict.fromkeys(net.robots, ("NAVIGATE",)), "m", store().base)
    assert isinstance(found, OrganiserFailure)
    assert "under_way_navigate_1" in found.reason


def test_a_plan_with_phases_is_the_same_when_it_has_been_stored() -> None:
    net = handing_over_a_place()
    body = PlanBody.of_plan_net(net, store().base)
    assert {action.phase for action in body.actions} == {1, 2, 3}
    assert PlanBody.model_validate_json(body.model_dump_json()).to_plan_net(store().base) == net
