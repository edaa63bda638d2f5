"""A robot bids for what it can do, at the cost of its own state, and says how it ended what it was awarded."""

from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.executive.delegation import AWARDED
from robots.executive.offer import DEFECT_S, Declining, Offer
from robots.executive.upkeep import recharge
from robots.perception.health import Defect
from robots.physical.body import Pose
from robots.social import Heard, Term
from robots.social.bidding import MAX_BIDS, WITHDRAWN
from robots.social.legs import bid_of, call_of, leg_of, offer_of
from robots.social.protocols import CONTRACT_NET, INFORM, NOT_UNDERSTOOD, TIMED_OUT, ContractNetState
from robots.social.terms import ContentError, parse_term
from robots.wire import OWN, BehaviourPacket, ControlVerb, Message, Performative, SpeechAct
from tests.robots.social.talkers import Air, Talker
from tests.robots.stories import packet, script

BAY_FROM_ORIGIN_S = abs(4.7 + 4.6j) / 0.5
"""To 0.8 m before the bay, which opens to the west, at 0.5 m/s."""
CARRY = (
    packet("DOCK", object="sample", ref1="bay"),
    packet("TRANSPORT", object="sample", ref1="bay", ref2="hatch"),
)


@dataclass
class Auction:
    """Ginger calls for proposals, as her rules would."""

    air: Air = field(default_factory=Air)
    heard: list[Heard] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.fred = self.air.add("fred")
        self.ginger = self.air.add("ginger")
        self.ginger.social.listen(self._listen)

    def _listen(self, heard: Heard) -> bool:
        self.heard.append(heard)
        return True

    def call(self, *packets: BehaviourPacket, leg: str = "leg_1", to: str = "fred") -> Heard:
        return self.call_with(call_of(leg, packets), to=to)

    def call_with(self, content: Term, to: str = "fred") -> Heard:
        self.ginger.social.say(
            Performative.CFP, to, content, protocol=CONTRACT_NET, within_s=60.0, is_of_rules=True
        )
        before = len(self.heard)
        self.air.run_for(40.0)
        assert len(self.heard) == before + 1
        return self.heard[-1]

    def bid(self, *packets: BehaviourPacket, leg: str = "leg_1", to: str = "fred") -> Offer:
        answer = self.call(*packets, leg=leg, to=to)
        assert answer.performative is Performative.PROPOSE, str(answer.content)
        return offer_of(answer.content)

    def award(self, content: str, *, within_s: float = 600.0) -> None:
        assert self.ginger.social.go_on(
            Performative.ACCEPT_PROPOSAL, "fred", parse_term(content), within_s=within_s
        )
        self.air.run_for(5.0)

    @property
    def last(self) -> str:
        return f"{self.heard[-1].performative.value} {self.heard[-1].content}"


def reason(answer: Heard) -> str:
    assert answer.performative is Performative.REFUSE, str(answer.content)
    return answer.content.words[1]


def test_an_idle_robot_bids_its_way_and_the_work() -> None:
    bid = Auction().bid(*CARRY)
    assert bid.release_s == 0.0
    assert bid.work_s == 20.0
    assert bid.way_s == pytest.approx(BAY_FROM_ORIGIN_S, abs=0.01)
    assert bid.cost_s == pytest.approx(20 + BAY_FROM_ORIGIN_S, abs=0.01)
    assert 0.99 < bid.battery < 1.0


def test_the_robot_that_stands_nearer_bids_less() -> None:
    auction = Auction()
    auction.air.add("basil").pose = Pose(x_m=4.7, y_m=4.6, heading_rad=0)
    assert auction.bid(*CARRY, to="basil").way_s == pytest.approx(0.0, abs=0.01)
    assert auction.bid(*CARRY).cost_s > auction.bid(*CARRY, leg="leg_2", to="basil").cost_s


def test_a_busy_robot_bids_from_where_and_when_its_script_ends() -> None:
    auction = Auction()
    first = packet("NAVIGATE", ref1="door", ref2="yard")
    second = packet("NAVIGATE", ref1="yard", ref2="bay").model_copy(update={"expected_start_s": 35.0})
    auction.fred.accept(script("fred", first, second))
    bid = auction.bid(*CARRY)
    assert bid.release_s == 45.0
    assert bid.way_s == pytest.approx(0.0, abs=0.01)


def test_a_script_of_the_robots_own_gives_way_and_does_not_count() -> None:
    auction = Auction()
    auction.fred.accept(recharge("fred", "yard", 1))
    bid = auction.bid(*CARRY)
    assert bid.release_s == 0.0
    assert bid.way_s == pytest.approx(BAY_FROM_ORIGIN_S, abs=0.01)


def test_a_leg_of_another_robot_counts_until_its_end() -> None:
    auction = Auction()
    drive = packet("NAVIGATE", ref1="door", ref2="bay")
    auction.fred.accept(
        script("fred", drive, name=f"{AWARDED}basil:s1:leg_1:0").model_copy(update={"mission_id": OWN})
    )
    bid = auction.bid(*CARRY)
    assert bid.release_s == 10.0
    assert bid.way_s == pytest.approx(0.0, abs=0.01)


def test_each_reading_that_is_left_out_costs_and_is_named() -> None:
    auction = Auction()
    sound = auction.bid(*CARRY)
    auction.fred.degraded = (Defect("whisker 3", "whisker 3 reads 0.2 wherever it looks"),)
    degraded = auction.bid(*CARRY, leg="leg_2")
    assert degraded.degraded == ("whisker 3",)
    assert degraded.cost_s - sound.cost_s == pytest.approx(DEFECT_S, abs=0.01)


def test_a_leg_that_brings_the_battery_below_its_level_costs_the_time_to_charge() -> None:
    auction = Auction()
    auction.fred.battery = 0.25
    bid = auction.bid(*CARRY)
    charging_s = (0.25 - bid.battery) * 120 * 3600 / 60
    assert charging_s > 5
    assert bid.cost_s == pytest.approx(bid.way_s + bid.work_s + charging_s, abs=4)


def declines(auction: Auction, why: Declining) -> None:
    assert reason(auction.call(*CARRY)) == why


def test_a_robot_declines_what_its_battery_does_not_last_for() -> None:
    auction = Auction()
    auction.fred.battery = 0.19
    declines(auction, Declining.BATTERY)


def test_a_robot_declines_a_leg_so_long_that_it_would_break_off() -> None:
    auction = Auction()
    auction.fred.battery = 0.21
    long = CARRY[0].model_copy(update={"expected_duration_s": 3600.0})
    assert reason(auction.call(long)) == Declining.BATTERY


def test_a_robot_declines_what_is_not_in_its_repertoire_or_on_its_map() -> None:
    auction = Auction()
    assert reason(auction.call(packet("FLY", ref2="bay"))) == Declining.CANNOT
    assert reason(auction.call(packet("NAVIGATE", ref1="door", ref2="attic"), leg="l2")) == Declining.CANNOT


def test_a_robot_that_senses_nothing_or_is_driven_or_holds_something_else_declines() -> None:
    auction = Auction()
    auction.fred.fault = "odometry reads nan"
    declines(auction, Declining.FAULT)
    auction.fred.fault = ""
    auction.fred.driver = "ada"
    declines(auction, Declining.DRIVEN)
    auction.fred.driver = None
    auction.fred.holding = "pebble"
    declines(auction, Declining.HOLDS)
    auction.fred.holding = "sample"
    assert auction.bid(*CARRY).work_s == 20.0


@pytest.mark.parametrize("sensor", ["bay", "battery"])
def test_a_robot_declines_if_it_cannot_trust_its_reading_of_a_place_or_its_battery(sensor: str) -> None:
    auction = Auction()
    auction.fred.degraded = (Defect(sensor, "reads nonsense"),)
    declines(auction, Declining.DEFECT)


def test_a_paused_robot_declines() -> None:
    auction = Auction()
    auction.fred.accept(script("fred", packet("NAVIGATE", ref1="door", ref2="yard")))
    assert auction.fred.executive.control("script-fred", ControlVerb.PAUSE, None, 0.0) is None
    declines(auction, Declining.PAUSED)


@pytest.mark.parametrize(
    "call",
    [
        "leg(a)",
        "leg(a, b)",
        "leg(a, packet(DOCK))",
        "leg(a, packet(DOCK, -1))",
        "leg(a, packet(DOCK, 9, bay))",
    ],
)
def test_a_call_that_names_no_leg_is_not_understood(call: str) -> None:
    auction = Auction()
    assert auction.call_with(parse_term(call)).performative is Performative.NOT_UNDERSTOOD


def begin(fred: Talker, name: str) -> None:
    fred.accept(script("fred", packet("NAVIGATE", ref1="door", ref2="yard"), name=name))


def test_an_award_counts_in_later_bids_until_its_script_has_come() -> None:
    auction = Auction()
    first = auction.bid(*CARRY)
    auction.award("award(leg_1, s1)")
    assert auction.bid(*CARRY, leg="leg_2").release_s == pytest.approx(first.way_s + first.work_s, abs=0.01)
    begin(auction.fred, "s1")
    assert auction.bid(*CARRY, leg="leg_3").release_s == 10.0


def test_a_bid_that_was_rejected_does_not_count() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    reject = parse_term("reject(leg_1)")
    assert auction.ginger.social.go_on(Performative.REJECT_PROPOSAL, "fred", reject, within_s=60)
    auction.air.run_for(2.0)
    assert auction.bid(*CARRY, leg="leg_2").release_s == 0.0


def test_a_robot_says_when_an_awarded_leg_has_failed() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    auction.award("award(leg_1, s1)")
    begin(auction.fred, "s1")
    auction.air.run_for(20.0)
    assert auction.last.startswith("propose")
    auction.fred.executive.control("s1", ControlVerb.CANCEL, None, auction.air.clock.now_s())
    auction.air.run_for(3.0)
    assert auction.last == 'failure failed(leg_1, "its script has cancelled")'


def test_a_robot_whose_mind_goes_on_in_another_program_keeps_its_bid_and_its_award() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    auction.fred.hand_over()
    auction.award("award(leg_1, s1)")
    begin(auction.fred, "s1")
    auction.air.run_for(5.0)
    auction.fred.hand_over()
    auction.fred.executive.control("s1", ControlVerb.CANCEL, None, auction.air.clock.now_s())
    auction.air.run_for(3.0)
    assert auction.last == 'failure failed(leg_1, "its script has cancelled")'


def test_an_award_whose_script_never_comes_has_failed() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    auction.award("award(leg_1, s1)", within_s=30.0)
    assert auction.last.startswith("propose")
    auction.air.run_for(28.0)
    assert auction.bid(*CARRY, leg="leg_2").release_s == 0.0


def test_an_award_that_was_cancelled_does_not_count() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    auction.award("award(leg_1, s1)")
    assert auction.ginger.social.go_on(Performative.CANCEL, "fred", parse_term("leg(leg_1)"), within_s=60)
    auction.air.run_for(2.0)
    assert auction.bid(*CARRY, leg="leg_2").release_s == 0.0


def test_an_award_of_another_leg_is_not_understood() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    auction.award("award(leg_9, s1)")
    assert auction.heard[-1].performative is Performative.NOT_UNDERSTOOD


def test_a_withdrawn_leg_is_not_begun_in_another_program_either() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    one = script("fred", *CARRY, name=f"{AWARDED}ginger:s1:leg_1:0")
    withdrawn = Term(WITHDRAWN, (one.id,))
    auction.ginger.social.say(Performative.INFORM, "fred", withdrawn, protocol=INFORM, within_s=60.0)
    auction.air.run_for(2.0)
    auction.fred.hand_over()
    (call,) = [each for each in auction.ginger.social.conversations if each.protocol is CONTRACT_NET]
    award = Term("award", ("leg_1", one.id))
    auction.ginger.social.say_in(call, Performative.ACCEPT_PROPOSAL, award, within_s=60.0, script=one)
    auction.air.run_for(2.0)
    assert "was withdrawn before it arrived" in auction.last


def test_an_award_that_nobody_knows_is_not_understood() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    auction.award("awarded(leg_1, s1)")
    assert "does not take accept-proposal of 'awarded'; it takes award" in auction.last
    assert [one.state for one in auction.fred.social.conversations] == [NOT_UNDERSTOOD]


def said_to_fred(auction: Auction, sender: str, performative: Performative, content: str, about: str) -> None:
    """Speak to fred past the sender's own conversations; an answer is awaited for 20 s."""
    now_s = auction.air.clock.now_s()
    act = SpeechAct(
        content=content, protocol=CONTRACT_NET.name, conversation_id=about, reply_by_s=now_s + 20.0
    )
    auction.air.send(
        Message(performative=performative, sender=sender, receiver="fred", sent_at_s=now_s, body=act)
    )


@pytest.mark.parametrize(
    ("caller", "after_s", "state"),
    [
        ("service", 3600.0, ContractNetState.AWARDED),
        ("ginger", 60.0, ContractNetState.AWARDED),
        ("ginger", 90.0, TIMED_OUT),
    ],
)
def test_a_bid_stands_until_its_award_can_come_no_more(caller: str, after_s: float, state: str) -> None:
    auction = Auction()
    said_to_fred(auction, caller, Performative.CFP, str(call_of("leg_1", CARRY)), "c-1")
    auction.air.run_for(after_s)
    said_to_fred(auction, caller, Performative.ACCEPT_PROPOSAL, "award(leg_1, s1)", "c-1")
    auction.air.run_for(1.0)
    conversation = auction.fred.social.conversations.of("c-1", caller)
    assert conversation is not None
    assert conversation.state == state


def test_an_award_by_the_service_lasts_until_its_script_has_ended() -> None:
    auction = Auction()
    said_to_fred(auction, "service", Performative.CFP, str(call_of("leg_1", CARRY)), "c-1")
    auction.air.run_for(1.0)
    said_to_fred(auction, "service", Performative.ACCEPT_PROPOSAL, "award(leg_1, s1)", "c-1")
    auction.air.run_for(1.0)
    begin(auction.fred, "s1")
    auction.air.run_for(600.0)
    auction.fred.executive.control("s1", ControlVerb.CANCEL, None, auction.air.clock.now_s())
    auction.air.run_for(1.0)
    last = auction.air.sent[-1].body
    assert isinstance(last, SpeechAct)
    assert last.content == 'failed(leg_1, "its script has cancelled")'


def test_many_bids_that_nobody_answers_do_not_displace_an_award() -> None:
    auction = Auction()
    auction.bid(*CARRY)
    auction.award("award(leg_1, s1)")
    begin(auction.fred, "s1")
    for number in range(MAX_BIDS + 1):
        said_to_fred(auction, "basil", Performative.CFP, str(call_of("leg_2", CARRY)), f"c-{number}")
    auction.air.run_for(1.0)
    open_ones = [one for one in auction.fred.social.conversations if not one.has_ended]
    assert len(open_ones) == MAX_BIDS + 1, "the oldest bid is forgotten"
    auction.fred.executive.control("s1", ControlVerb.CANCEL, None, auction.air.clock.now_s())
    auction.air.run_for(3.0)
    assert auction.last == 'failure failed(leg_1, "its script has cancelled")'
    auction.air.run_for(120.0)
    assert all(one.has_ended for one in auction.fred.social.conversations)


@pytest.mark.parametrize("seed", range(8))
def test_a_call_over_a_poor_radio_gets_one_bid(seed: int) -> None:
    auction = Auction(Air(seed=seed, loss=0.3, repeats=0.3, longest_s=2.0))
    assert auction.bid(*CARRY).work_s == 20.0


NAMES = st.text(st.characters(codec="ascii", categories=("L", "N", "P", "Zs")), min_size=1, max_size=12)
PACKETS = st.builds(
    lambda tag, work_s, arguments: packet(tag, **arguments).model_copy(
        update={"expected_duration_s": work_s}
    ),
    NAMES,
    st.floats(0.1, 3600.0),
    st.dictionaries(NAMES.filter(lambda name: name not in PACKET_OPTIONS), NAMES, max_size=4),
)
PACKET_OPTIONS = {"tag", "awaits", "after", "timeout_s", "wait_timeout_s"}


@given(NAMES, st.lists(PACKETS, min_size=1, max_size=4))
def test_a_leg_is_read_as_it_was_said(leg: str, packets: list[BehaviourPacket]) -> None:
    read = leg_of(parse_term(str(call_of(leg, packets))), "fred")
    assert read.id == leg
    assert [(one.tag, one.arguments, one.expected_duration_s) for one in read.packets] == [
        (one.tag, one.arguments, one.expected_duration_s) for one in packets
    ]


def test_a_bid_without_a_cost_is_none() -> None:
    bid = Offer(cost_s=1.0, release_s=0.0, way_s=0.0, work_s=1.0, battery=0.5, degraded=("whisker 3",))
    assert offer_of(parse_term(str(bid_of("leg_1", bid)))) == bid
    with pytest.raises(ContentError, match="cost"):
        offer_of(parse_term("bid(leg_1, release(0))"))
