"""Plans in the record: proposed to operators, read, and closed when they are no longer open to decision."""

from collections.abc import Mapping, Sequence
from math import ceil

from sqlalchemy import select
from sqlalchemy.orm import Session, defer
from sqlalchemy.orm.attributes import set_committed_value

from app.core import Core
from app.domain.errors import unrecorded
from app.domain.events import PlanClosed, PlanProposed
from app.domain.ids import new_id
from app.domain.lifecycles import plan as plan_lifecycle
from app.domain.lifecycles.plan import PlanState
from app.domain.plan_document import ForecastBody, PlanBody, RepairsBody
from app.domain.plan_edits import Pins, words_of
from app.domain.tender_document import TenderBody
from app.domain.world_model.vocabulary import symbolic
from app.planning.pool.work import Solution
from app.planning.problem_builder import GoalProblem
from app.store import GoalRow, PlanRow
from app.store.durations import key_of
from app.store.event_log import EventLog
from planner import GOAL, PlanningResult
from planner.repair import unkept_pins
from robots.clock import Clock


class BrokenConstraints(Exception):
    """Raised when an engine's plan does not keep a goal's constraints: a defect, not the operator's mistake."""


class Proposals:
    """Records solutions as proposed plans."""

    def __init__(self, core: Core, *, clocks: Mapping[str, Clock]) -> None:
        """:param clocks: the worlds' clocks by the world's name."""
        self._events = core.events
        self._knowledge_base = core.knowledge_base
        self._plan_nets = core.plan_nets
        self._clocks = clocks

    def propose(
        self,
        session: Session,
        goal: GoalRow,
        solution: Solution,
        built: GoalProblem,
        repairs: RepairsBody | None = None,
        *,
        tender: TenderBody | None = None,
        edits: Pins = (),
    ) -> PlanRow:
        """Record a solution as a proposed plan of the goal.

        :param built: the problem that it solves.
        :param repairs: the plan that it replaces, if it repairs one.
        :param tender: the bids that it was made by, if robots have bid.
        :param edits: what it was to keep to of operators' edits; what it does not keep is its reason.
        :raises ValueError: if the result is not a solution.
        :raises BrokenConstraints: if the plan breaks the goal's constraints.
        """
        result, forecast = solution.result, solution.forecast
        broken = () if result.plan_net is None else built.constraints.broken_by(result.plan_net)
        if broken:
            raise BrokenConstraints(f"the plan for {goal.id} breaks its constraints: {'; '.join(broken)}")
        kept = self._kept(edits, result, built)
        unkept = words_of(tuple(pin for pin in edits if pin not in kept))
        plan_id = new_id("plan")
        likely = None
        if forecast is not None:
            likely = ForecastBody.of(forecast, self._knowledge_base, made_at_s=round(built.built_at_s, 3))
        body = PlanBody.of_result(
            result,
            self._knowledge_base,
            id=plan_id,
            goal_id=goal.id,
            world=goal.world,
            state=PlanState.PROPOSED,
            world_version=built.world_version,
            repairs=repairs,
            tender=tender,
            forecast=likely,
            edits=kept,
        )
        plan = PlanRow(
            id=plan_id,
            goal_id=goal.id,
            world=goal.world,
            state=PlanState.PROPOSED,
            reason="; ".join(
                filter(
                    None,
                    (
                        self._lateness(goal, body),
                        _omissions(body),
                        _broken(body),
                        unkept and f"no longer keeps to the edit: {unkept}",
                    ),
                )
            ),
            body=body.model_dump(mode="json"),
            world_version=built.world_version,
            duration_factors={key_of(kind): factor for kind, factor in built.factors.items()},
        )
        session.add(plan)
        if result.plan_net is not None:
            self._plan_nets.keep(plan_id, result.plan_net)
        self._events.append(
            session,
            PlanProposed(
                subject=plan_id, goal=goal.id, makespan_s=body.makespan_s, robots=tuple(body.robots)
            ),
        )
        return plan

    def _kept(self, edits: Pins, result: PlanningResult, built: GoalProblem) -> Pins:
        """The operators' edits that the plan keeps."""
        if not edits or result.plan_net is None:
            return edits
        unkept = unkept_pins(result.plan_net, built.problem, self._knowledge_base)
        goals = {symbolic(goal, self._knowledge_base) for goal in unkept}
        return tuple(pin for pin in edits if pin.goal not in goals)

    def _lateness(self, goal: GoalRow, plan: PlanBody) -> str:
        """By how much the plan misses the goal's deadline if it starts now, in words; empty if it does not."""
        if goal.deadline_at_s is None:
            return ""
        ends_s = {action.id: action.earliest_end_s for action in plan.actions}
        achieved_s = max(
            (ends_s.get(link.producer, 0.0) for link in plan.causal_links if link.consumer == GOAL),
            default=0.0,
        )
        late_s = ceil(self._clocks[goal.world].now_s() + achieved_s - goal.deadline_at_s)
        return f"ends {late_s} s after the deadline" if late_s > 0 else ""


def _omissions(plan: PlanBody) -> str:
    """The optional goals that the plan leaves out, in words; empty if there are none."""
    left_out = ", ".join(f"{one.goal} ({one.reason})" for one in plan.left_out)
    return f"leaves out {left_out}" if left_out else ""


def _broken(plan: PlanBody) -> str:
    """The preferences that the plan breaks, in words; empty if there are none."""
    preferences = plan.preferences.outcomes if plan.preferences is not None else ()
    broken = ", ".join(f"“{one.preference}” ({one.reason})" for one in preferences if not one.kept)
    return f"does not keep {broken}" if broken else ""


WITHOUT_BODY = defer(PlanRow.body, raiseload=True)
"""Leaves out the body, by far the largest part of a plan."""


def plan_row(session: Session, plan_id: str, *, with_body: bool = True) -> PlanRow:
    """:raises NotFound: if there is no such plan."""
    plan = session.get(PlanRow, plan_id, options=() if with_body else (WITHOUT_BODY,))
    if plan is None:
        raise unrecorded("plan", plan_id)
    return plan


def read_bodies(session: Session, plans: Sequence[PlanRow]) -> None:
    """Read the bodies of plans that were read without."""
    rows = {plan.id: plan for plan in plans}
    query = select(PlanRow.id, PlanRow.body).where(PlanRow.id.in_(rows))
    for plan_id, body in session.execute(query) if rows else ():
        set_committed_value(rows[plan_id], PlanRow.body.key, body)


def open_plans(session: Session, goal_id: str) -> Sequence[PlanRow]:
    """The goal's plans that are open to decision, oldest first."""
    query = select(PlanRow).where(PlanRow.goal_id == goal_id, PlanRow.state == PlanState.PROPOSED)
    return session.scalars(query.order_by(PlanRow.created_at, PlanRow.id)).all()


def close_plans(
    session: Session, events: EventLog, goal: GoalRow, state: PlanState, reason: str, *, keep: str = ""
) -> None:
    """Close the goal's open plans except the one to keep; the search for alternatives ends."""
    goal.alternatives = None
    for plan in open_plans(session, goal.id):
        if plan.id != keep:
            plan_lifecycle.close(plan, state, reason)
            events.append(session, PlanClosed(subject=plan.id, goal=goal.id, state=state, reason=reason))
