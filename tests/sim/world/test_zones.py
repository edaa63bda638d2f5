"""Robots go round the zones that they are to keep out of, leave those that they are in, and keep to speeds."""

from math import dist
from typing import Any

import pytest

from benchmarks.bodies import embodied
from benchmarks.errands import tour
from robots.physical.body import RADIUS_M, Pose
from robots.wire import Message, Performative, ScriptReport, ScriptRequest, ScriptState
from robots.world import WorldFile, Zone, ZoneRule, load_world
from sim.trials.script_runner import ScriptRunner
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

LIMIT_S = 60


@pytest.mark.parametrize(
    ("area", "starts_inside"),
    [
        (Zone(name="spill", x=(3.6, 4.4), y=(0.6, 1.8), rule=ZoneRule.KEEP_OUT), False),
        (Zone(name="spill", x=(3.0, 5.0), y=(0.0, 2.0), rule=ZoneRule.KEEP_OUT), False),
        (Zone(name="spill", x=(1.0, 2.0), y=(1.5, 2.2), rule=ZoneRule.KEEP_OUT), True),
    ],
)
def test_a_robot_goes_round_an_area_or_leaves_it(area: Zone, starts_inside: bool) -> None:
    file = load_world("sample_store")
    world = WorldFile.model_validate({**file.model_dump(), "zones": [area.model_dump()]})
    simulation = Simulation(world, make_agent=behavioural_agent, seed=0, jitter_m=0.0)
    request = ScriptRequest(script=tour("yard_1", ["door_1", "door_2"]))
    told: dict[str, Any] = {"sender": "service", "receiver": "yard_1", "sent_at_s": 0.0, "body": request}
    simulation.link.send(Message(performative=Performative.REQUEST, **told))
    inside: list[bool] = []
    end = None
    while end is None and len(inside) < LIMIT_S * 20:
        simulation.step_control_cycle()
        at = simulation.truth().robots["yard_1"]
        middle_inside = area.contains((at.x_m, at.y_m))
        hull = area.grown(RADIUS_M / 2)
        inside.append(middle_inside if starts_inside else hull.contains((at.x_m, at.y_m)))
        reports = [one.body for one in simulation.link.receive() if isinstance(one.body, ScriptReport)]
        end = next((one.state for one in reports if one.state is not ScriptState.RUNNING), None)
    simulation.close()
    assert end is ScriptState.FINISHED
    assert inside == [True] * sum(inside) + [False] * (len(inside) - sum(inside))  # it does not come back
    assert any(inside) == starts_inside


def speeds_m_s(world: WorldFile, robot: str, places: list[str], zone: Zone) -> list[float]:
    """The true speed of a robot on a tour, for each 0.2 s that begin and end with its middle in the zone."""
    found: list[float] = []
    with ScriptRunner(world, seed=3, jitter_m=0.0) as runner:
        last: list[Pose] = []

        def note() -> None:
            here = runner.simulation.truth().robots[robot]
            last.append(here)
            if len(last) > 4:
                one = last.pop(0)
                if all(zone.contains((pose.x_m, pose.y_m)) for pose in (one, here)):
                    found.append(dist((one.x_m, one.y_m), (here.x_m, here.y_m)) / 0.2)

        assert runner.run([tour(robot, places)], meanwhile=note)
    return found


@pytest.mark.parametrize("body", ["velocity", "wheeled"])
def test_a_robot_keeps_to_the_speed_of_a_slow_zone(body: str) -> None:
    file = load_world("sample_store")
    zone = Zone(name="crossing", x=(3, 5), y=(0, 3.6), rule=ZoneRule.SLOW, max_speed_m_s=0.15)
    slow = embodied(WorldFile.model_validate({**file.model_dump(), "zones": [zone.model_dump()]}), body)
    inside = speeds_m_s(slow, "yard_1", ["door_1", "door_2"], zone)
    assert len(inside) > 10
    assert max(inside) <= 0.15 * 1.1
    free = speeds_m_s(embodied(file, body), "yard_1", ["door_1", "door_2"], zone)
    assert max(free) > 0.4
    assert len(inside) > 2 * len(free)


def crossing_hall(rule: ZoneRule) -> WorldFile:
    """A hall with a zone across it, in which one robot stands; another one is to pass."""
    return WorldFile.model_validate(
        {
            "name": "hall",
            "compartments": [{"name": "floor", "x": [0, 12], "y": [0, 5]}],
            "walls": [{"start": [0, y], "end": [12, y]} for y in (0, 5)],
            "zones": [{"name": "passage", "x": [4.5, 7.5], "y": [0, 5], "rule": rule}],
            "locations": [
                {"name": "home_rover", "kind": "home", "at": [0.6, 2.5], "approach_deg": [0], "capacity": 0},
                {"name": "home_other", "kind": "home", "at": [6.0, 0.6], "approach_deg": [90], "capacity": 0},
                {"name": "far", "kind": "place", "at": [11.0, 2.5], "approach_deg": [180], "capacity": 0},
                {"name": "aside", "kind": "place", "at": [11.0, 4.2], "approach_deg": [180], "capacity": 0},
            ],
            "robots": [
                {"name": "rover", "compartment": "floor", "start": [1.4, 2.5, 0], "home": "home_rover"},
                {"name": "other", "compartment": "floor", "start": [6.0, 1.4, -90], "home": "home_other"},
            ],
        }
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_on_an_unplanned_drive_stays_out_of_a_zone_for_one_until_the_other_leaves(seed: int) -> None:
    with ScriptRunner(crossing_hall(ZoneRule.ONE_ROBOT), seed=seed, jitter_m=0.0) as runner:
        (zone,) = runner.world.zones
        counts: list[int] = []

        def note() -> None:
            poses = runner.simulation.truth().robots
            counts.append(sum(zone.contains((pose.x_m, pose.y_m)) for pose in poses.values()))
            if len(counts) == 20 * 20:
                runner.send([tour("other", ["aside"])])

        assert runner.run([tour("rover", ["far"])], meanwhile=note, timeout_s=120)
        assert [end.state for end in runner.ended.values()] == [ScriptState.FINISHED] * 2
        assert max(counts) == 1
    with ScriptRunner(crossing_hall(ZoneRule.NAMED), seed=seed, jitter_m=0.0) as runner:
        counts.clear()
        assert runner.run([tour("rover", ["far"])], meanwhile=note, timeout_s=120)
        assert max(counts) == 2
