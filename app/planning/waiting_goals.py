"""Goals that wait: planned again one after the other, the most urgent first, when something becomes free."""

from collections.abc import Callable

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.ids import new_id
from app.domain.lifecycles.goal import GoalState
from app.store import GoalRow, WorldRow
from app.workflows import PLAN_WAITING, WAITING, step

TURNS = 25
"""After so many goals another workflow goes on with the world's."""


class WaitingGoals:
    """Has goals in `waiting` planned again when something of their world becomes free.

    What becomes free in a world is counted (`WorldRow.releases`). A goal stores the count it was last planned after,
    so that none is planned twice against the same world.
    """

    def __init__(self, core: Core) -> None:
        self._database, self._workflows = core.database, core.workflows
        self._rested: set[str] = set()

    def rested(self, world: str) -> None:
        """A robot of the world may be recruited again; told by whoever heard so, it counts at the next `look`."""
        self._rested.add(world)

    def look(self, world: str) -> None:
        """Release the world if a robot of it has rested meanwhile."""
        if world in self._rested:
            with self._database.write() as session:
                self.release(session, world)
            self._rested.discard(world)

    def release(self, session: Session, world: str) -> None:
        """Something of the world is free again; if the caller's transaction commits, goals that wait try anew."""
        _locked(session, world).releases += 1
        session.flush()
        if most_urgent(session, world) is not None:
            self._wake(session, world)

    def look_again(self, session: Session, goal: GoalRow) -> None:
        """The goal begins to wait; have it planned again if something became free while it was planned."""
        session.flush()
        # The lock keeps a release from coming between: it would not see that the goal waits, nor the goal it.
        if goal.releases_seen < _locked(session, goal.world).releases:
            self._wake(session, goal.world)

    def run(self, world: str, *, plan: Callable[[str], None]) -> None:
        """The workflow: plan the goals of a world that have not seen everything that became free."""
        for _ in range(TURNS):
            goal_id = step("next", lambda: self._next(world))
            if goal_id is None:
                return
            plan(goal_id)
        step("begin anew", lambda: self._begin_anew(world))

    def _next(self, world: str) -> str | None:
        with self._database.read() as session:
            return most_urgent(session, world)

    def _begin_anew(self, world: str) -> None:
        """Have another workflow go on: one that is taken over does its recorded steps again, so they must be few."""
        with self._database.write() as session:
            self._wake(session, world)

    def _wake(self, session: Session, world: str) -> None:
        self._workflows.start(session, WAITING, PLAN_WAITING, new_id("waiting"), world)


def _locked(session: Session, world: str) -> WorldRow:
    query = select(WorldRow).where(WorldRow.id == world).with_for_update()
    return session.scalars(query.execution_options(populate_existing=True)).one()


def _releases(session: Session, world: str) -> int:
    return session.scalars(select(WorldRow.releases).where(WorldRow.id == world)).one()


def most_urgent(session: Session, world: str) -> str | None:
    """The goal to plan next of those that wait and have not seen what became free: by priority, deadline, age."""
    query = (
        select(GoalRow.id)
        .where(
            GoalRow.world == world,
            GoalRow.state == GoalState.WAITING,
            GoalRow.releases_seen < _releases(session, world),
        )
        .order_by(
            GoalRow.priority.desc(),
            GoalRow.deadline_at_s.is_(None),
            GoalRow.deadline_at_s,
            GoalRow.created_at,
            GoalRow.id,
        )
        .limit(1)
    )
    return session.scalar(query)
