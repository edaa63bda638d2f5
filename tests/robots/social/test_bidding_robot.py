"""A whole robot answers a call over its link, does the awarded leg by its script, and says so."""

from robots.executive.offer import Offer
from robots.physical.body import Pose
from robots.social import SocialLevel, Term, parse_term
from robots.social.legs import call_of, offer_of
from robots.social.protocols import CONTRACT_NET
from robots.wire import BehaviourPacket, BehaviourScript, Message, Performative, SpeechAct
from tests.robots.fake_world import FakeWorld
from tests.robots.stories import NORTH, Service, packet, room, run, script

START = Pose(x_m=1.0, y_m=1.5, heading_rad=NORTH)
DRIVE = packet("NAVIGATE", ref1="door", ref2="yard")


def fred_of(world: FakeWorld) -> Service:
    society = SocialLevel("fred", world.clock)
    return Service(world, world.add("fred", START, ["ginger"], society=society), "fred")


def say(service: Service, performative: Performative, content: Term, **slots: str) -> Message:
    act = SpeechAct(
        content=str(content),
        protocol=CONTRACT_NET.name,
        conversation_id="call-1",
        reply_by_s=service.world.clock.now_s() + 120.0,
    )
    return service.send(act, performative, **slots)


def said(service: Service) -> list[tuple[Message, Term]]:
    return [(one, parse_term(one.body.content)) for one in service.heard if isinstance(one.body, SpeechAct)]


def answer(service: Service, number: int, *, limit_s: float = 5.0) -> tuple[Message, Term]:
    """What the robot has said as its answer of this number."""
    assert run(service.world, [service], lambda: len(said(service)) > number, limit_s=limit_s)
    return said(service)[number]


def bid(service: Service, *packets: BehaviourPacket) -> tuple[Message, Offer]:
    run(service.world, [service], lambda: False, limit_s=1.0)
    say(service, Performative.CFP, call_of("leg_1", packets))
    message, content = answer(service, 0)
    assert message.performative is Performative.PROPOSE, str(content)
    return message, offer_of(content)


def award(service: Service, proposal: Message, order: BehaviourScript) -> None:
    term = Term("award", ("leg_1", order.id))
    say(service, Performative.ACCEPT_PROPOSAL, term, in_reply_to=proposal.id)
    service.order(order)


def test_a_robot_bids_is_awarded_a_leg_and_says_that_it_is_done() -> None:
    service = fred_of(room())
    proposal, offer = bid(service, DRIVE)
    assert (proposal.receiver, offer.work_s, offer.release_s) == ("service", 10.0, 0.0)
    award(service, proposal, script("fred", DRIVE, name="s1"))
    message, content = answer(service, 1, limit_s=60.0)
    assert service.report is not None
    assert (message.performative, str(content)) == (Performative.INFORM, "done(leg_1)")


def test_a_robot_under_way_bids_what_is_left_of_its_script() -> None:
    service = fred_of(room())
    long = DRIVE.model_copy(update={"expected_duration_s": 50.0})
    service.order(script("fred", long, name="s1"))
    run(service.world, [service], lambda: False, limit_s=4.0)
    _, offer = bid(service, DRIVE)
    assert 40.0 < offer.release_s < 47.0
