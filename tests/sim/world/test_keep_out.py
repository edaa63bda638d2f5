"""Robots go round the areas that they are to keep out of, and leave those that they are in."""

from typing import Any

import pytest

from benchmarks.errands import tour
from robots.physical.body import RADIUS_M
from robots.wire import Message, Performative, ScriptReport, ScriptRequest, ScriptState
from robots.world import KeepOut, WorldFile, load_world
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

LIMIT_S = 60


@pytest.mark.parametrize(
    ("area", "starts_inside"),
    [
        (KeepOut(name="spill", x=(3.6, 4.4), y=(0.6, 1.8)), False),
        (KeepOut(name="spill", x=(3.0, 5.0), y=(0.0, 2.0)), False),
        (KeepOut(name="spill", x=(1.0, 2.0), y=(1.5, 2.2)), True),
    ],
)
def test_a_robot_goes_round_an_area_or_leaves_it(area: KeepOut, starts_inside: bool) -> None:
    file = load_world("sample_store")
    world = WorldFile.model_validate({**file.model_dump(), "keep_out": [area.model_dump()]})
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
        hull = KeepOut(
            name="hull",
            x=(area.x[0] - RADIUS_M / 2, area.x[1] + RADIUS_M / 2),
            y=(area.y[0] - RADIUS_M / 2, area.y[1] + RADIUS_M / 2),
        )
        inside.append(middle_inside if starts_inside else hull.contains((at.x_m, at.y_m)))
        reports = [one.body for one in simulation.link.receive() if isinstance(one.body, ScriptReport)]
        end = next((one.state for one in reports if one.state is not ScriptState.RUNNING), None)
    simulation.close()
    assert end is ScriptState.FINISHED
    assert inside == [True] * sum(inside) + [False] * (len(inside) - sum(inside))  # it does not come back
    assert any(inside) == starts_inside
