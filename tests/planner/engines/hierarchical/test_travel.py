"""Configurations, needs and the ways between them, said once for agents that are alike."""

from collections.abc import Sequence
from dataclasses import replace
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner import Fact, KnowledgeBase, PlanningProblem, load_knowledge_base
from planner.engines.hierarchical.legs.travel import NEAREST, Travel
from planner.errors import OutOfTime
from tests.planner.engines.hierarchical.composing import ProblemSetup
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside


def near(robot: str, place: str) -> frozenset[Fact]:
    return frozenset({Fact("robot_position", (robot, "near", place))})


def carrying(robot: str, sample: str, door: str, end: str) -> list[tuple[str, dict[str, str]]]:
    """What brings a sample from a door to the end, as tags and arguments."""
    one = {"object": sample, "robots": robot, "rel1": "near", "ref1": door}
    other = one | {"rel1": "at", "rel2": "near", "ref2": end}
    return [("DOCK", one), ("TRANSPORT", other | {"area": "yard"}), ("RELEASE2", other)]


@pytest.fixture
def world(knowledge_base: KnowledgeBase) -> ProblemSetup:
    problem = Store(doors=6).problem([inside("sample", "bay_0_0")], {"sample": "door_4", "other": "door_5"})
    return ProblemSetup.of(knowledge_base, problem)


@pytest.fixture
def travel(world: ProblemSetup) -> Travel:
    return Travel(world.classified)


def test_agents_of_a_class_share_needs(travel: Travel) -> None:
    assert travel.need("yard_0", near("yard_0", "door_1")) == travel.need("yard_1", near("yard_1", "door_1"))
    assert travel.need("yard_0", near("yard_0", "door_0")) != travel.need("yard_0", near("yard_0", "door_1"))


def test_every_need_is_reached_from_every_start_of_the_class(travel: Travel) -> None:
    need = travel.need("yard_0", near("yard_0", "door_1"))
    travel.close()
    for agent in ("yard_0", "yard_1"):
        way = travel.way[travel.starts[agent], need]
        assert [action.tag for action in travel.ways[way].actions] == ["NAVIGATE"]
    assert (travel.starts["store_0_0"], need) not in travel.way


def test_ways_are_no_longer_looked_for_once_the_time_is_over(travel: Travel) -> None:
    travel.need("yard_0", near("yard_0", "door_1"))
    with pytest.raises(OutOfTime):
        travel.close(lambda: True)
    assert not travel.way
    travel.close()
    assert travel.way


def test_the_nearest_steps_are_few_and_sorted(travel: Travel) -> None:
    for door in range(6):
        travel.need("yard_0", near("yard_0", f"door_{door}"))
    travel.close()
    spans = [travel.ways[way].actions[0].duration_s for way in travel.nearest()[travel.starts["yard_0"]]]
    assert len(spans) == NEAREST
    assert spans == sorted(spans)


def test_agents_go_on_from_places_near_to_where_several_legs_end(world: ProblemSetup, travel: Travel) -> None:
    needs = [travel.need("yard_0", near("yard_0", f"door_{door}")) for door in range(6)]
    for sample, door in (("sample", "door_4"), ("other", "door_5")):
        brought = [
            world.base.ground(tag, arguments, world.problem.functions, objects=world.problem.objects)
            for tag, arguments in carrying("yard_0", sample, door, "interchange_0_0")
        ]
        travel.effect("yard_0", brought, travel.need("yard_0", near("yard_0", door)))
    travel.close()
    assert travel.ahead()[needs[5]] == []
    travel.stop_near()
    travel.close()
    assert travel.ahead()[needs[5]][:3] == [needs[3], needs[2], needs[1]]


def test_what_legs_do_is_known_after_needs_that_were_met_before(world: ProblemSetup, travel: Travel) -> None:
    need = travel.need("yard_0", near("yard_0", "door_4"))
    travel.close()
    there = travel.ends[travel.way[travel.starts["yard_0"], need]]
    brought = [
        world.base.ground(tag, arguments, world.problem.functions, objects=world.problem.objects)
        for tag, arguments in carrying("yard_0", "sample", "door_4", "interchange_0_0")
    ]
    effect = travel.effect("yard_0", brought, need)
    travel.close()
    assert (travel.after[there, effect], need) in travel.way


def test_an_agent_leaves_for_what_is_in_nobodys_way(world: ProblemSetup, travel: Travel) -> None:
    at_door = travel.need("yard_0", near("yard_0", "door_1"))
    travel.close()
    here = travel.ends[travel.way[travel.starts["yard_0"], at_door]]
    clear = Fact("clear", ("door_1", "yard"))
    wanted = frozenset({Fact("clear", ("door_0", "yard"))})
    assert travel.leave("yard_0", here, clear, wanted)
    ends = [
        travel.ways[way].actions[0].arguments["ref2"] for at, way in travel.leaves["yard_0"] if at == here
    ]
    assert "door_0" not in ends
    assert "door_2" in ends
    assert not travel.leave("yard_0", here, clear, wanted), "the same ways are not added twice"


def _shortest_s(
    base: KnowledgeBase, problem: PlanningProblem, places: Sequence[str]
) -> dict[tuple[str, str], float]:
    """Between all places, by whatever others (Floyd and Warshall)."""
    way = {"robots": "yard_0", "rel1": "near", "rel2": "near", "area": "yard"}
    spans = {
        (one, other): base.ground(
            "NAVIGATE", {**way, "ref1": one, "ref2": other}, problem.functions, objects=problem.objects
        ).duration_s
        for one in places
        for other in places
        if one != other
    }
    for via in places:
        for one in places:
            for other in places:
                if len({one, via, other}) == 3:
                    spans[one, other] = min(spans[one, other], spans[one, via] + spans[via, other])
    return spans


@settings(max_examples=20, deadline=None)
@given(chance=st.randoms(use_true_random=False))
def test_ways_are_the_shortest_in_whatever_order_they_are_asked_for(chance: Random) -> None:
    base = load_knowledge_base()
    straight = Store(doors=4, aisles=1).problem([inside("sample", "bay_0_0")], {"sample": "door_0"})
    longer = {key: value * chance.uniform(1.0, 4.0) for key, value in straight.functions.items()}
    problem = replace(straight, functions=longer)
    places = ["home_yard_0", "interchange_0_0", *(f"door_{n}" for n in range(4))]
    spans = _shortest_s(base, problem, places)
    setups = ProblemSetup.of(base, problem).setups("yard_0")
    pairs = sorted(spans)
    chance.shuffle(pairs)
    for one, other in pairs:
        way = setups.way(_empty_near("yard_0", one), near("yard_0", other))
        assert way is not None
        assert way.end == _empty_near("yard_0", other)
        assert sum(action.duration_s for action in way.actions) == pytest.approx(spans[one, other])


def test_detours_pay_where_the_way_by_a_third_place_is_shorter(world: ProblemSetup) -> None:
    straight = world.problem
    assert not world.classified.detours_pay, "all distances are those of straight ways"
    pair = ("distance_m", ("door_0", "door_3"))
    for extra_m, pays in ((0.0, False), (0.005, False), (1.0, True)):
        functions = {**straight.functions, pair: straight.functions[pair] + extra_m}
        longer = replace(straight, functions=functions)
        assert ProblemSetup.of(world.base, longer).classified.detours_pay is pays
    one_way = {key: value for key, value in straight.functions.items() if key != pair}
    assert not ProblemSetup.of(world.base, replace(straight, functions=one_way)).classified.detours_pay


def _empty_near(robot: str, place: str) -> frozenset[Fact]:
    return near(robot, place) | {Fact("robot_attribute", (robot, "gripper", "empty"))}
