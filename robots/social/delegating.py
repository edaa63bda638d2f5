"""A robot puts a leg that it could not do to other robots (FIPA SC00029 as the initiator), while the service is away.

Its script says which legs, and to whom; it stays responsible for them. It waits whether the service answers, which
sees the whole plan and decides then, as without this: the script fails. Else it drives home, calls the named robots
and awards the leg to the idle one that bids least. If the service is heard before that, it decides, too. If the other
fails with empty jaws and has moved nothing, the others are called again, unless the service answers; in each other case
the script fails. What is under way is kept over a power failure.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

from robots.clock import Clock
from robots.conditions.facts import REPORTED
from robots.contract.known_scripts import ENDED
from robots.contract.memory import DelegationMemory, DelegationPhase, WithdrawalMemory
from robots.executive.delegation import ASIDE, AWARDED, DelegatedLeg
from robots.executive.offer import Offer
from robots.executive.society import Situated
from robots.executive.upkeep import drive_home
from robots.perception.percepts import NOTHING, Needs
from robots.social.bidding import HOME, WITHDRAWN
from robots.social.conversation import Conversation
from robots.social.legs import AWARD, REJECT, Failed, call_of, failure_of, offer_of
from robots.social.protocols import CONTRACT_NET, INFORM, ContractNetState, InteractionProtocol
from robots.social.speech import Ending, Heard
from robots.social.terms import ContentError, Term
from robots.wire import (
    MAX_CONTENT,
    OWN,
    BehaviourPacket,
    BehaviourScript,
    DelegationBid,
    DelegationReport,
    DelegationState,
    Message,
    Performative,
    ScriptState,
    SymbolicFact,
)

BIDS_WITHIN_S = 30.0
"""How long proposals are awaited at most, beside the radio's round trip (our choice)."""
ASIDE_S = 150.0
"""How long the robot tries to make way (our choice)."""
HOME_S = 120.0
"""How long the other robot may take to drive home after the leg, before it counts as unheard (our choice)."""
NEAR_M = 1.5
"""A robot that cannot make way stands in nobody's way this far from all places of the leg (our choice)."""


class Speaker(Protocol):
    """The social level, as far as this speaks through it."""

    def say(
        self,
        performative: Performative,
        receiver: str,
        content: Term,
        *,
        protocol: InteractionProtocol,
        within_s: float,
        ended: Callable[[Ending], None] = ...,
    ) -> Conversation: ...

    def say_in(
        self,
        conversation: Conversation,
        performative: Performative,
        content: Term,
        *,
        within_s: float | None = None,
        script: BehaviourScript | None = None,
    ) -> Message: ...

    def go_on_with(self, award: Message) -> Conversation: ...

    @property
    def round_trip_s(self) -> float: ...

    def packet_ended(self, packet: BehaviourPacket) -> None: ...


class Delegating:
    """One robot's part as the one whose leg others do; at most one at a time."""

    def __init__(self, name: str, clock: Clock, speaker: Speaker) -> None:
        self._name = name
        self._clock = clock
        self._speaker = speaker
        self._state: DelegationMemory | None = None
        self._calls: Sequence[Conversation] = ()
        self._awarded: Conversation | None = None
        self._is_to_drive = False
        self._withdrawals: dict[str, WithdrawalMemory] = {}
        """By script, those whose robots have not confirmed that they stop."""

    @property
    def needs(self) -> Needs:
        """What a report of its end would tell."""
        return NOTHING if self._state is None else REPORTED

    def memory(self) -> DelegationMemory | None:
        return self._state

    def withdrawals(self) -> tuple[WithdrawalMemory, ...]:
        return tuple(self._withdrawals.values())

    def recall(self, memory: DelegationMemory | None, withdrawals: Iterable[WithdrawalMemory] = ()) -> None:
        """Go on after a power failure: it sets out again and calls again; an award stands, and so does its end."""
        for one in withdrawals:
            self._withdraw(one)
        # NOTE: whether the service answers it can only see from now on.
        self._state = None if memory is not None and memory.phase is DelegationPhase.PROBING else memory
        self._is_to_drive = memory is not None and memory.phase is DelegationPhase.MAKING_WAY
        if memory is not None and memory.award is not None:
            self._awarded = self._speaker.go_on_with(memory.award)

    def step(self, robot: Situated, now_s: float) -> None:
        leg = robot.delegated
        state = self._state
        if state is not None and (leg is None or (leg.script_id, leg.leg.id) != (state.script_id, state.leg)):
            self._drop(state, now_s)
            state = None
        if leg is None:
            return
        if state is None:
            state = DelegationMemory(
                script_id=leg.script_id, leg=leg.leg.id, phase=DelegationPhase.PROBING, since_s=now_s
            )
            self._state = state
        if robot.state_of(leg.script_id) is ScriptState.PAUSED:
            if state.phase is not DelegationPhase.AWARDED:
                self._note(since_s=now_s)
                self._call_off(leg.leg.id)
            return
        if state.phase is not DelegationPhase.AWARDED and robot.service_heard_s >= state.since_s:
            self._call_off(leg.leg.id)
            self._give_up(leg, robot, "the service is in reach and decides")
            return
        match state.phase:
            case DelegationPhase.PROBING:
                self._probe(state, robot, now_s)
            case DelegationPhase.MAKING_WAY:
                self._make_way(state, leg, robot, now_s)
            case DelegationPhase.CALLING:
                self._call(state, leg, robot, now_s)
            case DelegationPhase.AWARDED:
                self._follow(state, leg, robot, now_s)

    def _probe(self, state: DelegationMemory, robot: Situated, now_s: float) -> None:
        if _has_waited(state, robot, now_s):
            self._note(phase=DelegationPhase.MAKING_WAY, since_s=now_s)
            self._is_to_drive = True

    def _make_way(self, state: DelegationMemory, leg: DelegatedLeg, robot: Situated, now_s: float) -> None:
        percepts = robot.percepts
        if percepts is None:
            return
        home = percepts.profile.home
        if self._is_to_drive and home is not None:
            self._is_to_drive = False
            self._note(drives=state.drives + 1, since_s=now_s)
            packet = drive_home(home, HOME).model_copy(update={"timeout_s": ASIDE_S})
            name = _aside(state, state.drives + 1)
            own = BehaviourScript(id=name, mission_id=OWN, robot=self._name, packets=(packet,))
            if robot.make_way(own) is None:
                return
            how = None
        else:
            how = robot.state_of(_aside(state, state.drives))
            if how is not None and how not in ENDED and now_s < state.since_s + ASIDE_S:
                return
        if how is ScriptState.FINISHED:
            self._note(phase=DelegationPhase.CALLING, since_s=now_s, aside=home or "")
            return
        at = complex(percepts.pose.x_m, percepts.pose.y_m)
        named = {name for packet in leg.packets for name in packet.arguments.values()}
        places = [place for name, place in percepts.profile.places.items() if name in named]
        if any(abs(place.point - at) < NEAR_M for place in places):
            self._give_up(leg, robot, "it cannot make way for another robot")
        else:
            self._note(phase=DelegationPhase.CALLING, since_s=now_s)

    def _call(self, state: DelegationMemory, leg: DelegatedLeg, robot: Situated, now_s: float) -> None:
        decide_s = BIDS_WITHIN_S + self._speaker.round_trip_s
        if not self._calls:
            if state.tried and not _has_waited(state, robot, now_s):
                return  # the service may have learned of the first award, and answers that it has failed
            called = [one for one in leg.leg.robots if one not in state.tried]
            if not called:
                self._give_up(leg, robot, "no other robot is left", DelegationState.NOT_TAKEN)
                return
            contents = {one: call_of(leg.leg.id, _as_of(leg.packets, self._name, one)) for one in called}
            if any(len(str(call)) > MAX_CONTENT for call in contents.values()):
                why = f"the leg is too long for a call: over {MAX_CONTENT} characters"
                self._give_up(leg, robot, why, DelegationState.NOT_TAKEN)
                return
            self._calls = tuple(
                self._speaker.say(Performative.CFP, one, call, protocol=CONTRACT_NET, within_s=2 * decide_s)
                for one, call in contents.items()
            )
            self._note(since_s=now_s)
            return
        is_open = any(one.state == ContractNetState.CALLED for one in self._calls)
        if is_open and now_s < state.since_s + decide_s:
            return
        calls = self._calls
        self._calls = ()
        self._award(state, leg, robot, calls, now_s)

    def _award(
        self,
        state: DelegationMemory,
        leg: DelegatedLeg,
        robot: Situated,
        calls: Sequence[Conversation],
        now_s: float,
    ) -> None:
        """Award the leg to the idle robot that bids least, and reject the other bids."""
        heard = {one.partner: one.answer for one in calls}
        offers = {name: made for name, said in heard.items() if (made := _offer(said)) is not None}
        bids = tuple(_bid(one, heard[one.partner], offers.get(one.partner)) for one in calls)
        # NOTE: who is at a script of its own would come to this one only after it, in an order that nobody has proven.
        idle = {one.partner: one for one in calls if _is_idle(offers.get(one.partner))}
        winner = min(idle, key=lambda name: (offers[name].cost_s, name), default=None)
        for one in calls:
            if one.partner != winner and one.state == ContractNetState.PROPOSED:
                self._speaker.say_in(one, Performative.REJECT_PROPOSAL, Term(REJECT, (leg.leg.id,)))
        if winner is None:
            self._note(bids=bids)
            self._give_up(leg, robot, f"no idle robot takes it: {_words(bids)}", DelegationState.NOT_TAKEN)
            return
        script = self._script(state, leg, winner)
        within_s = HOME_S + sum(one.timeout_s + one.wait_timeout_s for one in leg.packets)
        award = self._speaker.say_in(
            idle[winner],
            Performative.ACCEPT_PROPOSAL,
            Term(AWARD, (leg.leg.id, script.id)),
            within_s=within_s,
            script=script,
        )
        self._awarded = idle[winner]
        self._note(
            phase=DelegationPhase.AWARDED,
            since_s=now_s,
            award=award,
            tried=(*state.tried, winner),
            count=state.count + 1,
            bids=bids,
            expected_s=offers[winner].way_s + offers[winner].work_s,
        )
        self._report(robot, DelegationState.AWARDED, winner)

    def _script(self, state: DelegationMemory, leg: DelegatedLeg, winner: str) -> BehaviourScript:
        return BehaviourScript(
            id=f"{AWARDED}{self._name}:{leg.script_id}:{leg.leg.id}:{state.count}",
            mission_id=OWN,
            robot=winner,
            packets=_as_of(leg.packets, self._name, winner),
        )

    def _follow(self, state: DelegationMemory, leg: DelegatedLeg, robot: Situated, now_s: float) -> None:
        """Go on once the other robot has done the leg; call again, or give up, if it has not."""
        conversation = self._awarded
        if conversation is None or state.award is None or not conversation.has_ended:
            return
        winner = state.award.receiver
        answer = conversation.answer
        self._awarded = None
        if conversation.state == ContractNetState.DONE:
            self._report(robot, DelegationState.DONE, winner, stands=_stands(answer))
            for packet in leg.packets:
                self._speaker.packet_ended(packet)
            self._state = None
            robot.end_delegated(winner)
            return
        if conversation.state != ContractNetState.FAILED or answer is None:
            self._stop(state, conversation, now_s)
            why = f"{winner}, which was awarded it, has not told its end: {conversation.state}"
            self._give_up(leg, robot, why, DelegationState.UNHEARD, winner)
            return
        failed = _failure(answer)
        self._note(award=None)
        if failed.held is not None or failed.ended is None or _has_moved(leg.packets[: failed.ended], robot):
            self._give_up(
                leg, robot, f"{winner} has failed at it: {failed.reason}", DelegationState.FAILED, winner
            )
            return
        self._report(robot, DelegationState.FAILED, winner, detail=failed.reason)
        self._note(phase=DelegationPhase.CALLING, since_s=now_s)

    def _give_up(
        self,
        leg: DelegatedLeg,
        robot: Situated,
        why: str,
        state: DelegationState | None = None,
        winner: str = "",
    ) -> None:
        """The script fails, as it would have without others; `state`: what is told of the call before, if anything."""
        if state is not None:
            self._report(robot, state, winner, detail=why)
        self._state = None
        robot.take_back(why)

    def _drop(self, state: DelegationMemory, now_s: float) -> None:
        """The script has ended otherwise: who does the leg is to stop."""
        self._state = None
        self._call_off(state.leg)
        if self._awarded is not None and not self._awarded.has_ended:
            self._awarded.cancel()
            self._stop(state, self._awarded, now_s)
        self._awarded = None

    def _call_off(self, leg: str) -> None:
        """Leave the present call: nobody is awarded the leg."""
        for one in self._calls:
            if one.state == ContractNetState.PROPOSED:
                self._speaker.say_in(one, Performative.REJECT_PROPOSAL, Term(REJECT, (leg,)))
            else:
                one.cancel()
        self._calls = ()

    def _stop(self, state: DelegationMemory, awarded: Conversation, now_s: float) -> None:
        """Have the robot that was awarded the leg stop; it does so by itself once its time is over."""
        until_s = awarded.reply_by_s
        if until_s is not None and now_s < until_s:
            script_id = f"{AWARDED}{self._name}:{state.script_id}:{state.leg}:{state.count - 1}"
            self._withdraw(WithdrawalMemory(robot=awarded.partner, script_id=script_id, until_s=until_s))

    def _withdraw(self, one: WithdrawalMemory) -> None:
        """Tell a robot to stop, until it has confirmed it or has stopped by itself, also after a power failure."""
        self._withdrawals[one.script_id] = one
        self._speaker.say(
            Performative.INFORM,
            one.robot,
            Term(WITHDRAWN, (one.script_id,)),
            protocol=INFORM,
            within_s=one.until_s - self._clock.now_s(),
            ended=lambda ending: self._forget(one.script_id),
        )

    def _forget(self, script_id: str) -> None:
        self._withdrawals.pop(script_id, None)

    def _note(self, **changes: object) -> None:
        if self._state is not None:
            self._state = self._state.model_copy(update=changes)

    def _report(
        self, robot: Situated, how: DelegationState, winner: str, *, stands: str = "", detail: str = ""
    ) -> None:
        state = self._state
        if state is not None:
            robot.tell_service(
                DelegationReport(
                    script_id=state.script_id,
                    leg=state.leg,
                    state=how,
                    at_s=self._clock.now_s(),
                    robot=winner,
                    bids=state.bids,
                    expected_s=state.expected_s,
                    stands=stands,
                    aside=state.aside,
                    detail=detail,
                )
            )


def _has_waited(state: DelegationMemory, robot: Situated, now_s: float) -> bool:
    """True once the service would have answered what the robot has reported at the phase's beginning."""
    return now_s >= state.since_s + 2 * robot.service_answers_s


def _aside(state: DelegationMemory, count: int) -> str:
    return f"{ASIDE}{state.script_id}:{state.leg}:{count}"


def _offer(heard: Heard | None) -> Offer | None:
    if heard is None or heard.performative is not Performative.PROPOSE:
        return None
    try:
        return offer_of(heard.content)
    except ContentError:
        return None


def _failure(heard: Heard) -> Failed:
    """What nobody can read tells nothing of how far the other came."""
    try:
        return failure_of(heard.content)
    except ContentError as error:
        return Failed(reason=str(error)[:300])


def _is_idle(offer: Offer | None) -> bool:
    return offer is not None and offer.release_s <= 0


def _bid(conversation: Conversation, heard: Heard | None, offer: Offer | None) -> DelegationBid:
    name = conversation.partner
    if offer is not None:
        reason = "" if _is_idle(offer) else f"busy for {offer.release_s:.0f} s"
        return DelegationBid(robot=name, cost_s=offer.cost_s, reason=reason)
    return DelegationBid(
        robot=name, reason=conversation.state if heard is None else str(heard.content)[:1000]
    )


def _words(bids: Sequence[DelegationBid]) -> str:
    return "; ".join(f"{one.robot} {one.reason}" for one in bids)


def _stands(answer: Heard | None) -> str:
    near = [] if answer is None else [one for one in answer.content.args if isinstance(one, Term)]
    return next((one.words[0] for one in near if one.name == "near" and one.args), "")


def _has_moved(ended: Sequence[BehaviourPacket], robot: Situated) -> bool:
    """Whether one of the packets takes something or puts it down."""
    return any(robot.moves_jaws(packet) for packet in ended)


def _as_of(packets: Sequence[BehaviourPacket], me: str, other: str) -> tuple[BehaviourPacket, ...]:
    """The packets as another robot gets them: its own name in place of this one's, and told by and to nobody."""
    begins_s = packets[0].expected_start_s

    def named(facts: Sequence[SymbolicFact]) -> tuple[SymbolicFact, ...]:
        return tuple(
            one.model_copy(update={"args": tuple(other if arg == me else arg for arg in one.args)})
            for one in facts
        )

    return tuple(
        packet.model_copy(
            update={
                "arguments": {
                    name: other if value == me else value for name, value in packet.arguments.items()
                },
                "requires": named(packet.requires),
                "awaits": named(packet.awaits),
                "achieves": named(packet.achieves),
                "after": (),
                "told_by": {},
                "tells": (),
                "events": {},
                "instead_of": (),
                "because": (),
                "expected_start_s": packet.expected_start_s - begins_s,
            }
        )
        for packet in packets
    )
