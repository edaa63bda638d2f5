"""Simulated robots bid: those that can do a leg at their own cost, the others decline."""

from collections.abc import Iterator

import pytest

from robots.social import Term, parse_term
from robots.social.legs import call_of, offer_of
from robots.social.protocols import CONTRACT_NET
from robots.wire import BehaviourPacket, Message, Performative, RuleSet, SpeechAct, Telemetry
from robots.world import LinkSpec, load_world
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

FETCH = BehaviourPacket(
    id="fetch",
    tag="DOCK",
    arguments={"object": "sample_1", "ref1": "door_1"},
    expected_start_s=0,
    expected_duration_s=20,
    timeout_s=60,
    wait_timeout_s=60,
)
AUCTION = """AGENT auctioneer;
ACTUATOR say;
ACTUATOR activate;
BELIEF(startup) => COMMIT(say(cfp, yard_2, leg(leg_1, packet("DOCK", 20, object(sample_1), ref1(door_1)))));
BELIEF(message(propose, yard_2, ?bid)) => COMMIT(activate(WANDER()));
"""


@pytest.fixture
def simulation() -> Iterator[Simulation]:
    world = load_world("sample_store").model_copy(update={"peer_link": LinkSpec()})
    simulation = Simulation(world, make_agent=behavioural_agent, seed=0, jitter_m=0.0)
    yield simulation
    simulation.close()


def heard(simulation: Simulation, seconds: int) -> list[Message]:
    for _ in range(20 * seconds):
        simulation.step_control_cycle()
    return list(simulation.link.receive())


def test_the_robots_that_know_the_leg_bid_for_it_and_the_others_decline(simulation: Simulation) -> None:
    heard(simulation, 1)
    robots = ("yard_1", "yard_2", "store_1", "store_2")
    for robot in robots:
        act = SpeechAct(
            content=str(call_of("leg_1", [FETCH])), protocol=CONTRACT_NET.name, conversation_id="call-1"
        )
        simulation.link.send(
            Message(performative=Performative.CFP, sender="service", receiver=robot, sent_at_s=1.0, body=act)
        )
    answers: dict[str, tuple[Performative, Term]] = {
        one.sender: (one.performative, parse_term(one.body.content))
        for one in heard(simulation, 1)
        if isinstance(one.body, SpeechAct)
    }
    assert set(answers) == set(robots)
    offers = {
        robot: offer_of(content)
        for robot, (performative, content) in answers.items()
        if performative is Performative.PROPOSE
    }
    declined = {robot: content.words[1] for robot, (_, content) in answers.items() if robot not in offers}
    assert set(offers) == {"yard_1", "yard_2"}
    assert declined == {"store_1": "cannot", "store_2": "cannot"}
    assert offers["yard_1"].cost_s != offers["yard_2"].cost_s


def test_a_robots_rules_call_for_proposals_and_hear_the_bid(simulation: Simulation) -> None:
    body = RuleSet(version=1, files={"auctioneer": AUCTION})
    simulation.link.send(
        Message(
            performative=Performative.REQUEST, sender="service", receiver="yard_1", sent_at_s=0.0, body=body
        )
    )
    told = [one.body for one in heard(simulation, 4) if one.sender == "yard_1"]
    assert "WANDER" in {one.packet_tag for one in told if isinstance(one, Telemetry)}
