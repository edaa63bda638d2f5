"""Lost robots: an operator declares them lost; they are restored when they are heard again or declared found.

Missions do not wait for the scripts of a lost robot. It is ordered to stop when it is heard, also after its mission has
ended, and can be restored only after it has reported the end of its script.
"""

from collections.abc import Mapping, Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.agents.robot_board import RobotBoard
from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.contact import Connection
from app.domain.errors import Conflict
from app.domain.events import RobotDeclaredLost, RobotFound, ScriptAbandoned
from app.domain.lifecycles.mission import OPEN, MissionState
from app.domain.lifecycles.recovery import answer_troubles
from app.domain.lifecycles.script import abandon
from app.planning.waiting_goals import WaitingGoals
from app.store import LostRobotRow, MissionRow, ScriptRow
from app.store.records import UNENDED_SCRIPT, lock_running_missions, lost_robots
from app.workflows.mission_wakeups import wake_missions
from robots.clock import Clock

CONTACT = "contact"
"""The actor of the restoration of a robot that was heard again."""


class LostRobots:
    """Declares robots lost and restores them."""

    def __init__(
        self,
        core: Core,
        *,
        clocks: Mapping[str, Clock],
        board: RobotBoard,
        waiting: WaitingGoals,
        wall_clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param clocks: the worlds' clocks by the world's name."""
        self._database = core.database
        self._events = core.events
        self._workflows = core.workflows
        self._clocks = clocks
        self._board = board
        self._waiting = waiting
        self._wall_clock = wall_clock

    def declare_lost(self, world: str, robot: str, *, actor: str, comment: str) -> None:
        """Declare the robot lost; its missions are recovered without it. Declaring it again changes nothing."""
        with self._database.write() as session:
            if session.get(LostRobotRow, (world, robot), with_for_update=True) is not None:
                return
            row = LostRobotRow(
                world=world,
                robot=robot,
                silent=not self._in_contact(world, robot) or _is_unanswering(session, world, robot),
                since_s=self._clocks[world].now_s(),
                declared_by=actor,
                comment=comment,
            )
            session.add(row)
            self._events.append(
                session,
                RobotDeclaredLost(
                    subject=robot, world=world, actor=actor, comment=comment, silent=row.silent
                ),
            )
            for script in _open_scripts(session, world, robot):
                self._abandon(session, script)

    def declare_found(self, world: str, robot: str, *, actor: str, comment: str) -> None:
        """Restore the robot.

        :raises Conflict: if it is not lost, or has not reported the end of a script that it was given.
        """
        with self._database.write() as session:
            row = session.get(LostRobotRow, (world, robot), with_for_update=True)
            if row is None:
                raise Conflict(f"{robot} is not lost", code="not-lost")
            if owed := _owed(session, world, robot):
                detail = f"{robot} has not reported the end of {', '.join(owed)}; it can be declared found after that"
                raise Conflict(detail, code="script-unresolved")
            self._restore(session, row, actor, comment)

    def restore_in_contact(self, world: str) -> None:
        """Restore the robots that were silent, are heard again, and have reported the ends of their scripts."""
        with self._database.read() as session:
            candidates = [row.robot for row in lost_robots(session, world) if self._is_back(session, row)]
        for robot in candidates:
            with self._database.write() as session:
                row = session.get(LostRobotRow, (world, robot), with_for_update=True)
                if row is not None and self._is_back(session, row):
                    self._restore(session, row, CONTACT, "")

    def _is_back(self, session: Session, row: LostRobotRow) -> bool:
        heard = row.silent and self._in_contact(row.world, row.robot)
        return heard and not _owed(session, row.world, row.robot)

    def _in_contact(self, world: str, robot: str) -> bool:
        view = self._board.views(world).get(robot)
        return view is not None and view.connection(self._wall_clock.monotonic_s()) is Connection.ONLINE

    def _restore(self, session: Session, row: LostRobotRow, actor: str, comment: str) -> None:
        session.delete(row)
        for mission in lock_running_missions(session, row.world):
            answer_troubles(mission, lambda trouble: trouble.is_loss and trouble.robot == row.robot)
        found = RobotFound(subject=row.robot, world=row.world, actor=actor, comment=comment)
        self._events.append(session, found)
        session.flush()
        self._waiting.release(session, row.world)
        wake_missions(session, self._workflows, row.world)

    def _abandon(self, session: Session, script: ScriptRow) -> None:
        mission = session.get_one(MissionRow, script.mission_id, with_for_update=True)
        abandon(script)
        self._events.append(session, ScriptAbandoned(subject=script.id, robot=script.robot))
        self._workflows.wake(session, mission.workflow)


def _is_unanswering(session: Session, world: str, robot: str) -> bool:
    """True if the robot has not answered a mission that is `unknown`, although it may be in contact."""
    return any(
        script.question is not None
        and session.get_one(MissionRow, script.mission_id).state == MissionState.UNKNOWN
        for script in _open_scripts(session, world, robot)
    )


def _open_scripts(session: Session, world: str, robot: str) -> Sequence[ScriptRow]:
    """The robot's scripts that have not ended, in running missions."""
    query = (
        select(ScriptRow)
        .join(MissionRow, MissionRow.id == ScriptRow.mission_id)
        .where(
            MissionRow.world == world,
            MissionRow.state.in_(OPEN),
            ScriptRow.robot == robot,
            ScriptRow.plan_id == MissionRow.plan_id,
            *UNENDED_SCRIPT,
        )
    )
    return session.scalars(query).all()


def _owed(session: Session, world: str, robot: str) -> Sequence[str]:
    """The robot's abandoned scripts whose end it has not reported."""
    query = (
        select(ScriptRow.id)
        .join(MissionRow, MissionRow.id == ScriptRow.mission_id)
        .where(
            MissionRow.world == world,
            ScriptRow.robot == robot,
            ScriptRow.abandoned,
            *UNENDED_SCRIPT,
        )
    )
    return session.scalars(query).all()
