"""Explains plans: in a planning process, for what a robot is worth is told by planning without it."""

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import NotFound
from app.domain.explanation_document import ActionExplanationBody, ExplanationBody
from app.planning.current_problem import current_problem, plan_row
from app.planning.limits import PlanningLimits, PlanningWish
from app.planning.pool.pool import PlanningWorker, WorkerClosed
from app.planning.pool.process import Watch, WorkFailed
from app.planning.problem_builder import ProblemBuilder
from app.store import PlanRow
from planner import KnowledgeBase, Observer, PlanNet, PlanningEngine, PlanningProblem, PlanningRequest
from planner.explanation import Explanation, explain

PATIENCE_S = 10.0
"""What an explanation may take, trials included; without them it takes no time."""

AT_ONCE = 8
"""Explanations with trials at a time: each holds one of the threads that requests are answered in."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Asked:
    """The work of explaining; without an engine, without what it costs to do without a robot."""

    plan_net: PlanNet
    problem: PlanningProblem
    knowledge_base: KnowledgeBase
    request: PlanningRequest

    def __call__(self, engine: PlanningEngine | None, observer: Observer) -> Explanation:
        return explain(self.plan_net, self.problem, self.knowledge_base, engine, self.request, observer)


class Explanations:
    """Explains plans, each once.

    While a plan is open to decision and what it rests on is true, the explanation says what it costs to do without
    each robot, and is kept with the plan. Later that cannot be told any more, and is left out unless it was kept.
    """

    def __init__(
        self, core: Core, *, posing: ProblemBuilder, worker: PlanningWorker, limits: PlanningLimits
    ) -> None:
        self._core, self._posing, self._worker, self._limits = core, posing, worker, limits
        self._room = threading.BoundedSemaphore(AT_ONCE)

    def explanation(self, plan_id: str) -> ExplanationBody:
        """:raises NotFound: if there is no such plan."""
        with self._core.database.read() as session:
            plan = plan_row(session, plan_id)
            if plan.explanation is not None:
                return ExplanationBody.model_validate(plan.explanation)
            asked, is_current = self._asked(session, plan)
        explanation = self._tried(asked) if is_current else None
        body = ExplanationBody.of(
            explanation or asked(None, Observer()), self._core.knowledge_base, plan_id=plan_id
        )
        if explanation is not None:
            with self._core.database.write() as session:
                session.get_one(PlanRow, plan_id).explanation = body.model_dump(mode="json")
        return body

    def of_action(self, plan_id: str, action_id: str) -> ActionExplanationBody:
        """:raises NotFound: if there is no such plan, or it has no such action, naming those it has."""
        explained: Mapping[str, ActionExplanationBody] = {
            one.action: one for one in self.explanation(plan_id).actions
        }
        if action_id not in explained:
            raise NotFound(
                f"plan {plan_id} has no action {action_id!r}", code="unknown-action", choices=tuple(explained)
            )
        return explained[action_id]

    def _asked(self, session: Session, plan: PlanRow) -> tuple[_Asked, bool]:
        """What is to be explained, and whether the world is still as the plan takes it to be."""
        now = current_problem(session, plan, self._posing, self._core)
        wish = PlanningWish.from_json({**now.goal.limits, "time_limit_s": PATIENCE_S})
        asked = _Asked(
            plan_net=now.plan_net,
            problem=now.problem,
            knowledge_base=self._core.knowledge_base,
            request=self._limits.request(wish),
        )
        return asked, now.is_current

    def _tried(self, asked: _Asked) -> Explanation | None:
        """With robots tried to do without; None if the planning processes have no time for it."""
        if not self._room.acquire(blocking=False):
            return None
        try:
            explanation: Explanation = self._worker.do(asked, PATIENCE_S, _Patience())
        except (WorkFailed, WorkerClosed):
            return None
        finally:
            self._room.release()
        return explanation


class _Patience(Watch):
    """Whoever asks for an explanation does not wait for ever."""

    def __init__(self) -> None:
        self._give_up = time.monotonic() + 2 * PATIENCE_S

    def is_cancelled(self) -> bool:
        return time.monotonic() > self._give_up
