"""Goals whose robots are chosen by contract net (FIPA SC00029): legs put to tender, awards, and what becomes of them.

MACTA §4: planning may communicate with agents. A first plan names the legs; every robot that speaks bids is called for
each; the bids say who is recruited for which goal when it is planned again. All of it is in the database: the
conversations, the goal's tender, and the job that plans once all have answered, so a restart loses nothing.
"""

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import inf

from sqlalchemy import ColumnElement, select
from sqlalchemy.orm import Session

from app.agents.speech import SpeechService, in_order
from app.core import Core
from app.domain.blockers import Blockers
from app.domain.errors import Conflict
from app.domain.events import GoalBidsCalled
from app.domain.ids import new_id
from app.domain.lifecycles import tender as tender_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.script import script_id
from app.domain.lifecycles.tender import TenderState
from app.domain.plan_document import PlanBody
from app.domain.tender_document import (
    BidBody,
    BidState,
    LegBody,
    OfferBody,
    PartBody,
    Postponement,
    TenderBody,
)
from app.domain.world_model.beliefs import CAN
from app.domain.world_model.vocabulary import planner_fact, symbolic
from app.planning.leg_calls import LegCalls, call_content, declining_in, offer_in
from app.planning.problem_builder import GoalProblem
from app.planning.proposals import plan_row
from app.planning.requests import PlanningRequests
from app.store import ConversationRow, GoalRow, MissionRow
from planner import Fact, PlanNet, PlanningProblem
from planner.explanation.legs import PlanLeg, legs_in
from robots.clock import Clock
from robots.social import Term, parse_term
from robots.social.legs import AWARD, REJECT
from robots.social.protocols import ContractNetState
from robots.wire import BehaviourPacket, Performative
from robots.world import WorldFile

OPENER = "tenders"
AGAIN = "awards"
"""The opener of calls for legs that the caller has decided on: their bids are accepted at once."""
MOST_CALLS = 2000
"""Calls of one tender; goals whose plans ask for more are planned without (our choice)."""
LEAST_PATIENCE_S = 30.0
"""How long a goal waits for a busy bidder at the longest, if its bid says that it is free soon (our choice)."""
CALLED_AGAIN_S = 60.0
"""World seconds after which robots that have declined for a passing reason are called again (our choice)."""
LAST_WORD_S = 5.0
"""How long after a mission's end its robots have to say how their legs have ended (wall clock)."""


class Tenders:
    """Puts legs to tender, awards them, and has goals planned with the awards."""

    def __init__(
        self,
        core: Core,
        *,
        speech: SpeechService,
        worlds: Mapping[str, WorldFile],
        clocks: Mapping[str, Clock],
        calls: LegCalls,
        requests: PlanningRequests,
    ) -> None:
        self._core = core
        self._clocks = clocks
        self._speech = speech
        self._worlds = worlds
        self._calls = calls
        self._requests = requests
        speech.listen(OPENER, self._answered)
        speech.listen(AGAIN, self._award_at_once)

    def call(self, session: Session, goal: GoalRow, net: PlanNet, built: GoalProblem) -> TenderBody:
        """Call all robots of the goal's world for the legs of its first plan; nobody, if there is nothing to award."""
        legs = self._legs(net, built)
        tender = TenderBody(
            attempt=goal.attempts, waits_until_s=_waits_until_s(goal), makespan_s=net.makespan_s
        )
        calls = sum(len(leg.team) for leg in legs) * len(self._worlds[goal.world].robots)
        if calls > MOST_CALLS:
            why = f"its legs would take {calls} calls, of which {MOST_CALLS} are made at most"
            tender_lifecycle.plan_centrally(tender, why)
            return tender
        try:
            packets = self._packets(session, net, goal.world)
            contents = [
                {
                    planned: self._contents(
                        f"leg_{number}",
                        planned,
                        [packets[planned, action.id] for action in actions],
                        goal.world,
                    )
                    for planned, actions in leg.actions.items()
                }
                for number, leg in enumerate(legs, start=1)
            ]
        except Conflict as conflict:
            tender_lifecycle.plan_centrally(tender, conflict.detail)
            return tender
        called: dict[str, None] = {}
        bodies = []
        for number, (leg, of_leg) in enumerate(zip(legs, contents, strict=True), start=1):
            parts = []
            for planned, actions in leg.actions.items():
                part = PartBody(
                    robot=planned,
                    tags=tuple(action.tag for action in actions),
                    conversation=new_id("call"),
                )
                heard = self._calls.call(
                    session,
                    of_leg[planned],
                    world=goal.world,
                    opener=OPENER,
                    about=goal.id,
                    conversation_id=part.conversation,
                )
                called.update(dict.fromkeys(heard))
                parts.append(part)
            of = symbolic(leg.goal, self._core.knowledge_base)
            bodies.append(LegBody(id=f"leg_{number}", goal=of, parts=tuple(parts)))
        tender.legs = tuple(bodies)
        if not called:
            why = (
                "no robot of the world takes calls"
                if legs
                else "the plan has no leg that another robot could do"
            )
            tender_lifecycle.plan_centrally(tender, why)
            return tender
        event = GoalBidsCalled(
            subject=goal.id, robots=tuple(called), legs=tuple(leg.id for leg in tender.legs)
        )
        self._core.events.append(session, event)
        return tender

    def is_answered(self, session: Session, goal: GoalRow) -> bool:
        """True once every called robot has bid, declined or let its time pass."""
        unanswered = select(ConversationRow.id).where(
            *_of_goal(goal), ConversationRow.state != ContractNetState.PROPOSED
        )
        return session.scalar(unanswered.limit(1)) is None

    def close(
        self, session: Session, goal: GoalRow, built: GoalProblem
    ) -> tuple[TenderBody, Blockers | None]:
        """The tender with what was bid and the awards; or postponed, and the missions for which its goal waits, as busy
        robots are worth that.
        """
        tender = tender_of(goal)
        assert tender is not None
        bids = {
            part.conversation: self._bids(session, goal.world, part, built)
            for leg in tender.legs
            for part in leg.parts
        }
        tender = tender.with_bids(bids)
        if (postponed := self._postponement(goal, tender)) is not None:
            return tender, self._postpone(goal, tender, postponed, built)
        if not tender.has_bids and not _some_decline(tender):
            heard = [bid for leg in tender.legs for part in leg.parts for bid in part.bids]
            why = "no robot has answered the calls in time"
            if any(bid.offer is not None for bid in heard):
                why = "planning recruits none of those that have bid"
            tender_lifecycle.plan_centrally(tender, why)
            return tender, None
        tender = tender.allocated()
        tender_lifecycle.award(tender)
        return tender, None

    def _postponement(self, goal: GoalRow, tender: TenderBody) -> Postponement | None:
        """The busy robots that are worth waiting for; none so long that the first plan would miss the deadline."""
        now_s = self._clocks[goal.world].now_s()
        impatient = {robot for robot, until_s in tender.waits_until_s.items() if until_s <= now_s}
        within_s = inf
        if goal.deadline_at_s is not None:
            within_s = goal.deadline_at_s - now_s - tender.makespan_s
        return tender.postponement(impatient=impatient, within_s=within_s)

    def _postpone(
        self, goal: GoalRow, tender: TenderBody, postponed: Postponement, built: GoalProblem
    ) -> Blockers:
        """Postpone the tender; the missions that need its best bidders."""
        now_s = self._clocks[goal.world].now_s()
        new_s = {robot: now_s + _patience_s(release_s) for robot, release_s in postponed.robots.items()}
        tender.waits_until_s = {**new_s, **tender.waits_until_s}
        tender_lifecycle.postpone(tender, str(postponed))
        missions = tuple(
            f"{mission}: {tender.reason}"
            for mission, reserved in built.withheld.missions.items()
            if not reserved.robots.isdisjoint(postponed.robots)
        )
        until_s = max(tender.waits_until_s[robot] for robot in postponed.robots)
        if goal.deadline_at_s is not None:
            until_s = min(until_s, goal.deadline_at_s - tender.makespan_s)
        return Blockers(missions=missions, until_s=until_s)

    def passing(self, tender: TenderBody, world: str) -> Blockers | None:
        """The robots that decline for reasons that may pass; None if there are none.

        They are called again after `CALLED_AGAIN_S` at the latest: that a robot has put something down is no release.
        """
        robots = tender.passing
        until_s = self._clocks[world].now_s() + CALLED_AGAIN_S
        return replace(robots, until_s=until_s) if robots else None

    def recruits(self, tender: TenderBody, world: str, built: GoalProblem) -> Mapping[Fact, frozenset[str]]:
        """By goal, who may be recruited for it."""
        base = self._core.knowledge_base
        objects = built.problem.objects
        robots = self._worlds[world].robots_by_name
        return {planner_fact(goal, base, objects): those for goal, those in tender.recruits(robots).items()}

    def planned(self, tender: TenderBody, net: PlanNet, built: GoalProblem) -> TenderBody:
        """The tender with which of its awards the plan keeps."""
        teams: dict[Fact, set[str]] = {}
        for leg in self._legs(net, built):
            teams.setdefault(leg.goal, set()).update(leg.team)
        base = self._core.knowledge_base
        return tender.as_planned({symbolic(goal, base): frozenset(team) for goal, team in teams.items()})

    def release(self, session: Session, goal: GoalRow, *, beside: Collection[tuple[str, str]] = ()) -> None:
        """Reject all open bids for the goal's legs, and give up the calls that are not answered.

        :param beside: the conversations, and the robots in them, to leave alone.
        """
        self._core.facts.lock(session, goal.world)
        query = in_order(select(ConversationRow).where(*_of_goal(goal)))
        for row in session.scalars(query.with_for_update()):
            if (row.id, row.robot) in beside:
                continue
            if row.state == ContractNetState.PROPOSED:
                self._speech.say(session, row, Performative.REJECT_PROPOSAL, Term(REJECT, (_leg_of(row),)))
            else:
                self._speech.cancel(row, "the goal no longer needs bids")

    def award(self, session: Session, goal: GoalRow, mission: MissionRow, tender: TenderBody | None) -> None:
        """Accept the winners' bids with the scripts by which they are to do the legs, and reject the others.

        A plan that replaces another has new scripts: its legs' robots are called again, and each bid is accepted.
        """
        self._core.facts.lock(session, goal.world)
        legs = () if tender is None else [leg for leg in tender.legs if leg.is_planned]
        if mission.revision > 1:
            self._award_again(session, mission, legs)
            return
        won = {
            (part.conversation, robot): leg
            for leg in legs
            for part, robot in zip(leg.parts, leg.team, strict=True)
        }
        for (conversation, robot), leg in sorted(won.items(), key=lambda one: one[0]):
            row = session.get(ConversationRow, (conversation, robot), with_for_update=True)
            if row is not None and row.state == ContractNetState.PROPOSED:
                row.about = mission.id
                self._accept(session, row, leg.id, mission)
        self.release(session, goal, beside=won)

    def settle(self, session: Session, mission: MissionRow) -> None:
        """Have robots that have not said how their legs have ended say it: their answer may have been lost."""
        for row in self._awarded(session, mission.id):
            self._speech.ask_again(row, wall_s=LAST_WORD_S)

    def of_plan(self, plan_id: str) -> TenderBody:
        """The plan's tender, with what has become of the bids.

        :raises Conflict: if its goal was not put to tender.
        """
        with self._core.database.read() as session:
            plan = plan_row(session, plan_id)
            tender = PlanBody.model_validate(plan.body).tender
            if tender is None:
                detail = f"the robots of plan {plan_id} were chosen by planning alone; its goal was not put to tender"
                raise Conflict(detail, code="not-tendered")
            query = select(ConversationRow.id, ConversationRow.robot, ConversationRow.state)
            rows = session.execute(query.where(ConversationRow.id.in_(tender.conversations)))
            states = {(conversation, robot): state for conversation, robot, state in rows}
        return tender.with_bids(
            {
                part.conversation: [
                    bid.model_copy(update={"outcome": states.get((part.conversation, bid.robot), "")})
                    for bid in part.bids
                ]
                for leg in tender.legs
                for part in leg.parts
            }
        )

    def _legs(self, net: PlanNet, built: GoalProblem) -> Sequence[PlanLeg]:
        """The legs that other robots could do: a robot that its goal names has no rivals."""
        legs = legs_in(net, built.problem, self._core.knowledge_base)
        return [leg for leg in legs if not set(leg.team).intersection(leg.goal.args)]

    def _packets(
        self, session: Session, net: PlanNet, world: str
    ) -> Mapping[tuple[str, str], BehaviourPacket]:
        """By robot and action."""
        scripts = self._calls.scripts(session, net, self._worlds[world])
        return {(script.robot, packet.id): packet for script in scripts for packet in script.packets}

    def _contents(
        self, leg: str, planned: str, packets: Sequence[BehaviourPacket], world: str
    ) -> Mapping[str, Term]:
        """By robot of the world, the call for what `planned` does of a leg."""
        names = [robot.name for robot in self._worlds[world].robots]
        return {name: call_content(leg, name, planned, packets) for name in names}

    def _answered(self, session: Session, row: ConversationRow) -> None:
        """Have the goal planned once all have answered."""
        goal = session.get(GoalRow, row.about)
        if goal is None or goal.state != GoalState.PLANNING or not _is_called_in(row.id, goal):
            if row.state == ContractNetState.PROPOSED:
                self._speech.say(session, row, Performative.REJECT_PROPOSAL, Term(REJECT, (_leg_of(row),)))
            return
        self._speech.take_time(row)
        session.flush()
        # Of two last answers at once one would not see the other.
        self._core.database.lock(session, f"tender {goal.id}")
        if self.is_answered(session, goal):
            self._requests.plan_with_bids(session, goal)

    def _bids(self, session: Session, world: str, part: PartBody, built: GoalProblem) -> Sequence[BidBody]:
        rows = {
            row.robot: row
            for row in session.scalars(select(ConversationRow).where(ConversationRow.id == part.conversation))
        }
        return [
            _bid(robot.name, rows.get(robot.name), *self._standing(robot.name, part, built))
            for robot in self._worlds[world].robots
        ]

    def _standing(self, robot: str, part: PartBody, built: GoalProblem) -> tuple[BidState, str]:
        """What the robot's bid for the part counts, and why it is not awarded; empty if it may be."""
        if _abilities(robot, built.problem).issuperset(part.tags):
            return BidState.OFFERED, ""
        if (unavailable := built.withheld.robots.get(robot)) is not None:
            return BidState.WITHHELD, unavailable
        if _abilities(robot, built.withheld.whole).issuperset(part.tags):
            needs = [mission for mission, held in built.withheld.missions.items() if robot in held.robots]
            needs += [hold for hold, kept in built.withheld.holds.items() if robot in kept.excluded]
            return BidState.BUSY, " and ".join(needs)
        return BidState.WITHHELD, "its repertoire or a constraint stands against it"

    def _accept(self, session: Session, row: ConversationRow, leg: str, mission: MissionRow) -> None:
        award = Term(AWARD, (leg, script_id(mission.id, row.robot, mission.revision)))
        self._speech.say(session, row, Performative.ACCEPT_PROPOSAL, award)

    def _award_again(self, session: Session, mission: MissionRow, legs: Sequence[LegBody]) -> None:
        """Call the robots of a repaired plan's legs; the awards of the plan before end with its scripts."""
        for row in self._awarded(session, mission.id):
            self._speech.cancel(row, "a repaired plan has taken the place of its script")
        net = self._core.plan_nets.of(session, mission.plan_id)
        with suppress(Conflict):  # a leg that is too long for a call is done without an award
            self._call_again(session, mission, legs, net)

    def _call_again(
        self, session: Session, mission: MissionRow, legs: Sequence[LegBody], net: PlanNet
    ) -> None:
        scripts = {one.robot: one for one in self._calls.scripts(session, net, self._worlds[mission.world])}
        for leg in legs:
            for robot in leg.team:
                script = scripts.get(robot)
                mine = [] if script is None else _about(script.packets, leg.goal.args)
                if mine:
                    self._calls.call(
                        session,
                        {robot: call_content(leg.id, robot, robot, mine)},
                        world=mission.world,
                        opener=AGAIN,
                        about=mission.id,
                        conversation_id=new_id("call"),
                    )

    def _award_at_once(self, session: Session, row: ConversationRow) -> None:
        mission = session.get(MissionRow, row.about)
        if row.is_over or row.state != ContractNetState.PROPOSED:
            return
        if mission is None or mission.ended_at_s is not None:
            self._speech.say(session, row, Performative.REJECT_PROPOSAL, Term(REJECT, (_leg_of(row),)))
            return
        self._accept(session, row, _leg_of(row), mission)
        self._speech.take_time(row)

    def _awarded(self, session: Session, mission_id: str) -> Sequence[ConversationRow]:
        query = select(ConversationRow).where(
            ConversationRow.about == mission_id,
            ConversationRow.opener.in_((OPENER, AGAIN)),
            ConversationRow.is_over.is_(False),
        )
        return session.scalars(in_order(query).with_for_update()).all()


def tender_of(goal: GoalRow) -> TenderBody | None:
    """The goal's tender; None if it has none, one of an earlier attempt, or one that was postponed."""
    if goal.tender is None:
        return None
    tender = TenderBody.model_validate(goal.tender)
    is_current = tender.attempt == goal.attempts and tender.state != TenderState.POSTPONED
    return tender if is_current else None


def _some_decline(tender: TenderBody) -> bool:
    return any(
        bid.state is BidState.DECLINED for leg in tender.legs for part in leg.parts for bid in part.bids
    )


def _of_goal(goal: GoalRow) -> tuple[ColumnElement[bool], ...]:
    """The open conversations with those who were called for the goal's legs."""
    return (
        ConversationRow.world == goal.world,
        ConversationRow.is_over.is_(False),
        ConversationRow.about == goal.id,
        ConversationRow.opener == OPENER,
    )


def _is_called_in(conversation: str, goal: GoalRow) -> bool:
    """True if the conversation belongs to the goal's open tender.

    Read from the document itself: with many calls, checking it whole for each answer takes most of the time.
    """
    tender = goal.tender
    if tender is None or tender["attempt"] != goal.attempts or tender["state"] != TenderState.CALLED:
        return False
    return any(part["conversation"] == conversation for leg in tender["legs"] for part in leg["parts"])


def _waits_until_s(goal: GoalRow) -> Mapping[str, float]:
    """What the goal's postponed tender of the same attempt says of the robots that it waits for; {} if it has none."""
    tender = None if goal.tender is None else TenderBody.model_validate(goal.tender)
    return {} if tender is None or tender.attempt != goal.attempts else tender.waits_until_s


def _patience_s(release_s: float) -> float:
    """How long a busy robot is waited for: half as long again as it bids at most, or `LEAST_PATIENCE_S`."""
    return max(LEAST_PATIENCE_S, 1.5 * release_s)


def _abilities(robot: str, problem: PlanningProblem) -> frozenset[str]:
    """The tags of the packets for which the problem has the robot."""
    return frozenset(
        fact.args[1] for fact in problem.facts if fact.predicate == CAN and fact.args[0] == robot
    )


def _bid(robot: str, row: ConversationRow | None, standing: BidState, why: str) -> BidBody:
    """:param standing: of its offer, if it makes one. :param why: not awarded."""
    if row is None:
        return BidBody(robot=robot, state=BidState.UNCALLED, reason="it does not speak bids")
    offer, reason = offer_in(row)
    if offer is None:
        if row.state == ContractNetState.REFUSED:
            declining = declining_in(row)
            return BidBody(robot=robot, state=BidState.DECLINED, reason=reason, declining=declining)
        return BidBody(robot=robot, state=BidState.SILENT, reason=reason)
    made = OfferBody.model_validate(offer)
    return BidBody(robot=robot, state=standing, offer=made, reason=why)


def _leg_of(row: ConversationRow) -> str:
    """The leg that the robot was called for."""
    return parse_term(row.said[0]["content"]).words[0]


def _about(packets: Sequence[BehaviourPacket], things: Collection[str]) -> list[BehaviourPacket]:
    """The packets that handle one of the things."""
    return [packet for packet in packets if not set(things).isdisjoint(packet.arguments.values())]
