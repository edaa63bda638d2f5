"""A robot's part in a contract net (FIPA SC00029): it bids for legs, and says how those end that it was awarded.

It does a leg by the script that the award names: the service sends it as any other; a robot, whose leg it is, sends
it with the award, and it becomes one of the robot's own, which no other own script ends and a mission's waits for.
Bids, and awards by the service, do not survive a power failure: whoever has made the award hears nothing more, and its
conversation times out. Awards by robots do, until their time is over: then the robot stops, for the other no longer
waits for it.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from robots.contract.known_scripts import ENDED, remember
from robots.contract.mailbox import SERVICE
from robots.contract.memory import AwardMemory, BidMemory
from robots.executive.delegation import ASIDE, AWARDED
from robots.executive.offer import Offer
from robots.executive.society import Situated
from robots.executive.upkeep import drive_home
from robots.social.conversation import Conversation, Conversations, key_of
from robots.social.legs import AWARD, LEG, REJECT, Failed, bid_of, failed_of, leg_of
from robots.social.protocols import CONTRACT_NET, ContractNetState
from robots.social.speech import Heard, Reply
from robots.social.terms import ContentError, Term
from robots.wire import OWN, BehaviourPacket, BehaviourScript, Performative, ScriptState, SpeechAct

SCRIPT_WITHIN_S = 300.0
"""How long after an award its script may come, if the award does not say it (`reply_by_s`; our choice)."""
MAX_BIDS = 256
"""That are not answered; beyond it the oldest is forgotten."""
LATE_AWARD_S = 60.0
"""How long after the time of another robot's call its award may still come: it is repeated, and may have been lost at
first (our choice). The service decides when the plan is approved, however late.
"""
WITHDRAWN = "withdrawn"
"""What a robot says to one that it has awarded a leg and that is to stop."""
HOME = "home"
"""The packet at the end of an awarded leg, by which the robot leaves the places of the plan."""

Handler = Callable[[Heard, Situated], Reply | None]


@dataclass(slots=True)
class _Bid:
    """A bid for packets, and its award once `award` is set. `until_s`: when the award's script must have come.

    `is_own`: the award has brought the script; `until_s`: when it must have ended; `failed`, `ended`: why it has
    failed, and after how many packets.
    """

    leg: str
    busy_s: float
    packets: Sequence[BehaviourPacket] = ()
    award: Heard | None = None
    script_id: str = ""
    until_s: float = 0.0
    is_own: bool = False
    is_told: bool = False
    failed: str = ""
    ended: int | None = None


class Bidding:
    """The bids that one robot has made and that are not answered, and the legs that it was awarded."""

    def __init__(
        self,
        name: str,
        conversations: Conversations,
        answer: Callable[[Heard, Reply], None],
        *,
        takes_legs: bool = True,
    ) -> None:
        """
        :param answer: says something later in the conversation of what was heard.
        :param takes_legs: it does legs of other robots that they award to it.
        """
        self._name = name
        self._takes_legs = takes_legs
        self._conversations = conversations
        self._answer = answer
        self._bids: OrderedDict[str, _Bid] = OrderedDict()
        self._withdrawn: OrderedDict[str, None] = OrderedDict()
        """Scripts that must not be begun, though their awards may arrive later."""

    def register(self, on: Callable[[Performative, str, Handler], None]) -> None:
        """:param on: `SocialLevel.on`."""
        on(Performative.CFP, LEG, self.called)
        on(Performative.ACCEPT_PROPOSAL, AWARD, self.awarded)
        on(Performative.REJECT_PROPOSAL, REJECT, self.rejected)
        on(Performative.INFORM, WITHDRAWN, self.withdrawn)

    def called(self, heard: Heard, robot: Situated) -> Reply:
        """Bid for a leg, or decline."""
        try:
            leg = leg_of(heard.content, self._name)
        except ContentError as error:
            return Reply(
                performative=Performative.NOT_UNDERSTOOD, content=Term("reason", (str(error)[:300],))
            )
        promised_s = sum(
            bid.busy_s
            for bid in self._bids.values()
            if bid.award is not None and robot.state_of(bid.script_id) is None
        )
        made = robot.offer(leg, promised_s=promised_s)
        if not isinstance(made, Offer):
            return Reply(performative=Performative.REFUSE, content=bid_of(leg.id, made))
        self._bids[_key(heard)] = _Bid(leg=leg.id, busy_s=made.way_s + made.work_s, packets=leg.packets)
        self._keep_open(heard)
        self._forget_oldest()
        return Reply(performative=Performative.PROPOSE, content=bid_of(leg.id, made))

    def awarded(self, heard: Heard, robot: Situated) -> Reply | None:
        """Note an award; what is no award of this bid is not understood."""
        words = heard.content.words
        bid = self._bids.get(_key(heard))
        if bid is None or len(words) != 2 or words[0] != bid.leg:
            self._bids.pop(_key(heard), None)
            why = f"{heard.content} is no award(LEG, SCRIPT) of this bid"
            return Reply(performative=Performative.NOT_UNDERSTOOD, content=Term("reason", (why,)))
        body = heard.message.body
        assert isinstance(body, SpeechAct)
        bid.award = heard
        bid.script_id = words[1]
        bid.until_s = heard.at_s + SCRIPT_WITHIN_S if body.reply_by_s is None else body.reply_by_s
        if body.script is None:
            if (conversation := self._conversation(heard)) is not None:
                conversation.take_time()  # its end is told whenever that is
            return None
        if (reason := self._take_up(body.script, bid, heard, robot)) is not None:
            del self._bids[_key(heard)]
            return _failed(bid.leg, Failed(reason=reason, ended=0))
        bid.is_own = True
        return None

    def withdrawn(self, heard: Heard, robot: Situated) -> Reply:
        """Stop at a leg that was awarded: `withdrawn(SCRIPT)`."""
        script_id = next(iter(heard.content.words), "")
        if script_id.startswith(f"{AWARDED}{heard.sender}:"):
            remember(self._withdrawn, script_id, None)
            robot.withdraw(script_id)
            for bid in self._bids.values():
                bid.is_told |= bid.script_id == script_id
        return Reply(performative=Performative.CONFIRM, content=heard.content)

    def memory(self) -> tuple[AwardMemory, ...]:
        return tuple(
            AwardMemory(
                message=bid.award.message,
                leg=bid.leg,
                script_id=bid.script_id,
                until_s=bid.until_s,
                failed=bid.failed,
                ended=bid.ended,
            )
            for bid in self._bids.values()
            if bid.is_own and bid.award is not None
        )

    def recall(self, awards: Iterable[tuple[AwardMemory, Heard]]) -> None:
        """Go on with legs of other robots after a power failure; those that have ended are told of again."""
        for award, heard in awards:
            body = heard.message.body
            assert isinstance(body, SpeechAct)
            conversation = Conversation(
                CONTRACT_NET,
                body.conversation_id,
                heard.sender,
                heard.message,
                mine=False,
                state=ContractNetState.AWARDED,
            )
            self._conversations.add(conversation)
            bid = _Bid(leg=award.leg, busy_s=0.0, award=heard, script_id=award.script_id)
            bid.until_s = award.until_s
            bid.is_own = True
            bid.failed = award.failed
            bid.ended = award.ended
            self._bids[_key(heard)] = bid

    def bids(self) -> tuple[BidMemory, ...]:
        """The bids that are not answered, and awards by the service, for another program that goes on with them."""
        return tuple(
            BidMemory(
                key=key,
                leg=bid.leg,
                busy_s=bid.busy_s,
                packets=tuple(bid.packets),
                award=None if bid.award is None else bid.award.message,
                awarded_s=0.0 if bid.award is None else bid.award.at_s,
                script_id=bid.script_id,
                until_s=bid.until_s,
            )
            for key, bid in self._bids.items()
            if not bid.is_own
        )

    def withdrawals(self) -> tuple[str, ...]:
        """The last scripts that were withdrawn from this robot."""
        return tuple(self._withdrawn)

    def recall_bids(
        self, bids: Iterable[tuple[BidMemory, Heard | None]], withdrawn: Iterable[str] = ()
    ) -> None:
        """Go on with them; each with its award, understood again."""
        self._withdrawn = OrderedDict.fromkeys(withdrawn)
        for one, award in bids:
            self._bids[one.key] = _Bid(
                leg=one.leg,
                busy_s=one.busy_s,
                packets=one.packets,
                award=award,
                script_id=one.script_id,
                until_s=one.until_s,
            )

    def _take_up(self, script: BehaviourScript, bid: _Bid, heard: Heard, robot: Situated) -> str | None:
        """Begin another robot's leg, or return the reason against it."""
        if (reason := self._why_not(script, bid, heard, robot)) is not None:
            return reason
        percepts = robot.percepts
        if percepts is None:
            return f"{self._name} has sensed nothing yet"
        if percepts.last_held is not None:
            return f"{self._name} holds {percepts.last_held}"
        if percepts.profile.home is None:
            return f"{self._name} has no home to drive to afterwards"
        packets = (*script.packets, drive_home(percepts.profile.home, HOME))
        own = {"mission_id": OWN, "revision": 0, "delegable": (), "packets": packets}
        return robot.perform(script.model_copy(update=own))

    def _why_not(self, script: BehaviourScript, bid: _Bid, heard: Heard, robot: Situated) -> str | None:
        """What is wrong with the script of an award."""
        if not self._takes_legs:
            return f"{self._name} does no legs of other robots"
        if not script.id.startswith(f"{AWARDED}{heard.sender}:") or script.robot != self._name:
            return f"{script.id} is no script of {heard.sender} for {self._name}"
        if _works(script.packets) != _works(bid.packets):
            return f"{script.id} has other packets than the call for {bid.leg}"
        if robot.state_of(script.id) is not None:
            return f"{script.id} was awarded before"
        if script.id in self._withdrawn:
            return f"{script.id} was withdrawn before it arrived"
        return None

    def rejected(self, heard: Heard, robot: Situated) -> None:
        """Forget a bid that was not taken."""
        self._bids.pop(_key(heard), None)

    def step(self, robot: Situated, now_s: float) -> None:
        """Say of awarded legs that have ended how they have, and forget bids whose conversations have."""
        for key, bid in list(self._bids.items()):
            if bid.is_own and bid.award is not None:
                self._step_own(key, bid, bid.award, robot, now_s)
                continue
            conversation = self._conversations.at(key)
            if conversation is None or conversation.has_ended:
                del self._bids[key]
                continue
            if bid.award is None:
                continue
            state = robot.state_of(bid.script_id)
            if state in ENDED or (state is None and now_s >= bid.until_s):
                del self._bids[key]
                self._answer(bid.award, _ending(bid.leg, state))

    def _step_own(self, key: str, bid: _Bid, award: Heard, robot: Situated, now_s: float) -> None:
        """Tell the robot whose leg it is how it has ended. It is kept until its time is over, to be told again."""
        if now_s >= bid.until_s:
            del self._bids[key]
            robot.withdraw(bid.script_id)
            return
        state = robot.state_of(bid.script_id)
        if bid.is_told or state not in ENDED:
            return
        if state is not ScriptState.FINISHED and not self._has_made_way(bid, robot):
            return
        bid.is_told = True
        conversation = self._conversation(award)
        if conversation is not None and not conversation.has_ended:
            reply = _done(bid, robot) if state is ScriptState.FINISHED else _failed_leg(bid, robot)
            self._answer(award, reply)

    def _has_made_way(self, bid: _Bid, robot: Situated) -> bool:
        """After a failure with empty jaws drive home, out of the way of the next; True once that has ended."""
        percepts = robot.percepts
        if not bid.failed:
            bid.failed = robot.why_ended(bid.script_id) or "its script has ended"
            bid.ended = robot.packets_ended(bid.script_id)
            if percepts is not None and percepts.last_held is None and percepts.profile.home is not None:
                way = drive_home(percepts.profile.home, HOME)
                robot.perform(
                    BehaviourScript(id=_aside(bid), mission_id=OWN, robot=self._name, packets=(way,))
                )
        return robot.state_of(_aside(bid)) in (None, *ENDED)

    def _keep_open(self, heard: Heard) -> None:
        """Have the conversation last until an award can come no more."""
        conversation = self._conversation(heard)
        if conversation is not None and conversation.reply_by_s is not None:
            until_s = None if heard.sender == SERVICE else conversation.reply_by_s + LATE_AWARD_S
            conversation.take_time(until_s)

    def _forget_oldest(self) -> None:
        unanswered = [key for key, bid in self._bids.items() if bid.award is None]
        for key in unanswered[:-MAX_BIDS]:
            del self._bids[key]
            if (conversation := self._conversations.at(key)) is not None:
                conversation.cancel()

    def _conversation(self, heard: Heard) -> Conversation | None:
        return self._conversations.at(_key(heard))


def _ending(leg: str, state: ScriptState | None) -> Reply:
    if state is ScriptState.FINISHED:
        return Reply(performative=Performative.INFORM, content=Term("done", (leg,)))
    reason = "its script has not come" if state is None else f"its script has {state.value}"
    return Reply(performative=Performative.FAILURE, content=Term("failed", (leg, reason)))


def _works(packets: Sequence[BehaviourPacket]) -> list[tuple[str, dict[str, str]]]:
    """What a call says of packets."""
    return [(one.tag, one.arguments) for one in packets]


def _aside(bid: _Bid) -> str:
    return f"{ASIDE}{bid.script_id}"


def _done(bid: _Bid, robot: Situated) -> Reply:
    home = None if robot.percepts is None else robot.percepts.profile.home
    stands = () if home is None else (Term("near", (home,)),)
    return Reply(performative=Performative.INFORM, content=Term("done", (bid.leg, *stands)))


def _failed_leg(bid: _Bid, robot: Situated) -> Reply:
    """Who has not made way leaves out how far it came: nobody else can begin where it stands."""
    held = None if robot.percepts is None else robot.percepts.last_held
    has_made_way = robot.state_of(_aside(bid)) is ScriptState.FINISHED
    ended = bid.ended if has_made_way else None
    return _failed(bid.leg, Failed(reason=bid.failed[:300], ended=ended, held=held))


def _failed(leg: str, failed: Failed) -> Reply:
    return Reply(performative=Performative.FAILURE, content=failed_of(leg, failed))


def _key(heard: Heard) -> str:
    body = heard.message.body
    return key_of(body.conversation_id if isinstance(body, SpeechAct) else "", heard.sender)
