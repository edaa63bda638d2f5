"""Clearance from robot to robot: whoever ends an action tells those whose scripts wait for it.

The scripts say whom to tell and whom to believe. The service's clearance stays: whichever comes first counts, and the
other changes nothing.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from robots.contract.memory import OwedClearance
from robots.executive.society import Clearing, Situated
from robots.social.protocols import INFORM, InformState
from robots.social.speech import Ending, Heard, Reply
from robots.social.terms import Term
from robots.wire import BehaviourPacket, Performative, SpeechAct, SpeechReport

AGAIN_S = 4.0
"""A robot that does not have its script yet is told again after this time; after each further attempt twice as much."""
LONGEST_AGAIN_S = 32.0
MAX_OWED = 256
MAY_COME = Clearing.UNKNOWN_SCRIPT
"""The refusal after which the same is said again."""

Say = Callable[..., Any]


@dataclass(slots=True)
class _Owed:
    owed: OwedClearance
    due_s: float
    pause_s: float = AGAIN_S
    is_said: bool = False


class PeerClearance:
    """What one robot owes others, and what it takes from them."""

    def __init__(self, say: Say) -> None:
        """:param say: `SocialLevel.say`."""
        self._say = say
        self._owed: dict[tuple[str, str, str], _Owed] = {}

    def packet_ended(self, packet: BehaviourPacket, now_s: float) -> None:
        """Owe it to those who wait for this packet's end."""
        for one in packet.tells:
            self._owe(
                OwedClearance(
                    robot=one.robot, script_id=one.script_id, action=packet.id, until_s=now_s + one.within_s
                ),
                now_s,
            )

    def step(self, now_s: float) -> None:
        """Say what is due."""
        for key, one in list(self._owed.items()):
            owed = one.owed
            if one.is_said or now_s < one.due_s:
                continue
            if now_s >= owed.until_s:
                del self._owed[key]
                continue
            one.is_said = True
            self._say(
                Performative.INFORM,
                owed.robot,
                Term("ended", (owed.script_id, owed.action)),
                protocol=INFORM,
                within_s=owed.until_s - now_s,
                ended=lambda ending, key=key: self._answered(key, ending),
            )

    def heard(self, heard: Heard, robot: Situated) -> Reply:
        """Another robot says to have ended its part of an action: `ended(script, action)`."""
        words = heard.content.words
        if len(words) != 2:
            why = "ended has two arguments, the script that waits and the action"
            return Reply(performative=Performative.NOT_UNDERSTOOD, content=Term("reason", (why,)))
        script_id, action = words
        outcome = robot.clear_by(script_id, action, heard.sender)
        noted = outcome is Clearing.NOTED
        answer = Reply(
            performative=Performative.CONFIRM if noted else Performative.REFUSE,
            content=heard.content if noted else Term(outcome.value, (script_id, action)),
        )
        if outcome is not MAY_COME:
            robot.tell_service(_report(heard, script_id, answer))
        return answer

    def memory(self) -> tuple[OwedClearance, ...]:
        return tuple(one.owed for one in self._owed.values())

    def recall(self, owed: Iterable[OwedClearance]) -> None:
        for one in owed:
            self._owe(one, float("-inf"))

    def _owe(self, owed: OwedClearance, now_s: float) -> None:
        self._owed.setdefault((owed.robot, owed.script_id, owed.action), _Owed(owed, now_s))
        if len(self._owed) > MAX_OWED:  # the service clears whom this robot does not
            del self._owed[next(iter(self._owed))]

    def _answered(self, key: tuple[str, str, str], ending: Ending) -> None:
        one = self._owed.get(key)
        if one is None:
            return
        answer = ending.answer
        refused = ending.state == InformState.REFUSED and answer is not None
        if refused and answer is not None and answer.content.name == MAY_COME.value:
            one.is_said = False
            one.due_s = ending.at_s + one.pause_s
            one.pause_s = min(2 * one.pause_s, LONGEST_AGAIN_S)
        else:
            del self._owed[key]


def _report(heard: Heard, script_id: str, answer: Reply) -> SpeechReport:
    body = heard.message.body
    assert isinstance(body, SpeechAct)
    return SpeechReport(
        script_id=script_id,
        sender=heard.sender,
        performative=heard.performative,
        content=body.content,
        protocol=body.protocol,
        conversation_id=body.conversation_id,
        sent_at_s=heard.message.sent_at_s,
        at_s=heard.at_s,
        attempt=body.attempt,
        answer=answer.performative,
        answer_content=answer.text,
    )
