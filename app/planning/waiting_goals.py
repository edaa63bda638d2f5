"""Plans waiting goals again, one after the other, the most urgent first, when something becomes free."""

from collections.abc import Callable, Collection, Mapping
from threading import Lock

from sqlalchemy import Select, bindparam, select
from sqlalchemy.orm import Session, aliased

from app.core import Core
from app.domain.blockers import Blockers
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.events import GoalWaiting
from app.domain.ids import new_id
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import OPEN
from app.domain.lifecycles.recovery import RecoveryStep, note_blockers, waits_for
from app.store import GoalRow, MissionRow, WorldRow
from app.store.event_log import EventLog
from app.store.world_summary import summary_of
from app.workflows import PLAN_WAITING, WAITING, StepFailed, current_workflow, step
from robots.clock import Clock

STATED_BY = "waiting_goals"
"""Who submits the goals that the service states for several that wait."""
LOOK_S = 5.0
"""Wall-clock seconds between two looks at goals that have waited as long as they are to."""
NEVER_PLANNED = -1
"""In place of the count of releases at a goal's last planning: it is to be planned whatever has been released."""
GOALS_PER_WORKFLOW = 25
"""Goals after which a new workflow continues, so that the waiting goals of other worlds have their turn."""


def have_wait(session: Session, events: EventLog, goal: GoalRow, blockers: Blockers) -> None:
    """Have a goal wait for these blockers, with an event if it does not wait for them already."""
    before = goal.waits_for
    goal_lifecycle.wait_for(goal, blockers)
    if goal.waits_for != before:
        events.append(session, GoalWaiting(subject=goal.id, reason=goal.reason))


def _by_themselves(world: str) -> None:
    """Plan no goals together."""


class WaitingGoals:
    """Has goals in `waiting` planned again when something in their world becomes free.

    Releases in a world are counted (`WorldRow.releases`). A goal stores the count at its last planning, so that it is
    planned again only after another release. The end of the time for which a goal waits (`Blockers.until_s`) counts as
    one.
    """

    def __init__(
        self, core: Core, *, clocks: Mapping[str, Clock], wall_clock: WallClock = SYSTEM_CLOCK
    ) -> None:
        """:param clocks: the worlds' clocks by the world's name."""
        self._clocks = clocks
        self._wall_clock = wall_clock
        self._looked_at_s: dict[str, float] = {}
        self._database = core.database
        self._events = core.events
        self._facts = core.facts
        self._workflows = core.workflows
        self._has_available: set[str] = set()
        self._new_reasons: dict[tuple[str, str], str] = {}
        self._lock = Lock()

    def robot_available(self, world: str) -> None:
        """Note that a robot of the world may be recruited again, for the next `handle_availability`."""
        with self._lock:
            self._has_available.add(world)

    def unavailability_changed(self, world: str, robot: str, why: str) -> None:
        """Note the new reason why a robot is not recruited, for the next `handle_availability`."""
        with self._lock:
            self._new_reasons[world, robot] = why

    def handle_availability(self, world: str) -> None:
        """Plan waiting goals again if a robot of the world became available, or one has waited as long as it is to;
        update the reasons of waiting ones.
        """
        self._end_waits(world)
        with self._lock:
            reasons = {key: why for key, why in self._new_reasons.items() if key[0] == world}
            for key in reasons:
                del self._new_reasons[key]
            has_available = world in self._has_available
            self._has_available.discard(world)
        try:
            unavailable = {robot: why for (_, robot), why in reasons.items()}
            if unavailable and self._waits_for_any(world, unavailable):
                self._update_reasons(world, unavailable)
            if has_available:
                with self._database.write() as session:
                    self.release(session, world)
        except BaseException:  # the database is away; the next call tries again
            with self._lock:
                self._new_reasons = reasons | self._new_reasons
                if has_available:
                    self._has_available.add(world)
            raise

    def _end_waits(self, world: str) -> None:
        """Count a release if the time is over for which a goal waits; start a workflow again that has failed."""
        now_s = self._wall_clock.monotonic_s()
        if now_s < self._looked_at_s.get(world, -LOOK_S) + LOOK_S:
            return
        with self._database.read() as session:
            is_due = (
                self._has_waited(session, world)
                or self._has_failed(session, world)
                or self._has_left_behind(session, world)
            )
        if is_due:
            with self._database.write() as session:
                if self._has_left_behind(session, world):
                    self._wake(session, world)
                if self._has_failed(session, world):
                    self._facts.lock(session, world).waiting_workflow = None
                    self._wake(session, world)
                if self._has_waited(session, world):
                    self.release(session, world)
        self._looked_at_s[world] = now_s

    def _has_failed(self, session: Session, world: str) -> bool:
        """Whether the workflow that is to plan the world's waiting goals has ended without having begun them."""
        workflow = summary_of(session, world).waiting_workflow
        return workflow is not None and self._workflows.has_ended(workflow)

    @staticmethod
    def _has_left_behind(session: Session, world: str) -> bool:
        """Whether no workflow is to plan a goal whose joint goal has ended, perhaps without a mission's end."""
        if summary_of(session, world).waiting_workflow is not None:
            return False
        return session.scalar(_LEFT_BEHIND, {"world": world}) is not None

    def _has_waited(self, session: Session, world: str) -> bool:
        """Whether the time is over for a goal that no release has had planned again."""
        releases = summary_of(session, world).releases
        waiting = [
            Blockers.from_json(goal.waits_for).until_s
            for goal in session.scalars(_waiting_goals(world))
            if goal.waits_for is not None and goal.releases_seen == releases
        ]
        until_s = min((one for one in waiting if one is not None), default=None)
        return until_s is not None and until_s <= self._clocks[world].now_s()

    def _waits_for_any(self, world: str, robots: Collection[str]) -> bool:
        with self._database.read() as session:
            known = [goal.waits_for for goal in session.scalars(_waiting_goals(world))]
            waiting = [waits_for(mission) for mission in session.scalars(_waiting_missions(world))]
        waiting += [Blockers.from_json(one) for one in known if one is not None]
        return any(robot in blockers.robots for blockers in waiting for robot in robots)

    def _update_reasons(self, world: str, unavailable: Mapping[str, str]) -> None:
        with self._database.write() as session:
            for goal in session.scalars(_waiting_goals(world).with_for_update()).all():
                before = Blockers() if goal.waits_for is None else Blockers.from_json(goal.waits_for)
                if (now := before.updated(unavailable)) != before:
                    have_wait(session, self._events, goal, now)
            for mission in session.scalars(_waiting_missions(world).with_for_update()).all():
                before = waits_for(mission)
                if (now := before.updated(unavailable)) != before:
                    note_blockers(mission, now)
                    self._workflows.wake(session, mission.workflow)

    def join(self, session: Session, goal: GoalRow, mission: MissionRow) -> None:
        """Leave a goal to a mission that is planned again for it, too; planning it by itself is given up."""
        goal.joint_goal = mission.goal_id
        goal.planned_by = None
        have_wait(
            session, self._events, goal, Blockers(missions=(f"{mission.id}, which is planned with it",))
        )

    def part(self, session: Session, goal: GoalRow, mission: MissionRow) -> None:
        """Have a goal planned by itself that the mission was to carry out, too, and does not."""
        goal.joint_goal = None
        goal.releases_seen = NEVER_PLANNED
        have_wait(
            session, self._events, goal, Blockers(missions=(f"{mission.id}, which goes on without it",))
        )
        self.look_again(session, goal)

    def release(self, session: Session, world: str) -> None:
        """Count a release in the world, and have waiting goals planned once the caller's transaction commits."""
        self._facts.lock(session, world).releases += 1
        session.flush()
        if most_urgent(session, world) is not None:
            self._wake(session, world)

    def look_again(self, session: Session, goal: GoalRow) -> None:
        """Have a goal that begins to wait planned again if there was a release during its planning."""
        session.flush()
        # Without the lock, a concurrent release would not see the waiting goal, and this would not see the release.
        if goal.releases_seen < self._facts.lock(session, goal.world).releases:
            self._wake(session, goal.world)

    def run(
        self,
        world: str,
        *,
        plan: Callable[[str], None],
        together: Callable[[str], bool | None] = _by_themselves,
    ) -> None:
        """The workflow: plan the world's waiting goals that were last planned before the newest release.

        A goal that it was planning when its process ended comes first: it waits no longer, and nothing else plans it.

        :param plan: plans one goal.
        :param together: plans several together; False if nothing came of it, None if there are none to plan so.
        """
        goal_id = step("begin", lambda: self._begin(world))
        may_join = True
        for _ in range(GOALS_PER_WORKFLOW):
            if goal_id is None:
                return
            found = _unless_it_fails(lambda: step("together", lambda: together(world))) if may_join else None
            may_join = found is not False
            if not found:
                plan(goal_id)
            goal_id = step("next", lambda: self._next(world))
        if goal_id is not None:
            step("continue", lambda: self._continue_as_new(world))

    def _begin(self, world: str) -> str | None:
        """The first goal; a release from now on starts another workflow."""
        with self._database.write() as session:
            row = self._facts.lock(session, world)
            if row.waiting_workflow == current_workflow():
                row.waiting_workflow = None
            return self._first(session, world)

    def _next(self, world: str) -> str | None:
        with self._database.read() as session:
            return self._first(session, world)

    @staticmethod
    def _first(session: Session, world: str) -> str | None:
        return _being_planned(session, world) or most_urgent(session, world)

    def _continue_as_new(self, world: str) -> None:
        with self._database.write() as session:
            self._wake(session, world)

    def _wake(self, session: Session, world: str) -> None:
        """Start the workflow, unless one has been started that has not begun: it sees what this transaction commits."""
        row = self._facts.lock(session, world)
        if row.waiting_workflow is None:
            row.waiting_workflow = new_id("waiting")
            self._workflows.start(session, WAITING, PLAN_WAITING, row.waiting_workflow, world)


def _unless_it_fails(plan_together: Callable[[], bool | None]) -> bool | None:
    """What came of planning goals together; False if that keeps failing: they can still be planned by themselves."""
    try:
        return plan_together()
    except StepFailed:
        return False


def _waiting_goals(world: str) -> Select[GoalRow]:
    waiting = (GoalRow.world == world, GoalRow.state == GoalState.WAITING)
    return select(GoalRow).where(*waiting).order_by(GoalRow.id)


def _waiting_missions(world: str) -> Select[MissionRow]:
    waiting = (
        MissionRow.world == world,
        MissionRow.state.in_(OPEN),
        MissionRow.recovery_step == RecoveryStep.WAITING,
    )
    return select(MissionRow).where(*waiting).order_by(MissionRow.id)


_joint = aliased(GoalRow)
IS_DUE = (
    GoalRow.world == bindparam("world"),
    GoalRow.state == GoalState.WAITING,
    GoalRow.releases_seen
    < select(WorldRow.releases).where(WorldRow.id == bindparam("world")).scalar_subquery(),
    ~select(_joint.id).where(_joint.id == GoalRow.joint_goal, _joint.state.in_(goal_lifecycle.OPEN)).exists(),
)
"""Conditions on goals of a world: waiting, last planned before the newest release, carried out by no other goal."""
BY_URGENCY = (
    GoalRow.priority.desc(),
    GoalRow.deadline_at_s.is_(None),
    GoalRow.deadline_at_s,
    GoalRow.created_at,
    GoalRow.id,
)
"""The order in which goals are planned: by priority, deadline, age."""
_MOST_URGENT = select(GoalRow.id).where(*IS_DUE).order_by(*BY_URGENCY).limit(1)
_LEFT_BEHIND = select(GoalRow.id).where(*IS_DUE, GoalRow.joint_goal.is_not(None)).limit(1)


def _being_planned(session: Session, world: str) -> str | None:
    """The goal whose planning by the current workflow has not been concluded."""
    query = select(GoalRow.id).where(
        GoalRow.world == world,
        GoalRow.state == GoalState.PLANNING,
        GoalRow.planned_by == current_workflow(),
    )
    return session.scalar(query)


def most_urgent(session: Session, world: str) -> str | None:
    """The next waiting goal that was last planned before the newest release: by priority, deadline, age."""
    return session.scalar(_MOST_URGENT, {"world": world})
