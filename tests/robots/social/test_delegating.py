"""A robot that cannot do a leg puts it to others while the service is away, and goes on once it is done."""

import random
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from robots.contract.memory import DelegationPhase
from robots.executive.agent import BehaviouralAgent
from robots.executive.delegation import ASIDE, AWARDED
from robots.executive.memory import RobotMemory
from robots.link import InMemoryLink
from robots.physical.body import Pose
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.repertoire import Repertoire, read_repertoire, store_packets
from robots.social import SocialLevel
from robots.wire import (
    OWN,
    SAID,
    BehaviourScript,
    Control,
    ControlVerb,
    DelegableLeg,
    DelegationReport,
    DelegationState,
    Message,
    PacketReport,
    PacketState,
    Performative,
    Receipt,
    Recipient,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    SpeechAct,
    StatusQuery,
    StatusReport,
    UpkeepReport,
)
from robots.wire import Body as Content
from tests.robots.fake_world import FakeBody
from tests.robots.stories import NORTH, SOUTH, carry, fact, packet, room, script

HOMES = {"fred": 1.2, "ginger": 2.4, "basil": 3.6}
TAGS = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2")
DOOR = complex(1.0, 0.4)
REPORTS = (DelegationReport, PacketReport, ScriptReport, UpkeepReport)

LOOK = """
tag: LOOK
about: Looks at a place.
arguments: [ref]
places: [ref]
patterns:
  - name: rest
    dof: translate
    level: task
    stimulus: {sense: always}
    r: {form: constant, value: 0}
    u: {form: constant, value: 1}
after: [{sense: elapsed, s: 0.5}]
"""


class Field:
    """Robots in a room that hear each other, and a service that hears them only while it is in reach."""

    def __init__(
        self,
        *names: str,
        seed: int = 0,
        alone: Sequence[str] = (),
        packets: Repertoire | None = None,
        lost: Sequence[str] = (),
    ) -> None:
        """
        :param alone: robots that do no legs of others.
        :param lost: robots whose homes are not on their maps.
        """
        self.lost = frozenset(lost)
        self.packets = packets
        self.world = room({"sample_1": DOOR}, seed=seed)
        homes = {
            f"home_{name}": BeaconSpec(x_m=x_m, y_m=2.9, approach_rad=(SOUTH,)) for name, x_m in HOMES.items()
        }
        self.world.beacons = {**self.world.beacons, **homes}
        self.in_reach = False
        self.garble: Callable[[Message], Message] = lambda message: message
        """What becomes of a robot's message to another on its way."""
        self.mute: set[str] = set()
        self.award_delay_s = 0.0
        """How long awards are on their way."""
        self._under_way: list[tuple[float, Message]] = []
        self.alone = frozenset(alone)
        self.heard: dict[str, Message] = {}
        self.end: ScriptReport | None = None
        """How fred's script has ended."""
        self.said: list[Message] = []
        self.ends: dict[str, InMemoryLink] = {}
        self._links: dict[str, InMemoryLink] = {}
        for name in names:
            pose = Pose(x_m=HOMES[name], y_m=2.1, heading_rad=NORTH)
            self.world.bodies[name] = FakeBody(self.world, name, pose)
            self.ends[name], self._links[name] = InMemoryLink.pair()
            self._make(name, None)

    def _make(self, name: str, memory: RobotMemory | None) -> None:
        body = self.world.bodies[name]
        profile = RobotProfile(
            name=name,
            start=body.pose,
            beacons={
                place: spec
                for place, spec in self.world.beacons.items()
                if not place.startswith("home_") or (place == f"home_{name}" and name not in self.lost)
            },
            others=tuple(one for one in self.ends if one != name),
            home=f"home_{name}",
            repertoire=(*TAGS, *(() if self.packets is None else ("LOOK",))),
        )
        self.world.agents[name] = BehaviouralAgent(
            profile=profile,
            body=body,
            link=self._links[name],
            clock=self.world.clock,
            memory=memory,
            repertoire=self.packets,
            society=SocialLevel(name, self.world.clock, takes_legs=name not in self.alone),
        )

    def restart(self, name: str) -> None:
        """The power fails: what is in flash memory is all that is left."""
        saved = self.world.agents[name].memory().model_dump_json()
        self._make(name, RobotMemory.model_validate_json(saved))

    def send(self, name: str, body: Content, performative: Performative = Performative.REQUEST) -> None:
        self.ends[name].send(
            Message(
                performative=performative,
                sender="service",
                receiver=name,
                sent_at_s=self.world.clock.now_s(),
                body=body,
            )
        )

    def order(self, one: BehaviourScript) -> None:
        self.send(one.robot, ScriptRequest(script=one))
        self.go_on(0.2)

    def go_on(self, time_s: float) -> None:
        end_s = self.world.clock.now_s() + time_s
        while self.world.clock.now_s() < end_s:
            self.tick()

    def until(self, limit_s: float, state: DelegationState | None = None) -> bool:
        """Until fred's script has ended, or it reports such a state."""
        end_s = self.world.clock.now_s() + limit_s
        while self.world.clock.now_s() < end_s:
            self.tick()
            if self.end is not None or (state is not None and state in self.told):
                return True
        return False

    def tick(self) -> None:
        self.world.tick()
        now_s = self.world.clock.now_s()
        for _, message in [one for one in self._under_way if one[0] <= now_s]:
            self.ends[message.receiver].send(message)
        self._under_way = [one for one in self._under_way if one[0] > now_s]
        for name, end in self.ends.items():
            for message in end.receive():
                if message.receiver in self.ends:
                    message = self.garble(message)  # noqa: PLW2901
                    self.said.append(message)
                    is_award = message.performative is Performative.ACCEPT_PROPOSAL
                    if is_award and self.award_delay_s:
                        self._under_way.append((now_s + self.award_delay_s, message))
                    elif not {name, message.receiver} & self.mute:
                        self.ends[message.receiver].send(message)
                    continue
                self.heard[message.id] = message
                if self.end is None and message.sender == "fred" and isinstance(message.body, ScriptReport):
                    self.end = message.body
                if self.in_reach and isinstance(message.body, REPORTS):
                    receipt = Message(
                        performative=Performative.CONFIRM,
                        sender="service",
                        receiver=name,
                        sent_at_s=self.world.clock.now_s(),
                        in_reply_to=message.id,
                        body=Receipt(),
                    )
                    end.send(receipt)

    @property
    def delegations(self) -> list[DelegationReport]:
        return [one.body for one in self.heard.values() if isinstance(one.body, DelegationReport)]

    @property
    def told(self) -> list[DelegationState]:
        return [one.state for one in self.delegations]

    def performatives(self, sender: str) -> list[Performative]:
        acts = {one.id: one for one in self.said if one.sender == sender and isinstance(one.body, SpeechAct)}
        return [one.performative for one in acts.values()]

    def has_brought(self) -> bool:
        """The sample lies at the yard, and nobody has it."""
        yard = self.world.beacons["yard"].point
        held = [body.held for body in self.world.bodies.values() if body.held]
        return abs(self.world.samples["sample_1"] - yard) < 0.6 and not held


def mission(*robots: str, timeout_s: float = 20.0, more: bool = False) -> BehaviourScript:
    """fred is to bring the sample from the door to the yard; the others may do it in its stead."""
    made = carry("fred", "sample_1", "door", "yard")
    packets = tuple(
        one.model_copy(update={"timeout_s": timeout_s + 20 * at}) for at, one in enumerate(made.packets)
    )
    last = (packet("NAVIGATE", ref1="yard", ref2="hatch"),) if more else ()
    ids = tuple(one.id for one in packets)
    legs = (DelegableLeg(id="leg_1", packets=ids, robots=robots),) if robots else ()
    return made.model_copy(update={"packets": (*packets, *last), "delegable": legs})


def jammed(*names: str, seed: int = 0, stuck: Sequence[str] = ("fred",)) -> Field:
    field = Field(*names, seed=seed)
    for name in stuck:
        field.world.bodies[name].jammed = True
    return field


def test_an_idle_robot_does_the_leg_and_the_script_goes_on_after_it() -> None:
    field = jammed("fred", "ginger")
    field.order(mission("ginger", more=True))
    assert field.until(300.0)
    assert field.end is not None
    assert field.end.state is ScriptState.FINISHED, field.end.detail
    assert field.has_brought()
    assert field.told == [DelegationState.AWARDED, DelegationState.DONE]
    done = field.delegations[-1]
    assert (done.robot, done.stands, done.aside) == ("ginger", "home_ginger", "home_fred")
    assert sorted(field.end.done_by) == [
        "DOCK-sample_1-door",
        "RELEASE2-sample_1-door-yard",
        "TRANSPORT-sample_1-door-yard",
    ]
    states = [
        one.body.state
        for one in field.heard.values()
        if isinstance(one.body, PacketReport) and one.body.packet_id.startswith("DOCK")
    ]
    assert PacketState.RETRIABLE in states
    assert PacketState.FAILED not in states, "the service would have it that the script fails"
    assert field.performatives("ginger") == [Performative.PROPOSE, Performative.INFORM]


def test_where_the_other_stands_is_read_among_whatever_else_it_tells() -> None:
    field = jammed("fred", "ginger")
    field.garble = said_by(
        "ginger", Performative.INFORM, "done(leg_1, by(ginger), near(home_ginger), took(40))"
    )
    field.order(mission("ginger"))
    assert field.until(300.0)
    assert field.delegations[-1].stands == "home_ginger"


def test_a_script_whose_leg_another_robot_does_is_paused_and_resumed() -> None:
    field = jammed("fred", "ginger")
    field.order(mission("ginger"))
    assert field.until(300.0, DelegationState.AWARDED)
    states = [state_of(field)]
    for number, verb in enumerate((ControlVerb.PAUSE, ControlVerb.RESUME), start=1):
        field.send("fred", Control(script_id="script-fred", verb=verb, number=number))
        states.append(state_of(field))
    assert states == [PacketState.RETRIABLE, PacketState.PAUSED, PacketState.RETRIABLE]
    assert field.told == [DelegationState.AWARDED]


def state_of(field: Field) -> PacketState | None:
    """The state of fred's packet, as he answers when he is asked."""
    field.send("fred", StatusQuery(script_id="script-fred"), Performative.QUERY)
    field.go_on(0.2)
    *_, last = (one.body for one in field.heard.values() if isinstance(one.body, StatusReport))
    return last.packet_state


def test_while_the_service_answers_it_decides_and_the_script_fails_as_before() -> None:
    field = jammed("fred", "ginger")
    field.in_reach = True
    field.order(mission("ginger"))
    assert field.until(120.0)
    assert field.end is not None
    assert (field.end.state, field.said) == (ScriptState.FAILED, [])
    assert "the service is in reach" in field.end.detail


def reach(field: Field, phase: DelegationPhase) -> None:
    """Go on until fred's leg is in that phase."""
    for _ in range(20 * 200):
        field.tick()
        delegation = field.world.agents["fred"].memory().mind.social.delegation
        if delegation is not None and delegation.phase is phase:
            return
    raise AssertionError(f"{phase} was not reached")


def test_a_service_that_is_heard_while_the_robot_makes_way_decides() -> None:
    field = jammed("fred", "ginger")
    field.order(mission("ginger"))
    reach(field, DelegationPhase.MAKING_WAY)
    field.go_on(1.0)
    field.send("fred", StatusQuery(script_id="script-fred"), Performative.QUERY)
    assert field.until(2.0)
    assert field.end is not None
    assert (field.end.state, field.said) == (ScriptState.FAILED, [])
    assert "the service is in reach" in field.end.detail


def test_a_service_that_is_heard_while_bids_are_awaited_decides_and_the_bids_are_rejected() -> None:
    field = jammed("fred", "ginger", "basil")
    field.mute.add("ginger")
    field.order(mission("ginger", "basil"))
    reach(field, DelegationPhase.CALLING)
    field.go_on(3.0)
    assert field.performatives("basil") == [Performative.PROPOSE]
    field.send("fred", StatusQuery(script_id="script-fred"), Performative.QUERY)
    assert field.until(2.0)
    field.go_on(1.0)
    acts = [Performative.CFP, Performative.CFP, Performative.REJECT_PROPOSAL]
    assert field.performatives("fred") == acts
    field.go_on(60.0)
    assert field.performatives("fred") == acts
    assert field.told == []


def test_a_service_that_learns_of_the_award_decides_when_it_has_failed() -> None:
    field = jammed("fred", "ginger", "basil", stuck=("fred", "ginger"))
    field.order(mission("ginger", "basil"))
    assert field.until(200.0, DelegationState.AWARDED)
    field.in_reach = True
    assert field.until(300.0)
    assert field.end is not None
    assert field.end.state is ScriptState.FAILED
    assert "the service is in reach" in field.end.detail
    assert [(one.state, one.robot) for one in field.delegations] == [
        (DelegationState.AWARDED, "ginger"),
        (DelegationState.FAILED, "ginger"),
    ]


@pytest.mark.parametrize("robots", [(), ("ginger",)], ids=["not granted", "the robot moved it"])
def test_what_is_not_granted_or_begun_with_the_sample_in_its_jaws_is_not_put_to_others(
    robots: tuple[str, ...],
) -> None:
    field = jammed("fred", "ginger", stuck=() if robots else ("fred",))
    field.order(mission(*robots))
    if robots:
        while field.world.bodies["fred"].held is None:
            field.tick()
        field.world.bodies["fred"].stuck = True
    assert field.until(300.0)
    assert field.end is not None
    assert (field.end.state, field.said) == (ScriptState.FAILED, [])


@pytest.mark.parametrize("brings", ["results: [{reading: light_lx, unit: lx, of: $ref}]", "events"])
def test_a_leg_whose_packets_are_to_bring_something_is_not_put_to_others(tmp_path: Path, brings: str) -> None:
    look_file = tmp_path / "look.yaml"
    look_file.write_text(LOOK if brings == "events" else LOOK + brings)
    field = Field("fred", "ginger", packets=read_repertoire((*store_packets(), look_file)))
    field.world.bodies["fred"].jammed = True
    look = packet("LOOK", ref="yard")
    if brings == "events":
        look = look.model_copy(update={"events": {"seen": (fact("in(sample_1, yard)"),)}})
    one = mission("ginger")
    (leg,) = one.delegable
    legs = (leg.model_copy(update={"packets": (*leg.packets, look.id)}),)
    field.order(one.model_copy(update={"packets": (*one.packets, look), "delegable": legs}))
    assert field.until(300.0)
    assert field.end is not None
    assert (field.end.state, field.said) == (ScriptState.FAILED, [])


def test_a_robot_at_a_script_of_its_own_is_not_drawn_away() -> None:
    field = jammed("fred", "ginger")
    waits = packet("NAVIGATE", ref2="hatch", after=("a1",), wait_timeout_s=900.0)
    field.order(script("ginger", waits))
    field.order(mission("ginger"))
    assert field.until(200.0)
    assert field.told == [DelegationState.NOT_TAKEN]
    assert field.end is not None
    assert "ginger busy" in field.end.detail
    assert field.performatives("fred") == [Performative.CFP, Performative.REJECT_PROPOSAL]


def test_who_fails_with_empty_jaws_is_followed_by_the_next_best_bid() -> None:
    field = jammed("fred", "ginger", "basil", stuck=("fred", "ginger"))
    field.order(mission("ginger", "basil"))
    assert field.until(500.0)
    assert field.end is not None
    assert field.end.state is ScriptState.FINISHED, field.end.detail
    assert [(one.state, one.robot) for one in field.delegations] == [
        (DelegationState.AWARDED, "ginger"),
        (DelegationState.FAILED, "ginger"),
        (DelegationState.AWARDED, "basil"),
        (DelegationState.DONE, "basil"),
    ]
    assert field.has_brought()


def test_who_fails_with_the_sample_in_its_jaws_is_followed_by_nobody() -> None:
    field = jammed("fred", "ginger", "basil")
    field.order(mission("ginger", "basil"))
    assert field.until(200.0, DelegationState.AWARDED)
    while field.world.bodies["ginger"].held is None:
        field.tick()
    field.world.bodies["ginger"].stuck = True
    assert field.until(500.0)
    assert field.end is not None
    assert field.end.state is ScriptState.FAILED
    assert [(one.state, one.robot) for one in field.delegations] == [
        (DelegationState.AWARDED, "ginger"),
        (DelegationState.FAILED, "ginger"),
    ]
    (told,) = [one.body for one in field.heard.values() if isinstance(one.body, UpkeepReport)]
    assert "in(sample_1, ginger)" in map(str, told.perceived), "the service learns where the sample is"


def test_an_award_that_is_lost_times_out_is_told_and_given_to_nobody_else() -> None:
    field = jammed("fred", "ginger", "basil")
    field.order(mission("ginger", "basil"))
    assert field.until(200.0, DelegationState.AWARDED)
    field.mute.add("ginger")
    field.world.clock.advance(1500.0)
    assert field.until(5.0)
    assert field.told == [DelegationState.AWARDED, DelegationState.UNHEARD]
    assert field.end is not None
    assert field.end.state is ScriptState.FAILED
    assert "ginger, which was awarded it" in field.end.detail


def test_a_cancelled_script_stops_the_robot_that_does_its_leg() -> None:
    field = jammed("fred", "ginger")
    one = mission("ginger")
    field.order(one)
    assert field.until(200.0, DelegationState.AWARDED)
    field.go_on(3.0)
    field.send("fred", Control(script_id=one.id, verb=ControlVerb.CANCEL), Performative.CANCEL)
    field.go_on(5.0)
    states = field.world.agents["ginger"].memory().mind.executive.states
    assert [state for name, state in states.items() if name.startswith(AWARDED)] == [ScriptState.CANCELLED]
    assert not any(name.startswith(ASIDE) for name in states), "it stops where it is"
    assert field.world.bodies["ginger"].velocity == (0.0, 0.0)


def test_who_does_the_leg_is_told_to_stop_though_the_power_fails_in_between() -> None:
    field = jammed("fred", "ginger")
    one = mission("ginger")
    field.order(one)
    assert field.until(200.0, DelegationState.AWARDED)
    field.go_on(3.0)
    field.mute.add("ginger")
    field.send("fred", Control(script_id=one.id, verb=ControlVerb.CANCEL), Performative.CANCEL)
    field.go_on(1.0)
    field.restart("fred")
    field.mute.clear()
    field.go_on(5.0)
    states = field.world.agents["ginger"].memory().mind.executive.states
    assert [state for name, state in states.items() if name.startswith(AWARDED)] == [ScriptState.CANCELLED]
    assert not field.world.agents["fred"].memory().mind.social.withdrawals, "it has confirmed it"


def test_a_leg_that_is_withdrawn_before_its_award_arrives_is_not_begun() -> None:
    field = jammed("fred", "ginger")
    field.award_delay_s = 6.0
    one = mission("ginger")
    field.order(one)
    assert field.until(200.0, DelegationState.AWARDED)
    field.send("fred", Control(script_id=one.id, verb=ControlVerb.CANCEL), Performative.CANCEL)
    field.go_on(3.0)
    assert not field.world.agents["fred"].memory().mind.social.withdrawals, "it has confirmed it"
    field.go_on(10.0)
    assert awarded_states(field, "ginger") == []


def awarded_states(field: Field, name: str) -> list[ScriptState]:
    """Of the scripts by which a robot does legs of others."""
    states = field.world.agents[name].memory().mind.executive.states
    return [state for script_id, state in states.items() if script_id.startswith(AWARDED)]


def test_a_late_copy_of_the_call_does_not_end_a_leg_that_goes_on_after_a_power_failure() -> None:
    field = jammed("fred", "ginger")
    field.order(mission("ginger"))
    assert field.until(200.0, DelegationState.AWARDED)
    field.go_on(2.0)
    call = next(one for one in field.said if one.performative is Performative.CFP)
    field.restart("ginger")
    field.go_on(1.0)
    field.ends["ginger"].send(call)
    assert field.until(200.0)
    assert field.told == [DelegationState.AWARDED, DelegationState.DONE]


def test_who_ends_an_award_before_its_time_without_telling_how_far_it_came_is_stopped() -> None:
    field = jammed("fred", "ginger")
    field.order(mission("ginger"))
    assert field.until(200.0, DelegationState.AWARDED)
    field.go_on(2.0)
    award = next(one for one in field.said if one.performative is Performative.ACCEPT_PROPOSAL)
    assert isinstance(award.body, SpeechAct)
    field.ends["fred"].send(
        Message(
            performative=Performative.NOT_UNDERSTOOD,
            sender="ginger",
            receiver="fred",
            sent_at_s=field.world.clock.now_s(),
            in_reply_to=award.id,
            body=award.body.model_copy(update={"content": "reason(noise)", "script": None}),
        )
    )
    assert field.until(5.0)
    assert field.told == [DelegationState.AWARDED, DelegationState.UNHEARD]
    field.go_on(5.0)
    assert awarded_states(field, "ginger") == [ScriptState.CANCELLED]
    assert not field.world.agents["fred"].memory().mind.social.withdrawals, "it has confirmed it"


def test_a_power_failure_while_it_waits_for_the_service_does_not_count_as_its_answer() -> None:
    field = jammed("fred", "ginger")
    field.order(mission("ginger"))
    while field.world.agents["fred"].memory().mind.social.delegation is None:
        field.tick()
    field.go_on(1.0)
    field.restart("fred")
    assert field.until(100.0, DelegationState.AWARDED)
    assert field.end is None


def test_who_cannot_set_out_to_make_way_does_not_wait_for_that() -> None:
    field = Field("fred", "ginger", lost=["fred"])
    field.world.bodies["fred"].jammed = True
    field.order(mission("ginger"))
    while field.world.agents["fred"].memory().mind.social.delegation is None:
        field.tick()
    assert field.until(20.0)
    assert field.end is not None
    assert "cannot make way" in field.end.detail


def test_what_a_person_has_asked_a_robot_for_is_not_ended_by_an_award() -> None:
    field = jammed("fred", "ginger")
    waits = packet("NAVIGATE", ref2="hatch", after=("a1",), wait_timeout_s=900.0)
    own = script("ginger", waits, name=f"{SAID}1").model_copy(update={"mission_id": OWN})
    field.go_on(1.0)
    assert field.world.agents["ginger"].perform(own) is None
    field.order(mission("ginger"))
    assert field.until(200.0)
    assert field.told == [DelegationState.AWARDED, DelegationState.FAILED, DelegationState.NOT_TAKEN]
    assert "what a person has asked for" in field.delegations[1].detail
    assert field.world.agents["ginger"].state_of(own.id) is ScriptState.RUNNING


def said_by(sender: str, performative: Performative, content: str) -> Callable[[Message], Message]:
    """Puts this in the place of what a robot says by such a performative."""

    def garble(message: Message) -> Message:
        if (message.sender, message.performative) != (sender, performative):
            return message
        return message.model_copy(update={"body": message.body.model_copy(update={"content": content})})

    return garble


@pytest.mark.parametrize("figures", ["cost(-1), way(1)", "cost(1), way(1e308)", "cost(1), way(-9)"])
def test_a_bid_with_figures_that_cannot_be_is_none(figures: str) -> None:
    field = jammed("fred", "ginger")
    content = f"bid(leg_1, {figures}, release(0), work(1), battery(0.9))"
    field.garble = said_by("ginger", Performative.PROPOSE, content)
    field.order(mission("ginger"))
    assert field.until(200.0)
    assert field.told == [DelegationState.NOT_TAKEN]


@pytest.mark.parametrize("how", ["held(5)", "ended(1e300)"])
def test_a_failure_that_cannot_be_read_leaves_unknown_how_far_the_other_came(how: str) -> None:
    field = Field("fred", "ginger", "basil", alone=["ginger", "basil"])
    field.world.bodies["fred"].jammed = True
    field.garble = said_by("ginger", Performative.FAILURE, f"failed(leg_1, jammed, {how})")
    field.order(mission("ginger", "basil"))
    assert field.until(200.0)
    assert field.told == [DelegationState.AWARDED, DelegationState.FAILED]


def test_who_says_that_it_has_the_sample_is_followed_by_nobody_though_it_says_how_far_it_came() -> None:
    field = Field("fred", "ginger", "basil", alone=["ginger", "basil"])
    field.world.bodies["fred"].jammed = True
    failure = "failed(leg_1, jammed, ended(0), held(sample_1))"
    field.garble = said_by("ginger", Performative.FAILURE, failure)
    field.order(mission("ginger", "basil"))
    assert field.until(200.0)
    assert field.told == [DelegationState.AWARDED, DelegationState.FAILED]


def test_a_leg_that_is_too_long_for_a_call_stays_with_its_robot() -> None:
    field = jammed("fred", "ginger")
    one = mission("ginger")
    *before, last = one.packets
    long = last.model_copy(update={"arguments": {**last.arguments, "ref3": "x" * 4000}})
    field.order(one.model_copy(update={"packets": (*before, long)}))
    assert field.until(200.0)
    assert (field.told, field.said) == ([DelegationState.NOT_TAKEN], [])
    assert field.end is not None
    assert "too long for a call" in field.end.detail


def test_an_award_of_something_else_than_was_called_for_is_not_taken_up() -> None:
    field = jammed("fred", "ginger")

    def garble(message: Message) -> Message:
        body = message.body
        if not isinstance(body, SpeechAct) or body.script is None:
            return message
        order = body.script.model_copy(update={"packets": (packet("NAVIGATE", ref2="hatch"),)})
        return message.model_copy(update={"body": body.model_copy(update={"script": order})})

    field.garble = garble
    field.order(mission("ginger"))
    assert field.until(200.0)
    assert field.told == [DelegationState.AWARDED, DelegationState.FAILED, DelegationState.NOT_TAKEN]
    assert "other packets than the call" in field.delegations[1].detail


def test_a_script_that_the_robot_has_had_is_not_awarded_again() -> None:
    field = jammed("fred", "ginger")
    one = mission("ginger")
    waits = packet("NAVIGATE", ref2="hatch", after=("a1",))
    before = script("ginger", waits, name=f"{AWARDED}fred:{one.id}:leg_1:0")
    field.go_on(1.0)
    ginger = field.world.agents["ginger"]
    assert ginger.perform(before.model_copy(update={"mission_id": OWN})) is None
    ginger.withdraw(before.id)
    field.order(one)
    assert field.until(200.0)
    assert field.told == [DelegationState.AWARDED, DelegationState.FAILED, DelegationState.NOT_TAKEN]
    assert "was awarded before" in field.delegations[1].detail


def test_a_missions_script_waits_for_the_end_of_an_awarded_leg_and_is_not_lost() -> None:
    field = jammed("fred", "ginger")
    field.order(mission("ginger"))
    assert field.until(200.0, DelegationState.AWARDED)
    field.go_on(1.0)
    field.order(script("ginger", packet("NAVIGATE", ref2="hatch"), name="another"))
    assert field.until(200.0)
    assert field.end is not None
    assert field.end.state is ScriptState.FINISHED, field.end.detail
    field.go_on(30.0)
    assert field.world.agents["ginger"].memory().mind.executive.states["another"] is ScriptState.FINISHED


def test_a_robot_that_does_no_legs_of_others_is_awarded_none() -> None:
    field = Field("fred", "ginger", alone=["ginger"])
    field.world.bodies["fred"].jammed = True
    field.order(mission("ginger"))
    assert field.until(200.0)
    told = [DelegationState.AWARDED, DelegationState.FAILED, DelegationState.NOT_TAKEN]
    assert field.told == told
    assert "ginger does no legs of other robots" in field.delegations[1].detail
    states = field.world.agents["ginger"].memory().mind.executive.states
    assert not any(name.startswith(AWARDED) for name in states)


def test_those_that_wait_for_the_leg_are_told_of_its_end() -> None:
    field = jammed("fred", "ginger", "basil")
    one = mission("ginger")
    *before, last = one.packets
    tells = (Recipient(robot="basil", script_id="waits", within_s=600.0),)
    field.order(one.model_copy(update={"packets": (*before, last.model_copy(update={"tells": tells}))}))
    waits = packet("NAVIGATE", ref2="hatch", after=(last.id,), wait_timeout_s=900.0)
    told_by = {last.id: ("fred",)}
    field.order(script("basil", waits.model_copy(update={"told_by": told_by}), name="waits"))
    assert field.until(300.0)
    field.go_on(30.0)
    states = field.world.agents["basil"].memory().mind.executive.states
    assert states["waits"] is ScriptState.FINISHED


@pytest.mark.parametrize("seed", range(6))
def test_power_failures_of_both_lose_nothing_and_do_nothing_twice(seed: int) -> None:
    field = jammed("fred", "ginger", seed=seed)
    fates = random.Random(seed)
    field.order(mission("ginger"))
    restarts = 0
    for _ in range(20 * 400):
        field.tick()
        name = fates.choice(("fred", "ginger"))
        delegation = (
            field.world.agents["fred"].memory().mind.social.delegation if fates.random() < 0.02 else None
        )
        if delegation is not None and delegation.phase is not DelegationPhase.PROBING:
            field.restart(name)
            restarts += 1
        if field.end is not None:
            break
    assert restarts > 0
    assert field.end is not None
    assert field.end.state is ScriptState.FINISHED, field.end.detail
    assert field.has_brought()
    assert len({one.robot for one in field.delegations}) == 1
    states = field.world.agents["ginger"].memory().mind.executive.states
    assert sum(name.startswith(AWARDED) for name in states) == 1
