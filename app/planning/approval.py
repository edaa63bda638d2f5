"""Operators' decisions on plans: approve or reject. A plan that the world has made stale expires instead."""

from collections.abc import Container, Iterator, Mapping, Sequence

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Conflict
from app.domain.events import (
    GoalCommitted,
    GoalWithdrawn,
    MissionPending,
    MissionRevised,
    PlanClosed,
    PlanDecided,
)
from app.domain.goal_language.constraints import UNCONSTRAINED
from app.domain.ids import new_id
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles import mission as mission_lifecycle
from app.domain.lifecycles import plan as plan_lifecycle
from app.domain.lifecycles import recovery
from app.domain.lifecycles.mission import MissionState
from app.domain.lifecycles.plan import PlanState
from app.domain.mission_organiser import Margin
from app.domain.plan_document import PlanBody
from app.domain.recovery_rules import TRIES
from app.domain.tender_document import Allocation
from app.domain.world_model import broken_support, planning_problem, taken_by
from app.domain.world_model.problem import batteries_of
from app.domain.world_model.senses import Perceives, restricted_senses, unsensed
from app.domain.world_model.timeliness import DatedFact, beliefs_contradicting
from app.domain.world_model.vocabulary import symbolic
from app.domain.world_model.zones import zones_against
from app.planning.proposals import WITHOUT_BODY, close_plans, open_plans, plan_row, read_bodies
from app.planning.requests import PlanningRequests
from app.planning.tenders import Tenders
from app.store import GoalRow, MissionRow, NumberRow, PlanRow
from app.store.durations import learned_durations
from app.store.records import lost_robots, page, robots_out_of_service
from app.store.roles import with_roles_in_force, withheld_tags
from app.store.standing_holds import standing_holds
from app.store.tables import utc_now
from app.workflows import MISSION_LIFE, MISSIONS
from planner import Fact, PlanNet, PlanningProblem, number_words
from planner.knowledge.comparison import Term
from planner.knowledge.expression import Functions
from planner.problem.number_courses import courses, why_outside
from robots.clock import Clock
from robots.wire import SymbolicFact
from robots.world import WorldFile

AUTOMATIC = "auto_approve"
"""The actor of decisions on plans whose goals were submitted with `auto_approve`."""
RECOVERY = "recovery"
"""The actor of decisions on repaired plans that need no operator's decision."""


class PlanApproval:
    """Reads plans and records decisions on them."""

    def __init__(
        self,
        core: Core,
        *,
        margin: Margin,
        requests: PlanningRequests,
        worlds: Mapping[str, WorldFile],
        clocks: Mapping[str, Clock],
        perceives: Perceives | None = None,
        tenders: Tenders | None = None,
    ) -> None:
        """
        :param worlds: their newest editions by name; likewise the clocks.
        :param perceives: what robots sense by their sensors that do not say what they sense; None: all.
        :param tenders: None: robots do not bid for goals.
        """
        self._database = core.database
        self._events = core.events
        self._workflows = core.workflows
        self._facts = core.facts
        self._plan_nets = core.plan_nets
        self._staleness = Staleness(core, worlds, perceives)
        self._margin = margin
        self._requests = requests
        self._clocks = clocks
        self._tenders = tenders

    def get(self, plan_id: str, *, without_body: Container[str] = ()) -> PlanRow:
        """:param without_body: plans whose bodies need not be read."""
        with self._database.read() as session:
            return plan_row(session, plan_id, with_body=plan_id not in without_body)

    def why_stale(self, plan: PlanRow) -> list[str]:
        """Why the proposed plan cannot be approved; approving it then has it repaired. Empty if it can be approved."""
        if plan.state != PlanState.PROPOSED:
            return []
        with self._database.read() as session:
            return self._staleness.of(session, plan, session.get_one(GoalRow, plan.goal_id))

    def start_of(self, plan: PlanRow) -> float | None:
        """When the plan starts by its world's clock: now, while it waits for a decision; else when a mission began it.

        None if its world does not run, or no mission has begun it, or one has replaced it.
        """
        if plan.state == PlanState.PROPOSED:
            return self._clocks[plan.world].now_s() if plan.world in self._clocks else None
        if plan.state != PlanState.APPROVED:
            return None
        begun = func.coalesce(MissionRow.revised_at_s, MissionRow.started_at_s)
        with self._database.read() as session:
            return session.scalar(select(begun).where(MissionRow.plan_id == plan.id))

    def newest(
        self,
        *,
        goal_id: str | None = None,
        state: str | None = None,
        limit: int = 100,
        after: str | None = None,
        without_body: Container[str] = (),
    ) -> tuple[Sequence[PlanRow], str | None]:
        """:param without_body: plans whose bodies need not be read."""
        with self._database.read() as session:
            rows, token = page(
                session,
                PlanRow,
                limit=limit,
                after=after,
                options=(WITHOUT_BODY,),
                goal_id=goal_id,
                state=state,
            )
            read_bodies(session, [row for row in rows if row.id not in without_body])
            return rows, token

    def approve(
        self, plan_id: str, *, actor: str, comment: str = "", delegate: bool = False
    ) -> tuple[PlanRow, str]:
        """Approve a plan and start its mission; approving it again returns the same mission's id.

        :param delegate: robots in the field may put legs to each other, of this plan and of the mission's later ones.
        :raises Conflict: if it is no longer proposed, or the world has changed since; in that case it is repaired.
        """
        with self._database.write() as session:
            plan, goal = _to_decide(session, plan_id)
            if plan.state == PlanState.APPROVED:
                return plan, _mission_of(session, plan)
            _refuse_decided(plan)
            mission_id = self.approve_or_expire(
                session, plan, goal, actor=actor, comment=comment, delegate=delegate
            )
        if mission_id is None:
            detail = f"the world has changed since the plan was made: {plan.reason}; it is being repaired"
            raise Conflict(detail, code="plan-stale")
        return plan, mission_id

    def approve_or_expire(
        self,
        session: Session,
        plan: PlanRow,
        goal: GoalRow,
        *,
        actor: str,
        comment: str,
        delegate: bool = False,
    ) -> str | None:
        """Approve inside the caller's transaction and return the mission's id.

        None if the plan is stale: then it expires, and a repaired one is planned in its place.
        """
        if goal.mission_id is not None:  # lock order: the mission before the world
            session.get_one(MissionRow, goal.mission_id, with_for_update=True)
        # If two processes approve plans for the same robots at once, the second sees the first one's mission.
        self._facts.lock(session, plan.world)
        stale = "; ".join(self._staleness.of(session, plan, goal))
        if not stale:
            return self._approve(session, plan, goal, actor=actor, comment=comment, delegate=delegate)
        plan_lifecycle.close(plan, PlanState.EXPIRED, stale)
        goal.plan_id = plan.id
        expired = PlanClosed(
            subject=plan.id, goal=goal.id, state=PlanState.EXPIRED, reason=stale, actor=actor
        )
        self._events.append(session, expired)
        close_plans(session, self._events, goal, PlanState.EXPIRED, "another plan of the goal is repaired")
        reason = f"the plan is out of date: {stale}"
        if goal.mission_id is None:
            self._requests.plan_again(session, goal, reason)
        else:
            self._requests.recover_again(session, goal, reason)
        return None

    def _approve(
        self, session: Session, plan: PlanRow, goal: GoalRow, *, actor: str, comment: str, delegate: bool
    ) -> str:
        self._decide(session, plan, PlanState.APPROVED, actor, comment, delegate=delegate)
        close_plans(
            session, self._events, goal, PlanState.SUPERSEDED, f"plan {plan.id} was approved", keep=plan.id
        )
        net = self._plan_nets.of(session, plan.id)
        margin_s = self._margin.of(net, learned_durations(session, plan.world), plan.world)
        mission_id = goal.mission_id or new_id("mission")
        is_repair = goal.mission_id is not None
        goal_lifecycle.commit(goal, plan_id=plan.id, mission_id=mission_id)
        self._events.append(session, GoalCommitted(subject=goal.id, plan=plan.id, mission=mission_id))
        if is_repair:
            self._revise(session, mission_id, plan, margin_s, delegate=delegate)
        else:
            self._start(session, mission_id, plan, goal, margin_s, delegate=delegate)
        if self._tenders is not None and goal.allocation == Allocation.CONTRACT_NET:
            session.flush()
            mission = session.get_one(MissionRow, mission_id)
            self._tenders.award(session, goal, mission, PlanBody.model_validate(plan.body).tender)
        return mission_id

    def _start(
        self,
        session: Session,
        mission_id: str,
        plan: PlanRow,
        goal: GoalRow,
        margin_s: float,
        *,
        delegate: bool,
    ) -> None:
        """Record the mission that carries out the plan, and start its workflow."""
        makespan_s = plan.body["makespan_s"]
        mission = MissionRow(
            id=mission_id,
            workflow=mission_id,
            goal_id=goal.id,
            plan_id=plan.id,
            world=plan.world,
            state=MissionState.PENDING,
            estimate_s=makespan_s,
            original_estimate_s=makespan_s,
            margin_s=margin_s,
            deadline_s=goal.deadline_at_s,
            recovery=goal.recovery,
            tries_left=TRIES,
            delegate=delegate,
        )
        session.add(mission)
        self._events.append(
            session,
            MissionPending(
                subject=mission.id,
                goal=goal.id,
                plan=plan.id,
                robots=tuple(plan.body["robots"]),
                state=MissionState.PENDING,
            ),
        )
        self._workflows.start(session, MISSIONS, MISSION_LIFE, mission.workflow, mission.id)

    def _revise(
        self, session: Session, mission_id: str, plan: PlanRow, margin_s: float, *, delegate: bool
    ) -> None:
        """Have the mission carry out its repaired plan: what is done stays done, its robots get new scripts.

        A paused mission's robots get them when it is resumed.
        """
        mission = session.get_one(MissionRow, mission_id, with_for_update=True)
        mission.plan_id = plan.id
        mission.margin_s = margin_s
        mission.revision += 1
        mission.delegate = mission.delegate or delegate
        recovery.approve(mission, plan.id)
        mission_lifecycle.dispatch(mission)
        self._events.append(
            session,
            MissionRevised(
                subject=mission.id,
                plan=plan.id,
                revision=mission.revision,
                state=MissionState(mission.state),
            ),
        )
        self._workflows.wake(session, mission.workflow)

    def reject(self, plan_id: str, *, actor: str, comment: str = "") -> PlanRow:
        """Reject a plan; its goal is withdrawn with its last open plan. Rejecting again changes nothing.

        If a repaired plan is rejected, its mission ends; its robots are safe. If an operator had asked for it, the
        mission goes on with what is left of the plan before.
        """
        with self._database.write() as session:
            plan, goal = _to_decide(session, plan_id)
            if plan.state == PlanState.REJECTED:
                return plan
            _refuse_decided(plan)
            self._decide(session, plan, PlanState.REJECTED, actor, comment)
            session.flush()
            if goal.mission_id is not None:
                self._reject_repair(session, goal.mission_id, plan, goal, comment)
                return plan
            if others := open_plans(session, goal.id):
                if goal.plan_id != others[0].id:
                    goal.plan_id = others[0].id
                    goal.alternatives = None  # a search under way compares with the rejected plan
                return plan
            reason = f"plan rejected: {comment}" if comment else "plan rejected"
            goal_lifecycle.withdraw(goal, outcome="plan_rejected", reason=reason)
            if self._tenders is not None:
                self._tenders.release(session, goal)
            self._events.append(session, GoalWithdrawn(subject=goal.id, actor=actor, reason=goal.reason))
            return plan

    def _reject_repair(
        self, session: Session, mission_id: str, plan: PlanRow, goal: GoalRow, comment: str
    ) -> None:
        """Record that the operator has rejected the repair; the mission ends, unless an operator had asked for it."""
        mission = session.get_one(MissionRow, mission_id, with_for_update=True)
        goal.plan_id = mission.plan_id
        remark = f": {comment}" if comment else ""
        if mission.replanning is not None:
            reason = f"the other plan was rejected{remark}"
            recovery.refuse_plan(mission, plan.id, reason)
            self._requests.recover(session, mission, (), failure=None, reason=reason)
            return
        recovery.reject(mission, plan.id, f"the repair was rejected{remark}")
        self._workflows.wake(session, mission.workflow)

    def _decide(
        self,
        session: Session,
        plan: PlanRow,
        state: PlanState,
        actor: str,
        comment: str,
        *,
        delegate: bool = False,
    ) -> None:
        plan_lifecycle.decide(plan, state, actor=actor, comment=comment, at=utc_now())
        self._events.append(
            session,
            PlanDecided(
                subject=plan.id,
                goal=plan.goal_id,
                state=state,
                actor=actor,
                comment=comment,
                delegate=delegate,
            ),
        )


def _to_decide(session: Session, plan_id: str) -> tuple[PlanRow, GoalRow]:
    """The plan and its goal, locked in the order goal, plan, so that no deadlock occurs."""
    plan = plan_row(session, plan_id)
    goal = session.get_one(GoalRow, plan.goal_id, with_for_update=True)
    session.refresh(plan, with_for_update=True)
    return plan, goal


def _mission_of(session: Session, plan: PlanRow) -> str:
    return session.scalars(select(MissionRow.id).where(MissionRow.goal_id == plan.goal_id)).one()


def _refuse_decided(plan: PlanRow) -> None:
    if plan.state != PlanState.PROPOSED:
        why = f": {plan.reason}" if plan.reason else ""
        raise Conflict(f"plan {plan.id} is {plan.state}, not proposed{why}", code="plan-decided")


class Staleness:
    """Compares plans that wait for a decision with the present world."""

    def __init__(
        self, core: Core, worlds: Mapping[str, WorldFile], perceives: Perceives | None = None
    ) -> None:
        self._worlds = worlds
        self._perceives = perceives
        self._facts = core.facts
        self._reservations = core.reservations
        self._plan_nets = core.plan_nets
        self._knowledge_base = core.knowledge_base

    def of(self, session: Session, plan: PlanRow, goal: GoalRow) -> list[str]:
        """Each condition of the plan that no longer holds, with what holds instead, in words; empty if all hold."""
        net = self._plan_nets.of(session, plan.id)
        false = broken_support(net, self._facts.supporting(session, plan.world))
        believed = self._facts.believed(session, plan.world) if false else ()
        numbers = {
            (row.quantity, tuple(row.args)): row
            for row in (self._facts.numbers.rows(session, plan.world) if false else ())
        }
        return [
            *(self._change(fact, believed, numbers) for fact in false),
            *self._against_zones(net, plan.world),
            *self._unsensed(net, plan.world),
            *self._withdrawn(session, net, plan.world),
            *self._taken(session, net, goal),
            *self._held(session, net, goal),
            *self._used_up(session, net, plan.world),
        ]

    def _change(self, fact: Fact, believed: Sequence[DatedFact], numbers: Mapping[Term, NumberRow]) -> str:
        if (comparison := self._knowledge_base.comparisons.get(fact.predicate)) is not None:
            row = numbers.get((comparison.quantity, fact.args))
            now = [f"it is {number_words(row.value)}, {row.source} at {row.at_s:.0f} s"] if row else []
            return ": ".join([f"{comparison.of(*fact.args)} is no longer true", *now])
        now = [
            f"{self._words(one.fact)}, {one.source} at {one.at_s:.0f} s"
            for one in beliefs_contradicting(fact, believed)
        ]
        return f"{self._words(fact)} is no longer true" + (f": now {' and '.join(now)}" if now else "")

    def _words(self, fact: Fact) -> str:
        return str(symbolic(fact, self._knowledge_base))

    def _against_zones(self, net: PlanNet, world: str) -> Iterator[str]:
        """Where the plan does not keep to a zone that was made since."""
        if world in self._worlds:
            yield from zones_against(net, self._worlds[world])

    def _unsensed(self, net: PlanNet, world: str) -> Iterator[str]:
        """What the plan relies on robots to sense that they do not sense any longer."""
        if world in self._worlds:
            senses = restricted_senses(self._worlds[world], self._knowledge_base, self._perceives)
            yield from unsensed(net, senses, self._knowledge_base)

    def _withdrawn(self, session: Session, net: PlanNet, world: str) -> Iterator[str]:
        for lost in lost_robots(session, world):
            if lost.robot in net.robots:
                yield f"{lost.robot} was declared lost"
        for row in robots_out_of_service(session, world):
            if row.robot in net.robots:
                yield f"{row.robot} was taken out of service: {row.reason}"
        limited = withheld_tags(session, self._worlds[world]) if world in self._worlds else {}
        for robot, tag in sorted({(one, action.tag) for action in net.actions for one in action.agents}):
            if robot in limited and tag in limited[robot][1]:
                yield f"{robot} plays {limited[robot][0].name} now, which is not recruited for {tag}"

    def _held(self, session: Session, net: PlanNet, goal: GoalRow) -> Iterator[str]:
        holds = standing_holds(session, goal.world) if goal.world in self._worlds else ()
        if not holds:
            return
        world = with_roles_in_force(session, self._worlds[goal.world])
        goals, _ = UNCONSTRAINED.of_goals([SymbolicFact.model_validate(one) for one in goal.goal], world)
        facts = self._facts.facts(session, goal.world)
        has_begun = goal.mission_id is not None
        for hold in holds:
            if hold.forbidden_to(goals, world, facts, has_begun=has_begun).broken_by(net):
                yield f"hold {hold.id} keeps {hold.words}"

    def _used_up(self, session: Session, net: PlanNet, world: str) -> Iterator[str]:
        """What would leave its limits by the numbers of now, such as a robot's battery."""
        if world in self._worlds:
            problem = PlanningProblem(
                objects={},
                facts=frozenset(),
                goals=(),
                functions=self._functions(session, world),
                numbers=self._facts.numbers.for_planner(session, world),
            )
            for course in courses(net, problem, self._knowledge_base):
                for point in list(course.outside())[:1]:
                    yield why_outside(course, point, net.actions, self._knowledge_base)

    def _functions(self, session: Session, world: str) -> Functions:
        """The values of the functions that say by how much numbers change."""
        functions = batteries_of(self._worlds[world])
        if self._knowledge_base.number_functions <= {name for name, _ in functions}:
            return functions
        facts = self._facts.facts(session, world)
        return planning_problem(self._worlds[world], facts, (), knowledge_base=self._knowledge_base).functions

    def _taken(self, session: Session, net: PlanNet, goal: GoalRow) -> Iterator[str]:
        needed = taken_by(net)
        for held in self._reservations.of_world(session, goal.world):
            if held.mission_id != goal.mission_id and needed.overlaps(held.reservation):
                shared = ", ".join(needed.shared(held.reservation))
                yield f"reserved by mission {held.mission_id}: {shared}"
