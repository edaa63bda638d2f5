"""A robot's part in a contract net (FIPA SC00029): it bids for legs, and says how those end that it was awarded.

It does a leg by the script that the award names, which the service sends as any other. Bids and awards do not survive a
power failure: whoever has made the award hears nothing more, and its conversation times out.
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from robots.contract.known_scripts import ENDED, remember
from robots.executive.offer import Offer
from robots.executive.society import Situated
from robots.social.conversation import Conversation, Conversations
from robots.social.legs import AWARD, LEG, REJECT, bid_of, leg_of
from robots.social.speech import Heard, Reply
from robots.social.terms import ContentError, Term
from robots.wire import Performative, ScriptState, SpeechAct

SCRIPT_WITHIN_S = 300.0
"""How long after an award its script may come, if the award does not say it (`reply_by_s`; our choice)."""
MAX_BIDS = 256

Handler = Callable[[Heard, Situated], Reply | None]


@dataclass(slots=True)
class _Bid:
    """A bid, and its award once `award` is set. `until_s`: when the award's script must have come."""

    leg: str
    busy_s: float
    award: Heard | None = None
    script_id: str = ""
    until_s: float = 0.0


class Bidding:
    """The bids that one robot has made and that are not answered, and the legs that it was awarded."""

    def __init__(
        self, name: str, conversations: Conversations, answer: Callable[[Heard, Reply], None]
    ) -> None:
        """:param answer: says something later in the conversation of what was heard."""
        self._name = name
        self._conversations = conversations
        self._answer = answer
        self._bids: OrderedDict[str, _Bid] = OrderedDict()

    def register(self, on: Callable[[Performative, str, Handler], None]) -> None:
        """:param on: `SocialLevel.on`."""
        on(Performative.CFP, LEG, self.called)
        on(Performative.ACCEPT_PROPOSAL, AWARD, self.awarded)
        on(Performative.REJECT_PROPOSAL, REJECT, self.rejected)

    def called(self, heard: Heard, robot: Situated) -> Reply:
        """Bid for a leg, or decline."""
        try:
            leg = leg_of(heard.content, self._name)
        except ContentError as error:
            return Reply(performative=Performative.NOT_UNDERSTOOD, content=Term("reason", (str(error),)))
        promised_s = sum(
            bid.busy_s
            for bid in self._bids.values()
            if bid.award is not None and robot.state_of(bid.script_id) is None
        )
        made = robot.offer(leg, promised_s=promised_s)
        if not isinstance(made, Offer):
            return Reply(performative=Performative.REFUSE, content=bid_of(leg.id, made))
        bid = _Bid(leg=leg.id, busy_s=made.way_s + made.work_s)
        remember(self._bids, _key(heard), bid, MAX_BIDS)
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
        reply_by_s = body.reply_by_s if isinstance(body, SpeechAct) else None
        bid.award = heard
        bid.script_id = words[1]
        bid.until_s = heard.at_s + SCRIPT_WITHIN_S if reply_by_s is None else reply_by_s
        return None

    def rejected(self, heard: Heard, robot: Situated) -> None:
        """Forget a bid that was not taken."""
        self._bids.pop(_key(heard), None)

    def step(self, robot: Situated, now_s: float) -> None:
        """Say of awarded legs that have ended how they have."""
        for key, bid in list(self._bids.items()):
            if bid.award is None:
                continue
            conversation = self._conversation(bid.award)
            if conversation is None or conversation.has_ended:  # cancelled, or forgotten
                del self._bids[key]
                continue
            state = robot.state_of(bid.script_id)
            if state in ENDED or (state is None and now_s >= bid.until_s):
                del self._bids[key]
                self._answer(bid.award, _ending(bid.leg, state))

    def _conversation(self, heard: Heard) -> Conversation | None:
        body = heard.message.body
        assert isinstance(body, SpeechAct)
        return self._conversations.of(body.conversation_id, heard.sender)


def _ending(leg: str, state: ScriptState | None) -> Reply:
    if state is ScriptState.FINISHED:
        return Reply(performative=Performative.INFORM, content=Term("done", (leg,)))
    reason = "its script has not come" if state is None else f"its script has {state.value}"
    return Reply(performative=Performative.FAILURE, content=Term("failed", (leg, reason)))


def _key(heard: Heard) -> str:
    body = heard.message.body
    return f"{heard.sender}/{body.conversation_id if isinstance(body, SpeechAct) else ''}"
