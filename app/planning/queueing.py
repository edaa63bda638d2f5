"""Puts planning jobs into their queues: large ones apart, each with a rank by its priority and its world's turn."""

from collections.abc import Mapping

from sqlalchemy.orm import Session

from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.planning.pool.waiting_line import Priority, is_large
from app.store import GoalRow
from app.workflows import LARGE_PLANNING, PLANNING, Queue, Workflows

SLOT_S = 1.0
"""The share of a world that others compete with: one job per slot."""
EPOCH_S = 1_767_225_600.0
"""The beginning of 2026: ranks count seconds from then on."""
RANKS = 500_000_000
"""Ranks of one priority: seconds until 2041."""


class PlanningQueues:
    """Queues planning jobs so that no world delays another's by more than a job per slot.

    A job's rank is the time at which its world's turn comes: now, but at least a slot after the turn of the world's
    last job (Zhang, "Virtual Clock", SIGCOMM 1990). Jobs run in the order of their ranks, as soon as there is room: a
    world that submits a hundred goals at once does not delay another's goal that comes later.
    """

    def __init__(self, workflows: Workflows, *, clock: WallClock = SYSTEM_CLOCK) -> None:
        self._workflows = workflows
        self._clock = clock
        self._turns_s: dict[tuple[Priority, str], float] = {}

    def put(
        self, session: Session, goal: GoalRow, priority: Priority, name: str, workflow_id: str, subject: str
    ) -> None:
        """Queue a job for the goal; it exists exactly if the caller's transaction commits.

        :param name: of the workflow.
        """
        self._workflows.start(
            session, queue_of(goal), name, workflow_id, subject, rank=self.rank(priority, goal.world)
        )

    def rank(self, priority: Priority, world: str) -> int:
        """The rank of the world's next job; lower ones run first."""
        now_s = self._clock.epoch_s()
        turn_s = max(now_s, self._turns_s.get((priority, world), 0.0) + SLOT_S)
        self._turns_s[priority, world] = turn_s
        within = min(max(int(turn_s - EPOCH_S), 1), RANKS - 1)
        return (priority - 1) * RANKS + within


def queue_of(goal: GoalRow) -> Queue:
    """Large problems have a queue of their own, so that small ones never wait for its room."""
    return LARGE_PLANNING if is_large_goal(goal) else PLANNING


def is_large_goal(goal: GoalRow) -> bool:
    """True if planning the goal may take long: by its number of goals, or by the effort requested with it."""
    limits: Mapping[str, float | None] = goal.limits
    return is_large(goals=len(goal.goal), effort_s=limits.get("effort_s"))
