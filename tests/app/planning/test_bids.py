"""A proposed plan is put to simulated robots: each bids for each part, or says why not; the plan keeps its robots."""

from collections.abc import Iterator

import pytest

from app.agents.speech import Speech, SpeechService
from app.domain.errors import Conflict
from app.domain.mission_organiser import load_library
from app.planning.bids import NO_SPEECH, PlanBids
from app.planning.leg_calls import LegCalls
from app.store import EventRow, PlanRow
from robots.clock import ManualClock
from robots.wire import Message, SpeechAct
from robots.world import WorldFile
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation
from tests.app.missions.mission_services import WORLD, MissionServices
from tests.app.sample_store import Store
from tests.app.stepped_clock import SteppedClock


class Auction:
    """The sample store's robots in simulation, and a service that speaks with them in stepped time."""

    def __init__(self, database_url: str, world: WorldFile) -> None:
        store = Store(world)
        self.simulation = Simulation(world, make_agent=behavioural_agent, seed=0, jitter_m=0.0)
        self.services = MissionServices(
            database_url,
            store=store,
            plan_net=store.store_sample_1(),
            library=load_library(store.base),
            clock=ManualClock(),
            wall_clock=SteppedClock(),
            silent={},
        )
        self.services.start_world()
        self.speech = SpeechService(
            self.services.core, worlds={WORLD: world}, clocks={WORLD: self.simulation.clock}
        )
        self.bids = PlanBids(
            self.services.core,
            speech=self.speech,
            worlds={WORLD: world},
            calls=LegCalls(self.services.core, speech=self.speech, library=load_library(store.base)),
        )
        self.plan = self.services.plan()

    def run(self, seconds: float) -> None:
        for _ in range(round(20 * seconds)):
            for one in self.speech.due(WORLD):
                self._send(one)
                if one.ends:
                    self.speech.was_said(one)
            self.simulation.step_control_cycle()
            for message in self.simulation.link.receive():
                if isinstance(message.body, SpeechAct):
                    for answer in self.speech.hear(WORLD, message, message.body):
                        self._send(answer)

    def _send(self, one: Speech) -> None:
        self.simulation.link.send(
            Message(
                id=one.message_id,
                performative=one.performative,
                sender="service",
                receiver=one.robot,
                sent_at_s=self.simulation.clock.now_s(),
                in_reply_to=one.in_reply_to,
                body=one.act,
            )
        )

    def close(self) -> None:
        self.simulation.close()
        self.services.database.close()


@pytest.fixture
def auction(database_url: str, world_file: WorldFile) -> Iterator[Auction]:
    robots = [
        one.model_copy(update={"speaks": ("clearance",)}) if one.name == "store_1" else one
        for one in world_file.robots
    ]
    auction = Auction(database_url, world_file.model_copy(update={"robots": tuple(robots)}))
    yield auction
    auction.close()


def test_robots_bid_for_the_parts_that_they_can_do_and_decline_the_others(auction: Auction) -> None:
    auction.run(1.0)
    called = auction.bids.call(auction.plan, actor="ada")
    assert [part.robot for part in called] == ["store_2", "yard_1"]
    assert {bid.state for part in called for bid in part.bids} == {"called", NO_SPEECH}
    auction.run(1.0)
    store, yard = auction.bids.of(auction.plan)
    assert yard.packets[-1] == "RELEASE2"
    states = {bid.robot: bid.state for bid in yard.bids}
    assert states == {
        "yard_1": "rejected",
        "yard_2": "rejected",
        "store_1": NO_SPEECH,
        "store_2": "refused",
    }
    offers = {bid.robot: bid.offer.cost_s for bid in yard.bids if bid.offer is not None}
    assert offers.keys() == {"yard_1", "yard_2"}
    assert yard.cheapest == min(offers, key=lambda robot: offers[robot])
    assert store.cheapest == "store_2"
    reasons = {bid.robot: bid.reason for bid in yard.bids}
    assert reasons["store_1"] == "store_1 does not speak bids; it speaks clearance"
    assert reasons["store_2"]


def test_a_call_that_no_robot_hears_times_out(auction: Auction) -> None:
    auction.bids.call(auction.plan, actor="ada")
    for _ in range(20 * 20):
        auction.simulation.step_control_cycle()
    assert auction.speech.due(WORLD) == []
    store, _ = auction.bids.of(auction.plan)
    assert {bid.state for bid in store.bids} == {"timed_out", NO_SPEECH}
    assert store.cheapest is None


def test_a_second_call_replaces_the_first(auction: Auction) -> None:
    auction.bids.call(auction.plan, actor="ada")
    auction.run(2.0)
    again = auction.bids.call(auction.plan, actor="ada")
    assert {bid.state for part in again for bid in part.bids} == {"called", NO_SPEECH}
    auction.run(2.0)
    assert [part.cheapest is not None for part in auction.bids.of(auction.plan)] == [True, True]


def test_a_call_is_refused_until_all_have_answered_the_last_one(auction: Auction) -> None:
    auction.bids.call(auction.plan, actor="ada")
    with pytest.raises(Conflict, match="store_2, yard_1 and yard_2 have not answered the last call"):
        auction.bids.call(auction.plan, actor="bob")
    auction.run(1.0)
    auction.bids.call(auction.plan, actor="bob")
    with auction.services.database.read() as session:
        rows = session.query(EventRow).where(EventRow.type == "plan.bids_called").all()
    assert [(row.subject, row.data["actor"]) for row in rows] == [
        (auction.plan, "ada"),
        (auction.plan, "bob"),
    ]
    assert rows[0].data["robots"] == ["yard_1", "yard_2", "store_2"]


def test_robots_bid_for_proposed_plans_only(auction: Auction) -> None:
    with auction.services.database.write() as session:
        session.get_one(PlanRow, auction.plan).state = "rejected"
    with pytest.raises(Conflict, match="is rejected: robots bid for proposed plans only"):
        auction.bids.call(auction.plan, actor="ada")
    assert auction.bids.of(auction.plan) == []


def test_what_is_said_about_a_plan_is_in_the_event_log(auction: Auction) -> None:
    auction.run(1.0)
    auction.bids.call(auction.plan, actor="ada")
    auction.run(1.0)
    with auction.services.database.read() as session:
        rows = session.query(EventRow).where(EventRow.subject == auction.plan, EventRow.type == "speech.said")
        said = [row.data["performative"] for row in rows]
    assert {one: said.count(one) for one in said} == {
        "cfp": 6,
        "propose": 3,
        "refuse": 3,
        "reject-proposal": 3,
    }
