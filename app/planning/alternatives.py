"""Alternatives to a goal's proposed plan, and plans that operators edit: a durable workflow makes them, and any of them
may be approved."""

from collections.abc import Hashable, Sequence
from dataclasses import replace
from enum import StrEnum

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Conflict, unrecorded
from app.domain.events import (
    GoalAlternativesFailed,
    GoalAlternativesFound,
    GoalAlternativesSought,
    PlanClosed,
)
from app.domain.ids import new_id
from app.domain.lifecycles import plan as plan_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.plan import PlanState
from app.domain.plan_document import PlanBody
from app.domain.plan_edits import GoalPin, Pins, PlanEdit, together, words_of
from app.planning.job import PlanningJob, PlanningTask, ReplacedPlan
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.waiting_line import Priority
from app.planning.pool.work import AlternativesWork, EditWork, Solution, Solutions, WorkResult
from app.planning.problem_builder import GoalProblem, ProblemBuilder
from app.planning.proposals import Proposals, open_plans, plan_row
from app.planning.queueing import PlanningQueues
from app.store import GoalRow, PlanRow
from app.store.records import lock_goal
from app.workflows import FIND_ALTERNATIVES
from planner import PlanningRequest, PlanningResult, PlanningStatus
from planner.problem.choices import as_chosen_by, with_goals_of

EDIT_LIMIT_S = 10.0
"""Longest planning of an edited plan: an operator waits for it."""
FIRST = "proposed first"
"""The label of the proposed plan if it is best at nothing among the alternatives."""


class Search(StrEnum):
    """The state of the search for a goal's alternatives."""

    SEEKING = "seeking"
    """It is queued or under way."""
    FOUND = "found"
    """It has ended; the plans found are proposed."""
    FAILED = "failed"
    """It has ended without a plan; the reason says why."""


class Alternatives:
    """Starts the search for alternatives to a proposed plan, and reads a goal's plans for comparison."""

    def __init__(self, core: Core, *, problems: ProblemBuilder) -> None:
        self._problems = problems
        self._database = core.database
        self._events = core.events
        self._queues = PlanningQueues(core.workflows)

    def search(self, goal_id: str, count: int, *, actor: str) -> GoalRow:
        """Start the search for alternatives; while one is under way, asking again changes nothing.

        :raises Conflict: if the goal has no plan that is open to decision.
        """
        with self._database.write() as session:
            goal = lock_goal(session, goal_id)
            if goal.state != GoalState.PLANNED:
                raise Conflict(
                    f"goal {goal.id} is {goal.state}; only a plan that waits for a decision has alternatives",
                    code="no-open-plan",
                )
            if not _is_searched(goal):
                goal.alternatives = {"state": Search.SEEKING.value, "count": count, "reason": ""}
                goal.stop_requested = False
                self._events.append(
                    session, GoalAlternativesSought(subject=goal.id, actor=actor, count=count)
                )
                workflow_id = new_id("alternatives")
                self._queues.put(
                    session, goal, Priority.ALTERNATIVES, FIND_ALTERNATIVES, workflow_id, goal.id
                )
            return goal

    def edit(self, plan_id: str, edits: Sequence[PlanEdit], *, actor: str) -> GoalRow:
        """Have a proposed plan planned once more with something pinned; it stays open to decision beside the new one.

        What is pinned of it already stays pinned.

        :raises Conflict: if the plan is no longer open, its conditions no longer hold, or alternatives are being found.
        :raises Invalid: if an edit cannot be meant of this plan.
        """
        with self._database.write() as session:
            plan = plan_row(session, plan_id)
            goal = lock_goal(session, plan.goal_id)
            session.refresh(plan)
            if plan.state != PlanState.PROPOSED or goal.state != GoalState.PLANNED:
                raise Conflict(
                    f"plan {plan.id} is {plan.state} and its goal {goal.state}; only a plan that waits for a decision "
                    "can be edited",
                    code="no-open-plan",
                )
            if _is_searched(goal):
                raise Conflict(
                    f"alternatives to the plan of {goal.id} are being found; edit it once they are there",
                    code="alternatives-sought",
                )
            current = self._problems.current(session, plan, with_preferences=True)
            if not current.is_current:
                raise Conflict(
                    f"the world has changed since {plan.id} was made; approve it to have it repaired, then edit that",
                    code="plan-stale",
                )
            pins = self._problems.pins(edits, current.plan_net, current.problem, world=plan.world)
            pins = together((*PlanBody.model_validate(plan.body).edits, *pins))
            goal.alternatives = {
                "state": Search.SEEKING.value,
                "count": 1,
                "reason": "",
                "edited": plan.id,
                "pins": [pin.model_dump(mode="json") for pin in pins],
            }
            goal.stop_requested = False
            self._events.append(
                session, GoalAlternativesSought(subject=goal.id, actor=actor, count=1, edited=plan.id)
            )
            self._queues.put(session, goal, Priority.ALTERNATIVES, FIND_ALTERNATIVES, new_id("edit"), goal.id)
            return goal

    def plans(self, goal_id: str) -> Sequence[PlanRow]:
        """The goal's plans that are open to decision, shortest first; without one, the plan decided on."""
        with self._database.read() as session:
            goal = session.get(GoalRow, goal_id)
            if goal is None:
                raise unrecorded("goal", goal_id)
            rows = list(open_plans(session, goal_id))
            if not rows and goal.plan_id:
                rows = [session.get_one(PlanRow, goal.plan_id)]
        return sorted(rows, key=lambda row: float(row.body["makespan_s"]))


class AlternativesJob(PlanningJob[GoalRow, PlanningTask]):
    """Finds alternatives to a goal's proposed plan, or plans one of them once more as an operator has edited it."""

    step_name = "find alternatives"
    priority = Priority.ALTERNATIVES

    def __init__(
        self,
        core: Core,
        *,
        problems: ProblemBuilder,
        proposals: Proposals,
        worker: PlanningWorker,
        limits: PlanningLimits,
    ) -> None:
        super().__init__(core, worker=worker)
        self._problems = problems
        self._proposals = proposals
        self._limits = limits

    def load(self, session: Session, subject_id: str, *, lock: bool) -> GoalRow:
        return session.get_one(GoalRow, subject_id, with_for_update=lock or None)

    def attempt_key(self, subject: GoalRow) -> Hashable:
        return (
            (subject.plan_id, (subject.alternatives or {}).get("edited")) if _is_searched(subject) else None
        )

    def begin(self, session: Session, subject: GoalRow) -> PlanningTask | None:
        goal = subject
        if not _is_searched(goal):
            return None
        built = self._problems.build(session, goal)
        request = self._limits.request(PlanningWish.from_json(goal.limits))
        if edited := _edited(goal):
            return self._edit(session, built, request, *edited)
        body = PlanBody.model_validate(session.get_one(PlanRow, goal.plan_id).body)
        plan_net = body.to_plan_net(self._knowledge_base)
        problem = as_chosen_by(plan_net, built.problem)
        work = AlternativesWork(
            knowledge_base=self._knowledge_base,
            problem=problem,
            request=request,
            count=(goal.alternatives or {})["count"],
            proposed=PlanningResult(
                status=PlanningStatus.SOLVED,
                engine=body.engine,
                planning_s=body.planning_s,
                plan_net=plan_net,
                lower_bound_s=body.lower_bound_s,
                value=body.value,
                value_bound=body.value_bound,
                left_out=body.left_out_goals(self._knowledge_base),
                preferences=None if body.preferences is None else body.preferences.to_choice(),
            ),
            preferences=built.problem.preferences,
        )
        return PlanningTask(problem=built, work=work, time_limit_s=request.time_limit_s)

    def _edit(
        self, session: Session, built: GoalProblem, request: PlanningRequest, plan_id: str, pins: Pins
    ) -> PlanningTask:
        net = PlanBody.model_validate(session.get_one(PlanRow, plan_id).body).to_plan_net(
            self._knowledge_base
        )
        built = self._problems.pinned(replace(built, problem=with_goals_of(net, built.problem)), pins)
        work = EditWork(
            knowledge_base=self._knowledge_base,
            plan_net=net,
            problem=built.problem,
            request=replace(request, time_limit_s=min(request.time_limit_s, EDIT_LIMIT_S)),
        )
        replaces = ReplacedPlan(plan_id=plan_id, plan_net=net, edits=pins)
        return PlanningTask(
            problem=built, work=work, time_limit_s=work.request.time_limit_s, replaces=replaces
        )

    def conclude(
        self, session: Session, subject: GoalRow, task: PlanningTask, result: WorkResult[Solutions]
    ) -> None:
        edited = _edited(subject)
        if result.answer is None:
            why = f"{words_of(edited[1])}: {result.why}" if edited else result.why
            self._end(session, subject, Search.FAILED, why)
        elif edited and task.replaces is not None:
            self._record_edited(session, subject, result.answer[0], task.problem, task.replaces)
            self._end(session, subject, Search.FOUND, "")
        else:
            self._record(session, subject, result.answer, task.problem)
            self._end(session, subject, Search.FOUND, "")

    def give_up(self, session: Session, subject: GoalRow, reason: str) -> None:
        if _is_searched(subject):
            self._end(session, subject, Search.FAILED, reason)

    def _record_edited(
        self, session: Session, goal: GoalRow, solution: Solution, built: GoalProblem, edited: ReplacedPlan
    ) -> None:
        """Propose the edited plan beside the others."""
        repairs = edited.repaired_by(solution)
        plan = self._proposals.propose(session, goal, solution, built, repairs, edits=edited.edits)
        plan.label = words_of(edited.edits)
        plan.comparison = repairs.difference.words[0] if repairs and repairs.difference.words else ""
        first = session.get_one(PlanRow, goal.plan_id)
        first.label = first.label or FIRST

    def _record(self, session: Session, goal: GoalRow, found: Solutions, built: GoalProblem) -> None:
        """Propose the new plans and label all; earlier alternatives that were not found again are closed."""
        bodies = {row.id: PlanBody.model_validate(row.body) for row in open_plans(session, goal.id)}
        known = {
            plan_id: body.to_plan_net(self._knowledge_base)
            for plan_id, body in bodies.items()
            if not body.edits
        }
        outdated = set(known) - {goal.plan_id}
        session.get_one(PlanRow, goal.plan_id).label = FIRST
        for one in found:
            plan_id = next((row for row, net in known.items() if net == one.result.plan_net), None)
            if plan_id is None:
                plan = self._proposals.propose(session, goal, one, built)
            else:
                plan = session.get_one(PlanRow, plan_id)
                outdated.discard(plan_id)
            plan.label = one.label
            plan.comparison = one.comparison
        for plan_id in outdated:
            plan = session.get_one(PlanRow, plan_id)
            plan_lifecycle.close(plan, PlanState.SUPERSEDED, "newer alternatives were found")
            closed = PlanClosed(subject=plan.id, goal=goal.id, state=PlanState.SUPERSEDED, reason=plan.reason)
            self._events.append(session, closed)

    def _end(self, session: Session, goal: GoalRow, state: Search, reason: str) -> None:
        goal.alternatives = {**(goal.alternatives or {}), "state": state.value, "reason": reason}
        plans = tuple(plan.id for plan in open_plans(session, goal.id))
        ended = GoalAlternativesFound if state is Search.FOUND else GoalAlternativesFailed
        self._events.append(session, ended(subject=goal.id, plans=plans, reason=reason))


def _edited(goal: GoalRow) -> tuple[str, Pins] | None:
    """The plan that is being edited and what is pinned of it; None if alternatives are being found."""
    search = goal.alternatives or {}
    if search.get("edited") is None:
        return None
    return search["edited"], tuple(GoalPin.model_validate(pin) for pin in search["pins"])


def _is_searched(goal: GoalRow) -> bool:
    return goal.state == GoalState.PLANNED and (goal.alternatives or {}).get("state") == Search.SEEKING
