"""What is planned to repair a mission's plan, or to plan what is left of it again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.lifecycles.recovery import troubles_of
from app.domain.plan_document import PlanBody
from app.domain.plan_edits import Pins, together
from app.domain.recovery_rules import LeftOut, has_failed_at
from app.domain.tender_document import TenderBody
from app.missions.mission_progress import progress_of
from app.planning.job import PlanningTask, ReplacedPlan
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.pool.work import RepairWork
from app.planning.problem_builder import ProblemBuilder
from app.planning.tenders import Tenders
from app.store import GoalRow, MissionRow, PlanRow, ScriptRow
from planner import KEPT_S, Fact
from planner.repair import KEPT_ON_REQUEST_S
from robots.clock import Clock


@dataclass(frozen=True, slots=True, kw_only=True)
class RepairTask(PlanningTask):
    """A repair to plan, and the robots and packets that it must do without; `tender`: with the legs awarded anew."""

    work: RepairWork
    replaces: ReplacedPlan
    left_out: LeftOut
    tender: TenderBody | None = None


class RepairTasks:
    """Builds the problem of a mission's next plan: what is left of its goals, from the state that its robots are in."""

    def __init__(
        self,
        core: Core,
        *,
        problems: ProblemBuilder,
        limits: PlanningLimits,
        clocks: Mapping[str, Clock],
        tenders: Tenders | None = None,
    ) -> None:
        """:param tenders: None: robots do not bid for goals."""
        self._knowledge_base = core.knowledge_base
        self._plan_nets = core.plan_nets
        self._problems = problems
        self._limits = limits
        self._clocks = clocks
        self._tenders = tenders

    def of(
        self,
        session: Session,
        mission: MissionRow,
        goal: GoalRow,
        *,
        without: LeftOut,
        failing: frozenset[str] = frozenset(),
        pins: Pins = (),
        joining: Sequence[str] = (),
        is_thorough: bool = False,
        runs_on: bool = False,
    ) -> RepairTask:
        """
        :param goal: the mission's own.
        :param without: what the mission must do without.
        :param failing: peripherals that it must do without, too.
        :param pins: beside what its present plan keeps to.
        :param joining: further goals that it is to be for, by id.
        :param is_thorough: see `planner.repair.repair`.
        :param runs_on: its robots go on, and what is under way is to end.
        """
        built = self._problems.build(session, goal, joining=joining).without({*without.robots, *failing})
        plan = session.get_one(PlanRow, mission.plan_id)
        body = PlanBody.model_validate(plan.body)
        net = self._plan_nets.of(session, plan.id)
        of_plan = (ScriptRow.mission_id == mission.id, ScriptRow.plan_id == mission.plan_id)
        scripts = session.scalars(select(ScriptRow).where(*of_plan)).all()
        now_s = self._clocks[mission.world].now_s()
        request = self._limits.request(PlanningWish.from_json(goal.limits))
        # legs at which robots have failed are awarded to the next best bids
        tender = body.tender and body.tender.reallocated(partial(has_failed_at, troubles_of(mission)))
        recruits: Mapping[Fact, frozenset[str]] = {}
        if tender is not None and self._tenders is not None:
            recruits = self._tenders.recruits(tender, mission.world, built)
        edits = together((*body.edits, *pins))
        built = self._problems.pinned(
            replace(built, problem=replace(built.problem, recruits=recruits)), edits
        )
        work = RepairWork(
            knowledge_base=self._knowledge_base,
            plan_net=net,
            problem=replace(built.problem, facts=without.remove_from(built.problem.facts)),
            request=request,
            progress=progress_of(mission, scripts, net, without=without.robots, now_s=now_s, runs_on=runs_on),
            is_thorough=is_thorough,
            stability_s=KEPT_ON_REQUEST_S if is_thorough and not pins else KEPT_S,
        )
        return RepairTask(
            problem=built,
            work=work,
            time_limit_s=request.time_limit_s,
            replaces=ReplacedPlan(plan_id=plan.id, plan_net=net, edits=edits),
            is_under_way=True,
            left_out=without,
            tender=tender,
        )
