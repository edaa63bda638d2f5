"""The simulation's compiled functions: a short run of a world, in which each of them is called."""

from robots.compilation import Group
from robots.wire import BehaviourPacket, BehaviourScript, Message, Performative, ScriptRequest
from robots.world import WorldFile, load_world

RUN_S = 1.0
"""World seconds; robots that drive call every function within the first ten ticks."""


def compile_simulation() -> None:
    """Run the sample store with all of its robots driving."""
    # NOTE: imported here: processes that only name the group must not load the physics.
    from sim.world.agents import behavioural_agent
    from sim.world.simulation import Simulation

    world = load_world("sample_store")
    simulation = Simulation(world, make_agent=behavioural_agent, seed=0)
    try:
        for robot in world.robots:
            request = ScriptRequest(script=_drive(world, robot.name))
            simulation.link.send(
                Message(
                    performative=Performative.REQUEST,
                    sender="service",
                    receiver=robot.name,
                    sent_at_s=0.0,
                    body=request,
                )
            )
        simulation.run_until(lambda: False, timeout_s=RUN_S)
    finally:
        simulation.close()


SIMULATION = Group(name="simulation", compile=compile_simulation)


def _drive(world: WorldFile, robot: str) -> BehaviourScript:
    """A script from the robot's home to the first place that it reaches."""
    reach = world.reach_of(next(spec for spec in world.robots if spec.name == robot))
    place = next(place.name for place in reach if place.kind != "home")
    arguments = {"robot": robot, "rel1": "near", "ref1": f"home_{robot}", "rel2": "near", "ref2": place}
    packet = BehaviourPacket(
        id="drive",
        tag="NAVIGATE",
        arguments=arguments,
        expected_start_s=0.0,
        expected_duration_s=10.0,
        timeout_s=60.0,
        wait_timeout_s=60.0,
    )
    return BehaviourScript(id=f"drive_{robot}", mission_id="first_calls", robot=robot, packets=(packet,))
