"""A whole mission with clearance: service, record, links, robots and the simulated world; only the plan is given."""

import time
from pathlib import Path

from app.composition import RunningWorld, Service
from app.domain.lifecycles.mission import MissionState
from app.planning.goal_service import GoalRequest
from app.settings import Settings
from benchmarks.errands import with_sample
from robots.wire import PacketState
from robots.world import load_world
from sim import SimulationProcess
from tests.app.sample_store import Store
from tests.app.scripted import ScriptedWorker

GIVE_UP_S = 120.0


def mission_of(service: Service, goal_id: str) -> str:
    """The goal's mission, once it has ended."""
    give_up = time.monotonic() + GIVE_UP_S
    while True:
        assert time.monotonic() < give_up
        mission_id = service.goals.get(goal_id).mission_id
        if mission_id is not None and MissionState(service.missions.get(mission_id)[0].state).ended:
            return mission_id
        time.sleep(0.1)


def test_two_yard_robots_hand_over_at_one_interchange_one_after_the_other(tmp_path: Path) -> None:
    store = Store(with_sample(load_world("sample_store"), "sample_2", "door_2", vacant="bay_3"))
    net = store.one_interchange_twice()
    leaves = next(
        a.id for a in net.actions if a.arguments.get("ref1") == "interchange_1" and a.tag == "NAVIGATE"
    )
    arrives = next(a.id for a in net.actions if a.tag == "TRANSPORT" and a.agents == ("yard_2",))
    settings = Settings(data=tmp_path, token="a-token-for-the-scenario", database_url=None)
    with SimulationProcess.start(store.world, seed=1, speed=None) as simulation:
        running = RunningWorld(
            file=store.world, link=simulation.link, clock=simulation, rate=None, run=simulation.run
        )
        with Service(settings, [running], worker=ScriptedWorker(net)) as service:
            request = GoalRequest(
                world="sample_store", text="move sample_1 to bay_1 and sample_2 to bay_3", auto_approve=True
            )
            mission_id = mission_of(service, service.goals.submit(request, actor="scenario").id)
            mission, scripts = service.missions.get(mission_id)
            truth = simulation.truth()
    assert mission.state == MissionState.COMPLETED, mission.reason
    assert {name: truth.samples[name].ref for name in ("sample_1", "sample_2")} == {
        "sample_1": "bay_1",
        "sample_2": "bay_3",
    }
    packets = {script.robot: script.packets for script in scripts}
    assert packets["yard_1"][leaves]["state"] == PacketState.FINISHED
    assert packets["yard_1"][leaves]["finished_at_s"] < packets["yard_2"][arrives]["started_at_s"]
    assert {script.robot: script.cleared for script in scripts if script.cleared} == {"yard_2": [leaves]}


def test_a_robot_that_senses_nothing_docks_once_it_is_cleared(tmp_path: Path) -> None:
    plain = load_world("sample_store")
    blind = plain.robot("store_2").model_copy(update={"senses": ()})
    robots = tuple(blind if one.name == blind.name else one for one in plain.robots)
    store = Store(plain.model_copy(update={"robots": robots}))
    net = store.store_sample_1()
    release = next(a.id for a in net.actions if a.tag == "RELEASE2" and a.agents == ("yard_1",))
    dock = next(a.id for a in net.actions if a.tag == "DOCK" and a.agents == ("store_2",))
    settings = Settings(data=tmp_path, token="a-token-for-the-scenario", database_url=None)
    with SimulationProcess.start(store.world, seed=1, speed=None) as simulation:
        running = RunningWorld(
            file=store.world, link=simulation.link, clock=simulation, rate=None, run=simulation.run
        )
        with Service(settings, [running], worker=ScriptedWorker(net)) as service:
            request = GoalRequest(world="sample_store", text="move sample_1 to bay_7", auto_approve=True)
            mission_id = mission_of(service, service.goals.submit(request, actor="scenario").id)
            mission, scripts = service.missions.get(mission_id)
            truth = simulation.truth()
    assert mission.state == MissionState.COMPLETED, mission.reason
    assert truth.samples["sample_1"].ref == "bay_7"
    by_robot = {script.robot: script for script in scripts}
    assert not any(packet["awaits"] for packet in by_robot["store_2"].body["packets"])
    assert by_robot["store_2"].cleared == [release]
    ended_s = by_robot["yard_1"].packets[release]["finished_at_s"]
    assert by_robot["store_2"].packets[dock]["started_at_s"] >= ended_s
    assert mission.contradictions == []
