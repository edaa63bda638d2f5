"""Writes plans' problems as PDDL, to be checked or planned with other tools."""

from pydantic import BaseModel, Field

from app.core import Core
from app.planning.problem_builder import ProblemBuilder
from app.planning.proposals import plan_row
from planner.interchange.pddl import Form, pddl_of


class PddlBody(BaseModel):
    """The planning problem of a plan's goal, as the world is now."""

    plan_id: str
    form: Form
    world_version: int = Field(description="of the facts it was made from")
    is_current: bool = Field(
        description="the plan is open to decision and solves it; false: the world has changed since it was made"
    )
    domain: str
    problem: str


class PlanExport:
    """Writes the problems of plans as PDDL."""

    def __init__(self, core: Core, *, problems: ProblemBuilder) -> None:
        self._database = core.database
        self._knowledge_base = core.knowledge_base
        self._problems = problems

    def pddl(self, plan_id: str, form: Form) -> PddlBody:
        """:raises NotFound: if there is no such plan.
        :raises Conflict: if its world does not run.
        """
        with self._database.read() as session:
            current = self._problems.current(session, plan_row(session, plan_id))
        domain, problem = pddl_of(self._knowledge_base, current.problem, form)
        return PddlBody(
            plan_id=plan_id,
            form=form,
            world_version=current.world_version,
            is_current=current.is_current,
            domain=domain,
            problem=problem,
        )
