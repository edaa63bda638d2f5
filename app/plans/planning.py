"""A goal's planning as a durable workflow: plan it, propose the plan, or say why there is none."""

from collections.abc import Callable, Mapping, Sequence
from math import ceil

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.database import GoalRow, PlanRow
from app.durable import PLANNING, StepFailed, step
from app.goals.check import blocking, check_goals
from app.ids import new_id
from app.plan_body import PlanBody
from app.plans.active import Held, all_reserved, held_by_missions
from app.plans.worker import PlanningWorker
from app.states import GoalState, PlanState
from app.vocabulary import planner_fact
from app.world_model import objects_of, planning_problem
from planner import PlanningProblem, PlanningResult, PlanningStatus
from robots.clock import Clock
from robots.wire import SymbolicFact
from robots.world import WorldFile

WORKFLOW = "plan_goal"

Spots = Callable[[str], Mapping[str, tuple[float, float]]]
"""Where the open-floor places of a world's robots are, (x, y) in metres."""
Approve = Callable[[Session, PlanRow, GoalRow], object]


class Planning:
    """Plans goals one step each; a goal that must wait for a running mission is planned again when that ends."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        clocks: Mapping[str, Clock],
        spots: Spots,
        worker: PlanningWorker,
        time_limit_s: float,
        approve: Approve,
    ) -> None:
        """:param approve: approves a proposed plan at once, for goals that were submitted so."""
        self._database, self._events, self._workflows = core.database, core.events, core.workflows
        self._facts, self._knowledge_base = core.facts, core.knowledge_base
        self._worlds, self._clocks, self._spots = worlds, clocks, spots
        self._worker, self._time_limit_s, self._approve = worker, time_limit_s, approve

    def enqueue(self, session: Session, goal: GoalRow, reason: str = "") -> None:
        """Have the goal planned (again), if the caller's transaction commits."""
        goal.attempts += 1
        goal.state, goal.reason = GoalState.SUBMITTED, reason
        self._workflows.start(session, PLANNING, WORKFLOW, f"{goal.id}:{goal.attempts}", goal.id)

    def enqueue_waiting(self, session: Session, world: str) -> None:
        """Robots of the world are free again: plan the goals that wait, the most urgent first."""
        query = (
            select(GoalRow)
            .where(GoalRow.world == world, GoalRow.state == GoalState.SUBMITTED, GoalRow.reason != "")
            .order_by(GoalRow.priority.desc(), GoalRow.created_at)
        )
        for goal in session.scalars(query).all():
            self.enqueue(session, goal)

    def run(self, goal_id: str) -> None:
        """The workflow. A step that keeps failing ends the goal, so that it is not planned for ever."""
        try:
            step("plan", lambda: self._plan(goal_id))
        except StepFailed as failure:
            reason = str(failure)
            step("give up", lambda: self._give_up(goal_id, reason))

    def _give_up(self, goal_id: str, reason: str) -> None:
        with self._database.write() as session:
            goal = session.get_one(GoalRow, goal_id, with_for_update=True)
            if goal.state in (GoalState.SUBMITTED, GoalState.PLANNING):
                self._unsolvable(session, goal, PlanningStatus.FAILED, reason)

    def _unsolvable(self, session: Session, goal: GoalRow, status: PlanningStatus, reason: str) -> None:
        goal.state, goal.outcome, goal.reason = GoalState.UNSOLVABLE, status.value, reason
        self._events.append(session, "goal.unsolvable", goal.id, reason=reason, status=status.value)

    def _plan(self, goal_id: str) -> str:
        with self._database.write() as session:
            goal = session.get_one(GoalRow, goal_id, with_for_update=True)
            if goal.state not in (GoalState.SUBMITTED, GoalState.PLANNING):
                return goal.state
            goal.state, goal.reason = GoalState.PLANNING, ""
            self._events.append(session, "goal.planning", goal.id)
            held = held_by_missions(session, goal.world, self._knowledge_base)
            refusal, problem = self._problem(session, goal, held)
            version = self._facts.version(session, goal.world)
        result = refusal or self._worker.plan(problem, time_limit_s=self._time_limit_s)
        with self._database.write() as session:
            goal = session.get_one(GoalRow, goal_id, with_for_update=True)
            if goal.state == GoalState.PLANNING:
                self._conclude(session, goal, result, held, version)
            return goal.state

    def _problem(
        self, session: Session, goal: GoalRow, held: Sequence[Held]
    ) -> tuple[PlanningResult | None, PlanningProblem]:
        """The planning problem, and the refusal if the goal makes no sense in the world as it is by now."""
        world = self._worlds[goal.world]
        facts = self._facts.facts(session, goal.world)
        wanted = [SymbolicFact.model_validate(fact) for fact in goal.goal]
        objects = objects_of(world)
        goals = tuple(planner_fact(fact, self._knowledge_base, objects) for fact in wanted)
        problem = planning_problem(
            world, facts, goals, spots=self._spots(goal.world), reserved=all_reserved(held)
        )
        issues = blocking(check_goals(wanted, world, facts, self._knowledge_base))
        if not issues:
            return None, problem
        reason = "; ".join(issue.detail for issue in issues)
        return _refusal(reason), problem

    def _conclude(
        self, session: Session, goal: GoalRow, result: PlanningResult, held: Sequence[Held], version: int
    ) -> None:
        if result.plan_net is not None:
            self._propose(session, goal, result, version)
        elif held:
            waits_for = " and ".join(str(mission) for mission in held)
            goal.state, goal.reason = GoalState.SUBMITTED, f"waits for {waits_for}"
            self._events.append(session, "goal.waiting", goal.id, reason=goal.reason)
            if not held_by_missions(session, goal.world, self._knowledge_base):
                self.enqueue(session, goal)  # they ended while we planned
        else:
            self._unsolvable(session, goal, result.status, result.reason or result.status.value)

    def _propose(self, session: Session, goal: GoalRow, result: PlanningResult, version: int) -> None:
        plan_id = new_id("plan")
        body = PlanBody.of_result(
            result,
            self._knowledge_base,
            id=plan_id,
            goal_id=goal.id,
            world=goal.world,
            state=PlanState.PROPOSED,
            world_version=version,
        )
        if goal.deadline_at_s is not None:
            late_s = ceil(self._clocks[goal.world].now_s() + body.makespan_s - goal.deadline_at_s)
            goal.reason = f"the plan is expected to end {late_s} s after the deadline" if late_s > 0 else ""
        plan = PlanRow(
            id=plan_id,
            goal_id=goal.id,
            world=goal.world,
            state=PlanState.PROPOSED,
            body=body.model_dump(mode="json"),
            world_version=version,
        )
        session.add(plan)
        goal.state, goal.plan_id = GoalState.PLANNED, plan_id
        self._events.append(
            session,
            "plan.proposed",
            plan_id,
            goal=goal.id,
            makespan_s=body.makespan_s,
            robots=list(body.robots),
        )
        if goal.auto_approve:
            session.flush()
            self._approve(session, plan, goal)


def _refusal(reason: str) -> PlanningResult:
    return PlanningResult(
        status=PlanningStatus.UNSOLVABLE, engine="goal check", planning_s=0.0, reason=reason
    )
