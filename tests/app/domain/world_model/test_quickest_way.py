"""What opening and riding takes counts when a plan chooses its way, compared with every way in small worlds."""

import random
from collections.abc import Iterator, Mapping

import pytest

from app.domain.world_model import initial_facts, initial_spots, planning_problem
from planner import Fact, PlanningProblem, PlanningRequest, load_knowledge_base
from planner.engines.registry import engine_named
from planner.problem.zones import ground_action
from robots.world import WorldFile, load_world
from tests.sim.rig import with_only

BASE = load_knowledge_base()
ENGINE = engine_named("macta", BASE)
ROBOT = "store_1"
START = "home_store_1"


def store(seconds: Mapping[str, float]) -> WorldFile:
    """The guarded store with a corridor past the lift, which has a door at its western end.

    :param seconds: how long each door opens and closes, and the lift travels.
    """
    file = with_only(load_world("guarded_store"), ROBOT).model_dump(mode="json")
    for wall in file["walls"]:
        if wall["start"][0] == wall["end"][0] and wall["start"][0] in (10, 12.4):
            wall["openings"].insert(0, {"kind": "gap", "at_m": 0.9, "width_m": 1.2})
    file["peripherals"].append({"name": "gate_3", "kind": "door", "start": [10, 3.9], "end": [10, 5.1]})
    for name, x_m in (("corridor_west", 9.4), ("corridor_east", 13.0)):
        place = {"name": name, "kind": "place", "at": [x_m, 4.5], "approach_deg": [0], "capacity": 0}
        file["locations"].append(place)
    for one in file["peripherals"]:
        if one["kind"] == "door":
            one |= {"opening_s": seconds[one["name"]], "closing_s": seconds[one["name"]]}
        elif one["kind"] == "lift":
            one["travel_s"] = seconds[one["name"]]
    return WorldFile.model_validate(file)


def problem(world: WorldFile, end: str) -> PlanningProblem:
    goal = Fact("robot_position", (ROBOT, "near", end))
    facts = initial_facts(world, BASE)
    return planning_problem(world, facts, [goal], knowledge_base=BASE, spots=initial_spots(world))


def every_makespan_s(posed: PlanningProblem, end: str) -> Iterator[float]:
    """The makespan of each way without a circle: doors open from the start, each until the robot is through."""
    numbers = posed.functions
    stops = {place for (name, args) in numbers if name == "distance_m" for place in args}
    stops &= {fact.args[0] for fact in posed.facts if fact.predicate == "on_way"} | {START, end}

    def drive_s(here: str, there: str) -> float:
        positions = {"rel1": "near", "ref1": here, "rel2": "near", "ref2": there, "area": "store"}
        return ground_action("NAVIGATE", {"robots": ROBOT, **positions}, posed, BASE).duration_s

    def go(way: tuple[str, ...], now_s: float, closed_s: float, lift: tuple[str, float]) -> Iterator[float]:
        """:param closed_s: when the last of the doors is closed. :param lift: its level, and since when it is free."""
        here = way[-1]
        if here == end:
            yield max(now_s, closed_s)
            return
        for there in sorted(stops.difference(way)):
            if ("distance_m", (here, there)) not in numbers:
                continue
            start_s = now_s
            level, free_s = lift
            asked = posed.access.ways.get((here, there), ())
            for fact in asked:
                if fact.predicate == "opened":
                    start_s = max(start_s, numbers["opening_s", fact.args])
                elif level != fact.args[1]:
                    ride = ("travel_s", (fact.args[0], level, fact.args[1]))
                    start_s = max(start_s, free_s + numbers[ride])
                    level = fact.args[1]
            then_s = start_s + drive_s(here, there)
            doors = [then_s + numbers["closing_s", fact.args] for fact in asked if fact.predicate == "opened"]
            is_lifted = any(fact.predicate == "lift_at" for fact in asked)
            yield from go(
                (*way, there), then_s, max((closed_s, *doors)), (level, then_s if is_lifted else free_s)
            )

    return go((START,), 0.0, 0.0, ("ground", 0.0))


@pytest.mark.parametrize("seed", [2, 3, 5, 9])
def test_hardly_any_way_is_quicker_than_that_of_the_plan_doors_and_lift_counted(seed: int) -> None:
    """The plan may be longer by an eighth: not all combinations are tried."""
    rng = random.Random(seed)
    names = ("gate_1", "gate_2", "gate_3", "lift_1")
    posed = problem(store({name: rng.choice([1.0, 6.0, 15.0, 40.0]) for name in names}), "bay_6")
    least_s = min(every_makespan_s(posed, "bay_6"))
    found = ENGINE.plan(posed, PlanningRequest(effort_s=0.0))
    assert found.plan_net is not None, found.reason
    assert least_s - 0.05 < found.plan_net.makespan_s < 1.125 * least_s
