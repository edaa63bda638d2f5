"""Calls for proposals on what robots do in a plan: the packets as each robot would get them, and what they answer."""

from collections.abc import Mapping, Sequence

from sqlalchemy.orm import Session

from app.agents.speech import SpeechService
from app.core import Core
from app.domain.errors import Conflict
from app.domain.mission_organiser import Library, OrganiserFailure, organise
from app.store import ConversationRow
from planner import PlanNet
from robots.executive.offer import Declining, Offer
from robots.social import ContentError, Term, parse_term
from robots.social.legs import MOST_PACKETS, call_of, declining_of, offer_of
from robots.social.protocols import CONTRACT_NET
from robots.wire import MAX_CONTENT, BehaviourPacket, BehaviourScript, Performative
from robots.world import BIDS, WorldFile

REPLY_S = 2.0
"""Wall-clock seconds in which a robot is to answer, beside what its radio takes."""


class LegCalls:
    """Calls robots for parts of plans."""

    def __init__(self, core: Core, *, speech: SpeechService, library: Library) -> None:
        self._core = core
        self._speech = speech
        self._library = library

    def scripts(self, session: Session, net: PlanNet, world: WorldFile) -> Sequence[BehaviourScript]:
        """What each robot, but no peripheral, would get for the plan.

        :raises Conflict: if its actions match no packets.
        """
        organised = organise(
            net,
            self._library,
            {one.name: one.repertoire for one in world.agents},
            "called_for",
            self._core.knowledge_base,
            facts=self._core.facts.facts(session, world.name),
        )
        if isinstance(organised, OrganiserFailure):
            raise Conflict(organised.reason, code="no-packets")
        return [script for script in organised.scripts if script.robot in world.robots_by_name]

    def call(
        self,
        session: Session,
        contents: Mapping[str, Term],
        *,
        world: str,
        opener: str,
        about: str,
        conversation_id: str,
    ) -> Sequence[str]:
        """Call robots for a part of a leg; those that take calls.

        :param contents: by robot, see `call_content`.
        """
        called = [robot for robot in contents if not self._speech.unheard_reason(world, robot, BIDS)]
        for robot in called:
            self._speech.open(
                session,
                world=world,
                robot=robot,
                what=BIDS,
                performative=Performative.CFP,
                content=contents[robot],
                protocol=CONTRACT_NET,
                within_s=self._speech.patience_s(world, robot, REPLY_S),
                opener=opener,
                about=about,
                conversation_id=conversation_id,
            )
        return called


def call_content(leg: str, robot: str, planned: str, packets: Sequence[BehaviourPacket]) -> Term:
    """The content of a call of `robot` for what `planned` does of a leg.

    :raises Conflict: if the packets are too many for a message.
    """
    content = call_of(leg, [_as_of(packet, planned, robot) for packet in packets])
    if len(packets) > MOST_PACKETS or len(str(content)) > MAX_CONTENT:
        limits = f"{MOST_PACKETS} packets or {MAX_CONTENT} characters"
        raise Conflict(f"the part of {planned} is too long for a call: over {limits}", code="part-too-long")
    return content


def offer_in(row: ConversationRow) -> tuple[Offer | None, str]:
    """The offer that a robot has made in a conversation, or why it has made none."""
    said = [one for one in row.said if one["performative"] == Performative.PROPOSE]
    if not said:
        return None, row.reason
    try:
        return offer_of(parse_term(said[-1]["content"])), ""
    except ContentError as error:
        return None, str(error)


def declining_in(row: ConversationRow) -> Declining | None:
    """The kind of reason for which a robot has declined in a conversation."""
    said = [one for one in row.said if one["performative"] == Performative.REFUSE]
    try:
        return declining_of(parse_term(said[-1]["content"])) if said else None
    except ContentError:
        return None


def _as_of(packet: BehaviourPacket, planned: str, robot: str) -> BehaviourPacket:
    """The packet as another robot would get it: its own name where the planned robot's is, and the other way round."""
    names = {planned: robot, robot: planned}
    arguments = {name: names.get(value, value) for name, value in packet.arguments.items()}
    return packet.model_copy(update={"arguments": arguments})
