"""Zones for one robot at a time: what is believed of them, and plans of the sample store that never share one."""

from collections import defaultdict
from dataclasses import replace
from itertools import combinations
from random import Random

import pytest

from app.domain.mission_organiser import Organised, load_library, organise
from app.domain.world_model import initial_facts, planning_problem, revise_beliefs
from app.domain.world_model.beliefs import robots_in_zones
from app.domain.world_model.edits import AddZone, MovePlace, RemoveZone, apply_edits, changed
from app.domain.world_model.reservation import Reservation, is_withheld, taken_by
from app.domain.world_model.timeliness import DatedFact, beliefs_contradicting
from app.domain.world_model.zones import places_in_zones, zones_against
from planner import (
    CausalLink,
    Fact,
    Keeping,
    Observer,
    OrderingReason,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    Progress,
    faults_of,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.relaxation import closed_zones
from planner.repair import NOT_BEGUN, Course, MissionProgress, repair
from robots.world import WorldFile, Zone, ZoneRule, load_world
from robots.world.slopes import within
from tests.app.sample_store import Store

STORE = Store()
BASE = STORE.base
GATE = Zone(name="gate", x=(3.4, 4.6), y=(0, 3.6), rule=ZoneRule.ONE_ROBOT)
"""Across the yard, between its doors."""
NOOK = Zone(name="nook", x=(0.5, 3), y=(0, 1.2), rule=ZoneRule.ONE_ROBOT)
"""Around door_1."""
END = Zone(name="end", x=(4.2, 8), y=(0, 3.6), rule=ZoneRule.ONE_ROBOT)
"""The east of the yard: door_2, interchange_2 and the home of yard_2."""
CLEAR = Fact("zone_clear", ("gate",))
REQUEST = PlanningRequest(effort_s=0.0)


def with_zones(*zones: Zone) -> WorldFile:
    return changed(STORE.world, zones=zones)


def near(robot: str, place: str) -> Fact:
    return Fact("robot_position", (robot, "near", place))


def problem_of(
    world: WorldFile, *goals: Fact, spots: dict[str, tuple[float, float]] | None = None
) -> PlanningProblem:
    return planning_problem(world, initial_facts(world, BASE), goals, spots=spots, knowledge_base=BASE)


def planned(problem: PlanningProblem) -> PlanNet:
    result = HierarchicalEngine(BASE).plan(problem, REQUEST)
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    assert faults_of(result.plan_net, problem.facts, BASE) == []
    return result.plan_net


def long_goal(world: WorldFile) -> Fact:
    """A long object brought to another place."""
    bar = next(one for one in world.samples if one.length_m)
    place = next(one.name for one in world.locations if one.capacity and one.name != bar.at)
    return Fact("object_position", (bar.name, "in", place))


def where(facts: tuple[Fact, ...], robot: str) -> str | None:
    return next((f.args[2] for f in facts if f.predicate == "robot_position" and f.args[0] == robot), None)


def stays(net: PlanNet, world: WorldFile, zone: Zone) -> dict[str, list[tuple[float, float]]]:
    """By robot when it is in the zone, seconds, told by where its actions take it, not by the facts of zones."""
    places = {place.name: place.at for place in world.places}
    inside = {place for place, _, name in places_in_zones(world) if name == zone.name}
    initial = initial_facts(world, BASE)
    found: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for robot in (spec.name for spec in world.robots):
        home = next(f.args[2] for f in initial if f.predicate == "robot_position" and f.args[0] == robot)
        since = 0.0 if home in inside else None
        for action in sorted(
            (one for one in net.actions if robot in one.agents), key=lambda one: one.earliest_start_s
        ):
            start = where(action.deletes, robot)
            end = where(action.effects, robot)
            if start is None or end is None or start == end:
                continue
            passes = within(places[start], places[end], zone) is not None
            if since is None and (end in inside or passes):
                since = action.earliest_start_s
            if since is not None and end not in inside:
                found[robot].append((since, action.earliest_end_s))
                since = None
        if since is not None:
            found[robot].append((since, float("inf")))
    return found


def assert_never_shared(net: PlanNet, world: WorldFile) -> None:
    for zone in world.zones:
        for one, other in combinations(stays(net, world, zone).values(), 2):
            for begun, ended in one:
                for since, until in other:
                    assert ended <= since + 0.01 or until <= begun + 0.01, (zone.name, one, other)


def test_two_robots_pass_a_zone_one_after_the_other_kept_by_a_clearance() -> None:
    world = with_zones(GATE)
    net = planned(problem_of(world, near("yard_1", "door_2"), near("yard_2", "door_1")))
    assert_never_shared(net, world)
    (ordering,) = net.orderings
    assert (ordering.reason, ordering.kept_by) == (OrderingReason.CAUSAL, Keeping.CLEARANCE)
    assert CausalLink(producer=ordering.before, fact=CLEAR, consumer=ordering.after) in net.causal_links
    free = planned(problem_of(STORE.world, near("yard_1", "door_2"), near("yard_2", "door_1")))
    assert free.orderings == ()
    assert net.makespan_s == pytest.approx(2 * free.makespan_s, rel=0.01)


class Told(Observer):
    """The makespans that the schedule had."""

    def __init__(self) -> None:
        self.makespans_s: list[float] = []

    def progress(self, progress: Progress) -> None:
        if progress.makespan_s is not None:
            self.makespans_s.append(progress.makespan_s)


def test_the_schedule_reckons_with_passing_one_after_the_other() -> None:
    problem = problem_of(with_zones(GATE), near("yard_1", "door_2"), near("yard_2", "door_1"))
    told = Told()
    result = HierarchicalEngine(BASE).plan(problem, PlanningRequest(), told)
    assert result.plan_net is not None
    assert told.makespans_s[-1] == pytest.approx(result.plan_net.makespan_s)


def test_a_robot_that_stands_in_a_zone_makes_way() -> None:
    world = with_zones(NOOK)
    facts = revise_beliefs(initial_facts(world, BASE), [near("yard_2", "door_1")])
    assert Fact("zone_clear", ("nook",)) not in facts
    assert robots_in_zones(facts) == {"nook": {"yard_2"}}
    problem = planning_problem(world, facts, [near("yard_1", "door_1")], knowledge_base=BASE)
    net = planned(problem)
    assert [
        (action.tag, action.agents[0]) for action in sorted(net.actions, key=lambda one: one.earliest_start_s)
    ] == [
        ("NAVIGATE", "yard_2"),
        ("NAVIGATE", "yard_1"),
    ]
    assert ("a1", "a2") in {(one.before, one.after) for one in net.orderings}


@pytest.mark.parametrize("seed", range(12))
def test_no_plan_has_two_robots_in_a_zone(seed: int) -> None:
    random = Random(seed)
    zones = random.sample([GATE, NOOK, END], random.choice([1, 2]))
    zones = [zones[0]] if {zone.name for zone in zones} == {"gate", "end"} else zones
    world = with_zones(*zones)
    samples = [sample.name for sample in world.samples]
    places = random.sample([f"bay_{number}" for number in (1, 3, 4, 6, 7, 8, 10, 12)] + ["door_2"], 4)
    goals = [
        Fact("object_position", (sample, "in", place))
        for sample, place in zip(random.sample(samples, 3), places, strict=False)
    ]
    problem = problem_of(world, *goals)
    net = planned(problem)
    assert_never_shared(net, world)


def test_the_robots_wait_for_the_clearance_of_what_leaves_the_zone() -> None:
    world = with_zones(GATE)
    net = planned(problem_of(world, near("yard_1", "door_2"), near("yard_2", "door_1")))
    organised = organise(
        net, load_library(BASE), {one.name: one.repertoire for one in world.robots}, "mission", BASE
    )
    assert isinstance(organised, Organised)
    packets = {packet.id: packet for script in organised.scripts for packet in script.packets}
    (ordering,) = net.orderings
    assert packets[ordering.after].after == (ordering.before,)
    assert packets[ordering.before].after == ()
    assert not any(fact.predicate == "zone_clear" for one in packets.values() for fact in one.requires)


def test_two_robots_that_carry_a_long_object_pass_no_zone() -> None:
    world = changed(
        load_world("relocation_lab"),
        zones=(Zone(name="neck", x=(5, 6), y=(0, 7), rule=ZoneRule.ONE_ROBOT),),
    )
    problem = planning_problem(world, initial_facts(world, BASE), [long_goal(world)], knowledge_base=BASE)
    assert HierarchicalEngine(BASE).plan(problem, REQUEST).plan_net is None
    assert planned(replace(problem, crossings={})).robots == ("fred", "ginger")


def test_zone_clear_follows_from_where_robots_stand() -> None:
    world = with_zones(NOOK)
    facts = initial_facts(world, BASE)
    free = Fact("zone_clear", ("nook",))
    assert free in facts
    inside = revise_beliefs(facts, [near("yard_1", "door_1")])
    assert free not in inside
    assert free not in revise_beliefs(inside, [free])  # it cannot be told
    assert free in revise_beliefs(inside, [near("yard_1", "home_yard_1")])
    dated = [DatedFact(fact=fact, source="report of yard_1", at_s=3.0) for fact in inside]
    assert [one.fact for one in beliefs_contradicting(free, dated)] == [near("yard_1", "door_1")]


def test_a_robot_on_the_open_floor_of_a_zone_holds_it_and_gives_it_back_when_it_leaves() -> None:
    world = with_zones(GATE)
    facts = revise_beliefs(initial_facts(world, BASE), [near("yard_1", "yard_1_spot")])
    goals = [near("yard_1", "door_1"), near("yard_2", "interchange_1")]
    problem = planning_problem(world, facts, goals, spots={"yard_1_spot": (4.0, 1.8)}, knowledge_base=BASE)
    assert CLEAR not in problem.facts
    net = planned(problem)
    by_robot = {action.agents[0]: action for action in net.actions}
    assert CLEAR in by_robot["yard_1"].effects
    assert CLEAR not in by_robot["yard_1"].preconditions
    assert [(one.before, one.after) for one in net.orderings] == [
        (by_robot["yard_1"].id, by_robot["yard_2"].id)
    ]


def test_of_two_robots_in_a_zone_the_first_to_leave_does_not_clear_it() -> None:
    world = with_zones(END)
    facts = revise_beliefs(
        initial_facts(world, BASE), [near("yard_1", "door_2"), near("yard_2", "interchange_2")]
    )
    problem = planning_problem(world, facts, [near("yard_1", "door_1")], knowledge_base=BASE)
    (action,) = planned(problem).actions
    assert not any(fact.predicate == "zone_clear" for fact in action.effects)


def test_a_mission_reserves_the_zones_that_it_enters() -> None:
    world = with_zones(GATE)
    problem = problem_of(world, near("yard_1", "door_2"))
    reserved = taken_by(planned(problem))
    assert "gate" in reserved.locations
    assert is_withheld(CLEAR, Reservation(locations=frozenset({"gate"})))
    leaving = planned(problem_of(with_zones(END), near("yard_2", "door_1")))
    assert "end" not in taken_by(leaving).names  # it only leaves


def test_a_plan_made_before_a_zone_does_not_keep_to_it() -> None:
    net = planned(problem_of(STORE.world, near("yard_1", "door_2")))
    assert list(zones_against(net, STORE.world)) == []
    assert list(zones_against(net, with_zones(GATE))) == [
        "a1 enters gate, a zone for one robot, without regard to others"
    ]
    closed = Zone(name="spill", x=(5, 7), y=(0, 1), rule=ZoneRule.KEEP_OUT)
    assert list(zones_against(net, with_zones(closed))) == [
        "a1 goes to door_2, which is in spill, a zone to keep out of"
    ]
    kept = planned(problem_of(with_zones(GATE), near("yard_1", "door_2")))
    assert list(zones_against(kept, with_zones(GATE))) == []


def test_edits_change_which_places_are_in_a_zone_and_whether_it_is_clear() -> None:
    facts = STORE.facts
    added = apply_edits(STORE.world, [AddZone(zone=NOOK)], facts, BASE)
    new = {f for f in added.facts - facts if f.predicate in ("in_zone", "zone_clear")}
    assert new == added.facts - facts
    assert Fact("in_zone", ("door_1", "yard", "nook")) in new
    assert Fact("zone_clear", ("nook",)) in new
    moved = apply_edits(
        added.world,
        [MovePlace(name="door_1", at=(5.0, 0.4))],
        facts=revise_beliefs(added.facts, [Fact("object_position", ("sample_1", "in", "door_2"))]),
        knowledge_base=BASE,
    )
    assert Fact("in_zone", ("door_1", "yard", "nook")) not in moved.facts
    removed = apply_edits(added.world, [RemoveZone(name="nook")], added.facts, BASE)
    assert removed.facts == facts
    assert removed.undo == (AddZone(zone=NOOK),)


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        (ZoneRule.NAMED, "named yard_end"),
        (ZoneRule.KEEP_OUT, "closed yard_end"),
        (ZoneRule.ONE_ROBOT, "limited yard_end to one robot"),
        (ZoneRule.SLOW, "limited yard_end to 0.2 m/s"),
    ],
)
def test_an_edit_says_what_has_become_of_the_zone(rule: ZoneRule, words: str) -> None:
    speed_m_s = 0.2 if rule is ZoneRule.SLOW else None
    zone = Zone(name="yard_end", x=(6, 8), y=(0, 3), rule=rule, max_speed_m_s=speed_m_s)
    assert str(AddZone(zone=zone)) == words


CHANGING_SIDES = (near("yard_1", "door_2"), near("yard_2", "door_1"))


def stuck_in_gate(world: WorldFile) -> PlanningProblem:
    """The present problem after yard_1 has stopped on its way, in the gate."""
    facts = revise_beliefs(initial_facts(world, BASE), [near("yard_1", "yard_1_spot")])
    spots = {"yard_1_spot": (4.0, 1.0)}
    return planning_problem(world, facts, CHANGING_SIDES, spots=spots, knowledge_base=BASE)


def test_a_repair_has_the_robot_that_stopped_in_a_zone_leave_it_first() -> None:
    world = with_zones(GATE)
    net = planned(problem_of(world, *CHANGING_SIDES))
    present = stuck_in_gate(world)
    made = repair(HierarchicalEngine(BASE), BASE, net, present, NOT_BEGUN, REQUEST)
    assert made.plan_net is not None
    assert faults_of(made.plan_net, made.problem.facts, BASE) == []
    out, through = sorted(made.plan_net.actions, key=lambda one: one.earliest_start_s)
    assert (out.agents, through.agents) == (("yard_1",), ("yard_2",))
    assert CLEAR in out.effects
    assert CLEAR not in out.preconditions
    assert [(one.before, one.after) for one in made.plan_net.orderings] == [(out.id, through.id)]


def test_a_repair_while_a_robot_passes_keeps_the_others_out_until_it_has() -> None:
    world = with_zones(GATE)
    present = problem_of(world, *CHANGING_SIDES)
    net = planned(present)
    passing, waiting = sorted(net.actions, key=lambda one: one.earliest_start_s)
    begun = present.facts - set(passing.deletes)
    progress = MissionProgress(under_way={passing.id: 5.0}, elapsed_s=7.0)
    made = repair(HierarchicalEngine(BASE), BASE, net, replace(present, facts=begun), progress, REQUEST)
    assert made.course is Course.KEPT
    assert made.plan_net is not None
    starts = {action.agents: action.earliest_start_s for action in made.plan_net.actions}
    assert starts == {passing.agents: 0.0, waiting.agents: 5.0}


def test_a_zone_that_a_lost_robot_holds_is_named_as_what_makes_the_goal_impossible() -> None:
    world = with_zones(GATE)
    net = planned(problem_of(world, *CHANGING_SIDES))
    present = replace(stuck_in_gate(world), goals=CHANGING_SIDES[1:])
    progress = MissionProgress(lost=frozenset({"yard_1"}))
    made = repair(HierarchicalEngine(BASE), BASE, net, present, progress, REQUEST)
    assert (made.result.status, made.result.reason) == (PlanningStatus.UNSOLVABLE, "gate is held by yard_1")


def test_what_needs_a_zone_that_another_mission_has_reserved_is_proven_impossible() -> None:
    world = with_zones(GATE)
    reserved = Reservation(robots=frozenset({"yard_1"}), locations=frozenset({"gate", "door_2"}))
    facts = initial_facts(world, BASE)
    through = planning_problem(
        world, facts, [near("yard_2", "door_1")], reserved=reserved, knowledge_base=BASE
    )
    assert closed_zones(BASE, through) == {"gate": ()}
    assert HierarchicalEngine(BASE).plan(through, REQUEST).status is PlanningStatus.UNSOLVABLE
    beside = replace(through, goals=(near("yard_2", "interchange_2"),))
    assert planned(beside).robots == ("yard_2",)


def test_a_zone_is_not_closed_while_somebody_inside_can_leave() -> None:
    assert closed_zones(BASE, stuck_in_gate(with_zones(GATE))) == {}
    both = with_zones(GATE, END)  # who stands in the end leaves it through the gate, once that is clear
    facts = revise_beliefs(
        initial_facts(both, BASE), [near("yard_1", "yard_1_spot"), near("yard_2", "interchange_2")]
    )
    spots = {"yard_1_spot": (3.6, 1.0)}
    problem = planning_problem(both, facts, [near("yard_1", "door_2")], spots=spots, knowledge_base=BASE)
    assert closed_zones(BASE, problem) == {}
