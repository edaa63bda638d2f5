"""A proposed plan put to the robots by contract net (FIPA SC00029): what each bids for each robot's part, or why not.

The robots are asked only: every bid is answered with reject-proposal, and the plan keeps its robots. Whoever decides on
the plan sees what the robots know of themselves (MACTA §4: planning may communicate with agents).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.agents.speech import SpeechService, last_heard
from app.core import Core
from app.domain.errors import Conflict
from app.domain.events import PlanBidsCalled
from app.domain.goal_language.words import joined
from app.domain.ids import new_id
from app.domain.lifecycles.plan import PlanState
from app.planning.leg_calls import LegCalls, call_content, offer_in
from app.planning.proposals import plan_row
from app.store import ConversationRow, PlanRow
from robots.executive.offer import Offer
from robots.social import Term, parse_term
from robots.social.legs import REJECT, leg_of
from robots.wire import Performative
from robots.world import BIDS, WorldFile

OPENER = "bids"
NO_SPEECH = "no_speech"
"""The state of a robot that does not take calls."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotBid:
    """What a robot has answered to the call for a part.

    :param state: of the conversation, or `no_speech`. :param offer: None: it has made none, or none yet.
    :param reason: why it has made none.
    """

    robot: str
    state: str
    offer: Offer | None = None
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PartBids:
    """The bids for the part of the plan that `robot` has in it.

    :param cheapest: the robot whose bid has the lowest cost; None while there is none.
    """

    robot: str
    packets: Sequence[str]
    bids: Sequence[RobotBid]
    cheapest: str | None


@dataclass(slots=True)
class _Part:
    packets: Sequence[str]
    bids: list[RobotBid] = field(default_factory=list)


class PlanBids:
    """Calls for proposals on plans, and reads what came of it."""

    def __init__(
        self,
        core: Core,
        *,
        speech: SpeechService,
        worlds: Mapping[str, WorldFile],
        calls: LegCalls,
    ) -> None:
        self._core = core
        self._speech = speech
        self._worlds = worlds
        self._calls = calls
        speech.listen(OPENER, self._answered)

    def call(self, plan_id: str, *, actor: str) -> Sequence[PartBids]:
        """Ask all robots of the plan's world for bids for each robot's part; returns at once.

        :raises Conflict: if the plan is no longer proposed, its actions match no packets, or robots have not answered
            the last call yet.
        """
        with self._core.database.write() as session:
            self._core.database.lock(session, f"bids {plan_id}")
            plan = plan_row(session, plan_id)
            if plan.state != PlanState.PROPOSED:
                detail = f"plan {plan_id} is {plan.state}: robots bid for proposed plans only"
                raise Conflict(detail, code="plan-decided")
            if silent := sorted({row.robot for row in self._rows(session, plan) if not row.is_over}):
                detail = f"{joined(silent, last='and')} have not answered the last call; read its bids, then call again"
                raise Conflict(detail, code="bids-called")
            called: dict[str, None] = {}
            world = self._worlds[plan.world]
            for part in self._calls.scripts(session, self._core.plan_nets.of(session, plan.id), world):
                contents = {
                    robot.name: call_content(part.robot, robot.name, part.robot, part.packets)
                    for robot in world.robots
                }
                heard = self._calls.call(
                    session,
                    contents,
                    world=plan.world,
                    opener=OPENER,
                    about=plan.id,
                    conversation_id=new_id("call"),
                )
                called.update(dict.fromkeys(heard))
            self._core.events.append(
                session, PlanBidsCalled(subject=plan.id, goal=plan.goal_id, actor=actor, robots=tuple(called))
            )
            return self._read(session, plan)

    def of(self, plan_id: str) -> Sequence[PartBids]:
        """What the robots have answered to the last call, by the part's robot; empty if they were not asked."""
        with self._core.database.read() as session:
            return self._read(session, plan_row(session, plan_id))

    def _answered(self, session: Session, row: ConversationRow) -> None:
        """Reject a bid: the plan keeps its robots."""
        heard = last_heard(row)
        if row.is_over or heard is None or heard[0] is not Performative.PROPOSE:
            return
        leg = parse_term(row.said[0]["content"]).words[0]
        self._speech.say(session, row, Performative.REJECT_PROPOSAL, Term(REJECT, (leg,)))

    def _rows(self, session: Session, plan: PlanRow) -> Sequence[ConversationRow]:
        of_plan = (ConversationRow.about == plan.id, ConversationRow.opener == OPENER)
        query = select(ConversationRow).where(ConversationRow.world == plan.world, *of_plan)
        return session.scalars(query.order_by(ConversationRow.opened_at, ConversationRow.robot)).all()

    def _read(self, session: Session, plan: PlanRow) -> Sequence[PartBids]:
        newest: dict[tuple[str, str], ConversationRow] = {}
        parts: dict[str, _Part] = {}
        for row in self._rows(session, plan):
            leg = leg_of(parse_term(row.said[0]["content"]), row.robot)
            newest[leg.id, row.robot] = row
            parts[leg.id] = _Part(packets=tuple(packet.tag for packet in leg.packets))
        for (part, _), row in newest.items():
            parts[part].bids.append(_bid(row))
        silent = {
            robot.name: reason
            for robot in self._worlds[plan.world].robots
            if (reason := self._speech.unheard_reason(plan.world, robot.name, BIDS))
        }
        for one in parts.values():
            one.bids += [RobotBid(robot=name, state=NO_SPEECH, reason=why) for name, why in silent.items()]
        return [_part_bids(robot, part) for robot, part in sorted(parts.items())]


def _part_bids(robot: str, part: _Part) -> PartBids:
    offers = [(bid.offer.cost_s, bid.robot) for bid in part.bids if bid.offer is not None]
    return PartBids(
        robot=robot,
        packets=part.packets,
        bids=sorted(part.bids, key=lambda bid: bid.robot),
        cheapest=min(offers)[1] if offers else None,
    )


def _bid(row: ConversationRow) -> RobotBid:
    offer, reason = offer_in(row)
    return RobotBid(robot=row.robot, state=row.state, offer=offer, reason=reason)
