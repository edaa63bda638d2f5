"""Plans waiting goals again, one after the other, the most urgent first, when something becomes free."""

from collections.abc import Callable

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.ids import new_id
from app.domain.lifecycles.goal import GoalState
from app.store import GoalRow, WorldRow
from app.workflows import PLAN_WAITING, WAITING, step

GOALS_PER_WORKFLOW = 25
"""After this many goals a new workflow continues: one that is resumed repeats its recorded steps, so they are few."""


class WaitingGoals:
    """Has goals in `waiting` planned again when something of their world becomes free.

    What becomes free in a world is counted (`WorldRow.releases`). A goal stores the count it was last planned after,
    so that none is planned twice against the same world.
    """

    def __init__(self, core: Core) -> None:
        self._database = core.database
        self._workflows = core.workflows
        self._rested: set[str] = set()

    def rested(self, world: str) -> None:
        """Note that a robot of the world may be recruited again; the next `look` acts on it."""
        self._rested.add(world)

    def look(self, world: str) -> None:
        """Plan the world's waiting goals again if a robot of it may be recruited again."""
        if world in self._rested:
            with self._database.write() as session:
                self.release(session, world)
            self._rested.discard(world)

    def release(self, session: Session, world: str) -> None:
        """Something of the world is free again: once the caller's transaction commits, waiting goals are planned."""
        _world_to_change(session, world).releases += 1
        session.flush()
        if most_urgent(session, world) is not None:
            self._wake(session, world)

    def look_again(self, session: Session, goal: GoalRow) -> None:
        """The goal begins to wait: have it planned again if something became free while it was planned."""
        session.flush()
        # Without the lock a release at the same time would not see the waiting goal, nor this the release.
        if goal.releases_seen < _world_to_change(session, goal.world).releases:
            self._wake(session, goal.world)

    def run(self, world: str, *, plan: Callable[[str], None]) -> None:
        """The workflow: plan the world's waiting goals that were last planned before something became free."""
        for _ in range(GOALS_PER_WORKFLOW):
            goal_id = step("next", lambda: self._next(world))
            if goal_id is None:
                return
            plan(goal_id)
        # The step's name is recorded with workflows that earlier versions have begun.
        step("begin anew", lambda: self._continue_as_new(world))

    def _next(self, world: str) -> str | None:
        with self._database.read() as session:
            return most_urgent(session, world)

    def _continue_as_new(self, world: str) -> None:
        with self._database.write() as session:
            self._wake(session, world)

    def _wake(self, session: Session, world: str) -> None:
        self._workflows.start(session, WAITING, PLAN_WAITING, new_id("waiting"), world)


def _world_to_change(session: Session, world: str) -> WorldRow:
    query = select(WorldRow).where(WorldRow.id == world).with_for_update()
    return session.scalars(query.execution_options(populate_existing=True)).one()


def _releases(session: Session, world: str) -> int:
    return session.scalars(select(WorldRow.releases).where(WorldRow.id == world)).one()


def most_urgent(session: Session, world: str) -> str | None:
    """The next waiting goal that was last planned before something became free: by priority, deadline, age."""
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
