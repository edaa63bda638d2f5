"""From plan-nets to behaviour scripts."""

from dataclasses import replace

import pytest

from app.domain.mission_organiser import Library, Organised, OrganiserFailure, load_library, organise
from benchmarks.errands import with_sample
from planner import CausalLink, Fact, Keeping, Ordering, OrderingReason, PlanNet, PlanNetAction
from robots.world import load_world
from tests.app.sample_store import Store, said

STORE = Store()
LIBRARY = load_library(STORE.base)


def organised(net: PlanNet, library: Library = LIBRARY, **repertoires: tuple[str, ...]) -> Organised:
    result = organise(net, library, {**STORE.repertoires, **repertoires}, "mission-1", STORE.base)
    assert isinstance(result, Organised), result
    return result


def failure(net: PlanNet, library: Library = LIBRARY, **repertoires: tuple[str, ...]) -> str:
    result = organise(net, library, {**STORE.repertoires, **repertoires}, "mission-1", STORE.base)
    assert isinstance(result, OrganiserFailure)
    return result.reason


def action(id_: str, agents: tuple[str, ...], start_s: float = 0.0, **slots: object) -> PlanNetAction:
    """An artificial action of 10 s."""
    plain: dict[str, object] = {
        "tag": "TRACK",
        "arguments": {"robot1": agents[0], "robot2": "yard_2", "area": "yard"},
        "preconditions": tuple(Fact("in_area", (robot, "yard")) for robot in (agents[0], "yard_2")),
        "deletes": (),
        "intended_effects": (Fact("tracked", (agents[0], "yard_2")),),
        "other_effects": (),
    }
    return PlanNetAction(
        id=id_,
        agents=agents,
        duration_s=10.0,
        earliest_start_s=start_s,
        latest_start_s=start_s,
        description="",
        **{**plain, **slots},  # type: ignore[arg-type]
    )


def net_of(
    *actions: PlanNetAction, links: tuple[CausalLink, ...] = (), orderings: tuple[Ordering, ...] = ()
) -> PlanNet:
    return PlanNet(goals=(), actions=actions, causal_links=links, orderings=orderings, recruitment={})


def test_each_robot_gets_one_script_with_its_packets_in_the_plans_order() -> None:
    scripts = organised(STORE.store_sample_1()).scripts
    assert [script.robot for script in scripts] == ["store_2", "yard_1"]
    for script in scripts:
        assert [packet.tag for packet in script.packets] == ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]
        starts = [packet.expected_start_s for packet in script.packets]
        assert starts == sorted(starts)
        assert (script.id, script.mission_id) == (f"mission-1-{script.robot}", "mission-1")


def test_a_robot_awaits_only_what_another_brings_about() -> None:
    store_2, yard_1 = organised(STORE.store_sample_1()).scripts
    awaits = {packet.tag: packet.awaits for packet in store_2.packets}
    assert awaits == {
        "NAVIGATE": (),
        "DOCK": (said("in(sample_1, interchange_2)"),),
        "TRANSPORT": (),
        "RELEASE2": (),
    }
    assert not any(packet.awaits for packet in yard_1.packets)
    assert all(set(packet.awaits) <= set(packet.requires) for packet in store_2.packets)


def test_packets_achieve_their_actions_linking_goals() -> None:
    net = STORE.store_sample_1()
    for script in organised(net).scripts:
        for packet in script.packets:
            linked = {str(link.fact) for link in net.causal_links if link.producer == packet.id}
            assert len(packet.achieves) == len(linked) > 0
    last = organised(net).scripts[0].packets[-1]
    assert said("in(sample_1, bay_7)") in last.achieves


def test_packets_carry_the_actions_arguments_times_and_timeouts() -> None:
    net = STORE.store_sample_1()
    for script in organised(net).scripts:
        for packet in script.packets:
            planned = net.action(packet.id)
            assert packet.arguments == planned.arguments
            assert packet.expected_duration_s == planned.duration_s
            assert packet.timeout_s == max(30, 4 * planned.duration_s)
            bears_s = max(60, 3 * net.makespan_s) if packet.awaits or packet.after else 60
            assert packet.wait_timeout_s == bears_s


def test_only_for_what_another_robot_brings_about_is_waited_longer_than_a_minute() -> None:
    waits_s = {
        (script.robot, packet.tag): packet.wait_timeout_s
        for script in organised(STORE.store_sample_1()).scripts
        for packet in script.packets
    }
    assert waits_s["yard_1", "DOCK"] == 60 < waits_s["store_2", "DOCK"]


def test_the_choice_of_each_packet_is_explained_by_what_it_achieves() -> None:
    net = STORE.store_sample_1()
    reasons = organised(net).reasons
    assert set(reasons) == {planned.id for planned in net.actions}
    release = next(a for a in net.actions if a.tag == "RELEASE2" and a.agents == ("store_2",))
    assert reasons[release.id] == "store_2 does RELEASE2: it achieves in(sample_1, bay_7)"


def test_scripts_may_be_named_otherwise() -> None:
    result = organise(
        STORE.store_sample_1(),
        LIBRARY,
        STORE.repertoires,
        "mission-1",
        STORE.base,
        script_ids=lambda robot: f"script-of-{robot}",
    )
    assert isinstance(result, Organised)
    assert [script.id for script in result.scripts] == ["script-of-store_2", "script-of-yard_1"]


def test_releasing_to_another_robot_is_distinguished_from_depositing() -> None:
    both = (
        Fact("object_position", ("rock", "in", "fred")),
        Fact("object_position", ("rock", "in", "ginger")),
    )
    empty = Fact("robot_attribute", ("fred", "gripper", "empty"))
    release = action(
        "a1",
        ("fred",),
        tag="RELEASE1",
        arguments={"object": "rock", "robot1": "fred", "robot2": "ginger", "rel": "near", "ref": "spot"},
        preconditions=(
            *both,
            Fact("robot_attribute", ("fred", "gripper", "full")),
            Fact("robot_position", ("fred", "near", "spot")),
        ),
        intended_effects=(empty,),
    )
    links = (CausalLink(producer="a1", fact=empty, consumer="goal"),)
    (script,) = organised(net_of(release, links=links), fred=("RELEASE1", "RELEASE2")).scripts
    assert [packet.tag for packet in script.packets] == ["RELEASE1"]


TEAM = ("fred", "ginger")
TEAM_ABLE = dict.fromkeys(TEAM, ("TRANSPORT", "TRACK"))


def transport_together(id_: str, start_s: float = 0.0) -> PlanNetAction:
    """fred and ginger carry a rock that both hold."""
    return action(
        id_,
        TEAM,
        start_s,
        tag="TRANSPORT",
        arguments={
            "object": "rock",
            "robots": "fred+ginger",
            "rel1": "near",
            "ref1": "a",
            "rel2": "near",
            "ref2": "b",
        },
        preconditions=tuple(
            fact
            for robot in TEAM
            for fact in (
                Fact("robot_position", (robot, "near", "a")),
                Fact("robot_attribute", (robot, "gripper", "full")),
                Fact("object_position", ("rock", "in", robot)),
            )
        ),
        intended_effects=tuple(
            Fact("transported", ("rock", robot, "near", "a", "near", "b")) for robot in TEAM
        ),
    )


def test_each_member_of_a_team_gets_its_own_packet() -> None:
    transport = transport_together("a1")
    links = tuple(CausalLink(producer="a1", fact=f, consumer="goal") for f in transport.intended_effects)
    scripts = organised(net_of(transport, links=links), **TEAM_ABLE).scripts
    assert [(script.robot, [packet.tag for packet in script.packets]) for script in scripts] == [
        ("fred", ["TRANSPORT"]),
        ("ginger", ["TRANSPORT"]),
    ]
    assert all(script.robot in str(script.packets[0].requires) for script in scripts)


def test_a_packet_that_no_library_holds_is_named_with_what_it_should_achieve() -> None:
    without = Library([entry for entry in LIBRARY.entries if entry.tag != "DOCK"])
    reason = failure(STORE.store_sample_1(), without)
    assert "DOCK" in reason
    assert "in(sample_1, yard_1)" in reason


def test_a_packet_that_is_not_in_the_robots_repertoire_is_named_with_the_robot() -> None:
    reason = failure(STORE.store_sample_1(), store_2=("NAVIGATE", "TRANSPORT", "RELEASE2"))
    assert "store_2 has no DOCK in its repertoire" in reason


def test_two_packets_for_one_linking_goal_are_an_ambiguity() -> None:
    dock = next(entry for entry in LIBRARY.entries if entry.tag == "DOCK")
    library = Library([*LIBRARY.entries, replace(dock, tag="GRAB")])
    assert "DOCK and GRAB" in failure(STORE.store_sample_1(), library, yard_1=("NAVIGATE", "DOCK", "GRAB"))


def test_a_packet_whose_requirements_the_action_does_not_have_does_not_match() -> None:
    net = STORE.store_sample_1()
    dock = next(a for a in net.actions if a.tag == "DOCK")
    bare = replace(dock, preconditions=dock.preconditions[1:])
    changed = replace(net, actions=tuple(bare if a.id == dock.id else a for a in net.actions))
    assert dock.id in failure(changed)


def kept(kept_by: Keeping | None) -> Ordering:
    return Ordering(before="a1", after="a2", reason=OrderingReason.THREAT, kept_by=kept_by)


def after(net: PlanNet, **repertoires: tuple[str, ...]) -> dict[tuple[str, str], tuple[str, ...]]:
    """By robot and packet what it is to be cleared of."""
    scripts = organised(net, **repertoires).scripts
    return {(script.robot, packet.id): packet.after for script in scripts for packet in script.packets}


@pytest.mark.parametrize("keeping", [Keeping.CLEARANCE, None])
def test_an_ordering_that_nothing_else_keeps_is_left_to_clearance(keeping: Keeping | None) -> None:
    net = net_of(action("a1", ("yard_1",)), action("a2", ("yard_2",), 10.0), orderings=(kept(keeping),))
    assert after(net) == {("yard_1", "a1"): (), ("yard_2", "a2"): ("a1",)}


@pytest.mark.parametrize("keeping", [Keeping.ROBOT, Keeping.SENSING])
def test_an_ordering_that_is_kept_without_words_needs_no_clearance(keeping: Keeping) -> None:
    net = net_of(action("a1", ("yard_1",)), action("a2", ("yard_2",), 10.0), orderings=(kept(keeping),))
    assert not any(after(net).values())


def test_a_robot_is_not_cleared_of_what_it_does_alone_but_its_partner_is() -> None:
    net = net_of(
        action("a1", ("fred",)), transport_together("a2", 10.0), orderings=(kept(Keeping.CLEARANCE),)
    )
    told = after(net, **TEAM_ABLE)
    assert told == {("fred", "a1"): (), ("fred", "a2"): (), ("ginger", "a2"): ("a1",)}


def test_a_robot_is_cleared_of_what_it_has_done_together_with_another() -> None:
    net = net_of(
        transport_together("a1"), action("a2", ("fred",), 10.0), orderings=(kept(Keeping.CLEARANCE),)
    )
    assert after(net, **TEAM_ABLE)["fred", "a2"] == ("a1",)


def test_what_a_robot_cannot_sense_of_another_is_not_awaited() -> None:
    tracked = Fact("tracked", ("yard_1", "yard_2"))
    second = action("a2", ("store_1",), 10.0)
    second = replace(second, preconditions=(*second.preconditions, tracked))
    links = (CausalLink(producer="a1", fact=tracked, consumer="a2"),)
    net = net_of(action("a1", ("yard_1",)), second, links=links, orderings=(kept(Keeping.CLEARANCE),))
    (packet,) = organised(net).scripts[0].packets
    assert (packet.awaits, packet.after) == ((), ("a1",))


def test_what_lies_in_another_robots_gripper_is_not_awaited() -> None:
    held = Fact("object_position", ("sample_1", "in", "yard_1"))
    second = action("a2", ("store_1",), 10.0)
    second = replace(second, preconditions=(*second.preconditions, held))
    links = (CausalLink(producer="a1", fact=held, consumer="a2"),)
    net = net_of(action("a1", ("yard_1",), other_effects=(held,)), second, links=links)
    assert organised(net).scripts[0].packets[0].awaits == ()


def test_two_yard_robots_at_one_interchange_are_kept_in_order_by_clearance() -> None:
    world = with_sample(load_world("sample_store"), "sample_2", "door_2", vacant="bay_3")
    net = Store(world).one_interchange_twice()
    leave = next(a.id for a in net.actions if a.tag == "NAVIGATE" and a.arguments["ref1"] == "interchange_1")
    arrive = next(a.id for a in net.actions if a.tag == "TRANSPORT" and a.agents == ("yard_2",))
    told = {key: before for key, before in after(net).items() if before}
    assert told == {("yard_2", arrive): (leave,)}


def test_a_packet_is_told_what_its_number_is_to_be_at_its_end_if_it_can() -> None:
    near_home = Fact("robot_position", ("yard_1", "near", "home_yard_1"))
    charge = action(
        "a1",
        ("yard_1",),
        tag="CHARGE",
        arguments={"robot": "yard_1", "rel": "near", "ref": "home_yard_1"},
        preconditions=(near_home,),
        intended_effects=(Fact("charged", ("yard_1", "home_yard_1")),),
        level=0.6214,
    )
    (script,) = organised(net_of(charge)).scripts
    (packet,) = script.packets
    assert packet.tag == "RECHARGE", "every robot has it"
    assert packet.arguments == {**charge.arguments, "to": "0.621"}
    (script,) = organised(net_of(replace(charge, level=None))).scripts
    assert "to" not in script.packets[0].arguments
