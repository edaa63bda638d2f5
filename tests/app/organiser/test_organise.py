"""From plan-nets to behaviour scripts."""

from dataclasses import replace

import pytest

from app.organiser import Library, Organised, OrganiserFailure, load_library, organise
from planner import CausalLink, Fact, Ordering, OrderingReason, PlanNet, PlanNetAction
from tests.app.store import Store, said

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
            assert packet.wait_timeout_s == max(60, 3 * net.makespan_s)


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


def test_releasing_to_another_robot_is_told_from_depositing() -> None:
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


def test_each_member_of_a_team_gets_its_own_packet() -> None:
    team = ("fred", "ginger")
    transported = tuple(Fact("transported", ("rock", robot, "near", "a", "near", "b")) for robot in team)
    transport = action(
        "a1",
        team,
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
            for robot in team
            for fact in (
                Fact("robot_position", (robot, "near", "a")),
                Fact("robot_attribute", (robot, "gripper", "full")),
                Fact("object_position", ("rock", "in", robot)),
            )
        ),
        intended_effects=transported,
    )
    links = tuple(CausalLink(producer="a1", fact=fact, consumer="goal") for fact in transported)
    scripts = organised(net_of(transport, links=links), fred=("TRANSPORT",), ginger=("TRANSPORT",)).scripts
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


def test_what_a_robot_cannot_sense_of_another_cannot_be_awaited() -> None:
    tracked = Fact("tracked", ("yard_1", "yard_2"))
    second = action("a2", ("store_1",), 10.0)
    second = replace(second, preconditions=(*second.preconditions, tracked))
    links = (CausalLink(producer="a1", fact=tracked, consumer="a2"),)
    reason = failure(net_of(action("a1", ("yard_1",)), second, links=links))
    assert "store_1 cannot sense tracked(yard_1, yard_2), which a2 awaits" in reason


def test_what_lies_in_another_robots_gripper_cannot_be_sensed() -> None:
    held = Fact("object_position", ("sample_1", "in", "yard_1"))
    first = action("a1", ("yard_1",), intended_effects=(held,))
    second = action(
        "a2", ("yard_2",), 10.0, preconditions=(held, Fact("robot_position", ("yard_1", "at", "door_1")))
    )
    links = (CausalLink(producer="a1", fact=held, consumer="a2"),)
    assert "yard_2 cannot sense in(sample_1, yard_1)" in failure(net_of(first, second, links=links))


@pytest.mark.parametrize("reason", list(OrderingReason))
def test_an_ordering_between_robots_that_nothing_sensed_keeps_is_a_failure(reason: OrderingReason) -> None:
    orderings = (Ordering(before="a1", after="a2", reason=reason),)
    net = net_of(action("a1", ("yard_1",)), action("a2", ("yard_2",), 10.0), orderings=orderings)
    assert f"keeps a2 after a1 ({reason.value})" in failure(net)


def test_an_ordering_that_follows_from_awaits_and_the_robots_own_order_is_kept() -> None:
    """yard_1: a1, a2; store_1: a3 after a2's sensed effect, a4. So a1 is before a4, though unlinked."""
    vacant = Fact("vacant", ("interchange_1",))
    actions = (
        action("a1", ("yard_1",), 0.0),
        action("a2", ("yard_1",), 10.0, other_effects=(vacant,)),
        action("a3", ("store_1",), 20.0),
        action("a4", ("store_1",), 30.0),
    )
    actions = (
        *actions[:2],
        replace(actions[2], preconditions=(*actions[2].preconditions, vacant)),
        actions[3],
    )
    links = (CausalLink(producer="a2", fact=vacant, consumer="a3"),)
    orderings = (
        Ordering(before="a2", after="a3", reason=OrderingReason.CAUSAL),
        Ordering(before="a1", after="a4", reason=OrderingReason.THREAT),
    )
    scripts = organised(net_of(*actions, links=links, orderings=orderings)).scripts
    assert [[packet.awaits for packet in script.packets] for script in scripts] == [
        [(said("vacant(interchange_1)"),), ()],
        [(), ()],
    ]
    backwards = (Ordering(before="a3", after="a2", reason=OrderingReason.THREAT),)
    assert "keeps a2 after a3" in failure(net_of(*actions, links=links, orderings=backwards))


def test_one_robot_of_a_team_that_is_not_kept_in_order_is_a_failure() -> None:
    first = action("a1", ("yard_1",))
    team = action("a2", ("yard_1", "yard_2"), 10.0)
    orderings = (Ordering(before="a1", after="a2", reason=OrderingReason.RESOURCE),)
    assert "nothing that yard_2 senses keeps a2 after a1" in failure(net_of(first, team, orderings=orderings))
