"""Plans' problems as PDDL, for whoever would check or plan them with other means."""

from pydantic import BaseModel, Field

from app.core import Core
from app.plans.posing import Posing
from app.plans.reposing import plan_row, reposed
from planner.interchange.pddl import Form, Vocabulary, domain_text, problem_text


class PddlBody(BaseModel):
    """The planning problem of a plan's goal, as the world is now."""

    plan_id: str
    form: Form
    world_version: int = Field(description="of the facts it was made from")
    is_current: bool = Field(
        description="the plan is open to decision and solves it; else the world has gone on since it was made"
    )
    domain: str
    problem: str


class Exporting:
    """Writes the problems of plans as PDDL."""

    def __init__(self, core: Core, *, posing: Posing) -> None:
        self._core, self._posing = core, posing

    def pddl(self, plan_id: str, form: Form) -> PddlBody:
        """:raises NotFound: if there is no such plan.
        :raises Conflict: if its world does not run.
        """
        with self._core.database.read() as session:
            asked = reposed(session, plan_row(session, plan_id), self._posing, self._core)
        words = Vocabulary(self._core.knowledge_base, form)
        return PddlBody(
            plan_id=plan_id,
            form=form,
            world_version=asked.world_version,
            is_current=asked.is_current,
            domain=domain_text(words),
            problem=problem_text(words, asked.problem),
        )
