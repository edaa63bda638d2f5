"""Rules of simulated robots speak over the world's radio between robots."""

from robots.wire import Message, Performative, RuleSet, Telemetry
from robots.world import LinkSpec, load_world
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

ASKS = "AGENT asker;\nACTUATOR say;\nBELIEF(startup) => COMMIT(say(request, yard_2, look));\n"
DOES = (
    "AGENT doer;\nACTUATOR activate;\nBELIEF(message(request, ?who, look)) => COMMIT(activate(WANDER()));\n"
)


def test_a_robot_does_what_anothers_rule_asks_of_it() -> None:
    world = load_world("sample_store").model_copy(update={"peer_link": LinkSpec()})
    simulation = Simulation(world, make_agent=behavioural_agent, seed=0, jitter_m=0.0)

    def follow(robot: str, text: str) -> None:
        name = text.partition(";")[0].removeprefix("AGENT ")
        body = RuleSet(version=1, files={name: text})
        simulation.link.send(
            Message(
                performative=Performative.REQUEST, sender="service", receiver=robot, sent_at_s=0.0, body=body
            )
        )

    def packets() -> set[str]:
        """What yard_2 does in the next second."""
        for _ in range(20):
            simulation.step_control_cycle()
        told = [one.body for one in simulation.link.receive() if one.sender == "yard_2"]
        return {one.packet_tag for one in told if isinstance(one, Telemetry) and one.packet_tag}

    try:
        follow("yard_2", DOES)
        assert packets() == set()
        follow("yard_1", ASKS)
        assert set().union(*(packets() for _ in range(3))) == {"WANDER"}
    finally:
        simulation.close()


def test_robots_start_with_the_rules_of_the_world_file() -> None:
    world = load_world("sample_store").model_copy(update={"peer_link": LinkSpec()})
    rules = {"yard_1": {"asker": ASKS}, "yard_2": {"doer": DOES}}
    robots = tuple(robot.model_copy(update={"rules": rules.get(robot.name, {})}) for robot in world.robots)
    world = world.model_copy(update={"robots": robots})
    simulation = Simulation(world, make_agent=behavioural_agent, seed=0, jitter_m=0.0)
    try:
        for _ in range(40):
            simulation.step_control_cycle()
        bodies = (one.body for one in simulation.link.receive() if one.sender == "yard_2")
        assert "WANDER" in {one.packet_tag for one in bodies if isinstance(one, Telemetry)}
    finally:
        simulation.close()
