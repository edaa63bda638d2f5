"""Agents in several processes act as they do in one."""

import pickle
from itertools import pairwise

import pytest

from benchmarks.errands import tour
from robots.compilation import uncompiled
from robots.physical.body import Image, Pose, Readings
from robots.wire import Message, Performative, ScriptRequest
from robots.world import Edition, WorldFile, load_world
from sim.error import SimulationError
from sim.snapshot import WorldSnapshot
from sim.truth import Truth
from sim.world.agent import AgentSetup
from sim.world.agent_group import NOTHING, ROBOTS_A_PROCESS, processes_for
from sim.world.agents import behavioural_agent
from sim.world.remote_robot import ReadingsSender, RemoteRobot
from sim.world.simulation import Simulation
from tests.sim.rig import run_s, two_rooms

WORLD = load_world("sample_store")


def busy(processes: int, snapshot: WorldSnapshot | None = None) -> Simulation:
    """All robots on tours."""
    simulation = Simulation(
        WORLD, make_agent=behavioural_agent, seed=2, snapshot=snapshot, processes=processes
    )
    if snapshot is None:
        for spec in WORLD.robots:
            places = [place.name for place in WORLD.reach_of(spec) if place.kind != "home"]
            simulation.link.send(
                Message(
                    performative=Performative.REQUEST,
                    sender="service",
                    receiver=spec.name,
                    sent_at_s=0.0,
                    body=ScriptRequest(script=tour(spec.name, places)),
                )
            )
    return simulation


def outcome(simulation: Simulation, seconds: float) -> tuple[Truth, WorldSnapshot, list[dict[str, object]]]:
    """The truth, the snapshot and the messages at the end, without what is drawn for each message."""
    run_s(simulation, seconds)
    sent = [message.model_dump(exclude={"id", "in_reply_to"}) for message in simulation.link.receive()]
    snapshot = simulation.snapshot()
    robots = {
        name: memory.model_copy(update={"mind": memory.mind.model_copy(update={"mailbox": None})})
        for name, memory in snapshot.robots.items()
    }
    return simulation.truth(), snapshot.model_copy(update={"run": "", "robots": robots}), sent


def test_a_run_is_the_same_however_many_processes_there_are() -> None:
    outcomes = []
    for processes in (1, 2, 3):
        simulation = busy(processes)
        outcomes.append(outcome(simulation, 6.0))
        simulation.close()
    assert all(one == other for one, other in pairwise(outcomes))
    _, snapshot, sent = outcomes[0]
    assert list(snapshot.robots) == [spec.name for spec in WORLD.robots]
    assert len(sent) > 4 * 50
    assert any(body.wanted != (0.0, 0.0) for body in snapshot.bodies.values())


def test_a_world_goes_on_in_another_number_of_processes() -> None:
    first = busy(2)
    run_s(first, 3.0)
    snapshot = first.snapshot()
    first.close()
    outcomes = []
    for processes in (1, 3):
        resumed = busy(processes, snapshot)
        outcomes.append(outcome(resumed, 3.0))
        resumed.close()
    assert outcomes[0] == outcomes[1]


class Clumsy:
    """An agent whose first tick fails."""

    def __init__(self, setup: AgentSetup) -> None:
        self._name = setup.spec.name

    def tick(self) -> None:
        if self._name == "ginger":
            raise ValueError("ginger has fallen over")


def test_an_error_of_an_agent_in_another_process_ends_the_tick() -> None:
    simulation = Simulation(two_rooms(second=(1, 0.4, 0)), make_agent=Clumsy, processes=2)
    with pytest.raises(SimulationError, match="ginger has fallen over"):
        simulation.step()
    with pytest.raises(SimulationError, match="is gone"):
        simulation.step()
    simulation.close()


def test_few_robots_stay_in_one_process() -> None:
    assert processes_for(0) == 1
    assert processes_for(ROBOTS_A_PROCESS) == 1
    assert 1 <= processes_for(ROBOTS_A_PROCESS + 1) <= 2


def test_agents_in_other_processes_are_compiled_when_their_world_is() -> None:
    """They begin as Python, as the world does while its functions are compiled in the background."""
    with uncompiled():
        later = busy(2)
        run_s(later, 1.0)
    at_once = busy(2)
    run_s(at_once, 1.0)
    assert outcome(later, 1.0) == outcome(at_once, 1.0)
    later.close()
    at_once.close()


def test_an_image_reaches_an_agent_in_another_process_as_it_was_taken() -> None:
    image = Image(media_type="image/png", data=b"taken")
    readings = Readings(
        time_s=1.0, ranges_m=None, bumper=None, sightings=None, gripper=None, images={"camera": image}
    )
    robot = RemoteRobot()
    row = ReadingsSender().packed(Pose(x_m=0, y_m=0, heading_rad=0), readings, ())
    robot.feel(pickle.loads(pickle.dumps(row)), NOTHING)
    assert robot.sense().images == {"camera": image}


def test_breakpoints_hold_in_every_process_and_in_a_changed_world() -> None:
    document = WORLD.model_dump(mode="json")
    for robot in document["robots"]:
        rules = "AGENT guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));\n"
        rules += "BELIEF(on_duty) => COMMIT(adoptBelief(awake));\n"
        robot["rules"] = {"guard": rules}
    world = WorldFile.model_validate(document)
    simulation = Simulation(world, make_agent=behavioural_agent, seed=2, processes=2)
    names = [spec.name for spec in world.robots]
    both = frozenset({"guard:2", "guard:3"})
    simulation.break_at({names[0]: both, names[-1]: both})
    for rule in ("guard:2", "guard:3"):
        simulation.step_control_cycle()
        held = simulation.halts()
        assert [(one.robot, [firing.rule for firing in one.firings]) for one in held] == [
            (names[0], [rule]),
            (names[-1], [rule]),
        ]
        slower = [{**one, "speed_m_s": 0.3} for one in document["robots"]]
        anew = WorldFile.model_validate({**document, "robots": slower})  # their software is made anew
        simulation.take_up(Edition(simulation.edition + 1, anew))
    simulation.close()
