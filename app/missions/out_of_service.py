"""Robots that operators take out of service, one or a group, and bring back.

A robot out of service ends what it has begun, stays in contact and may be driven by hand, but is not recruited: goals
that need it wait, and plans that use it are out of date.
"""

from collections.abc import Mapping, Sequence

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Conflict
from app.domain.events import RobotBroughtBack, RobotTakenOutOfService
from app.missions.better_plans import BetterPlans
from app.planning.waiting_goals import WaitingGoals
from app.store import OutOfServiceRow
from robots.clock import Clock

FAILING = "recovery"
"""Who takes a door out of service that does not open."""


class OutOfService:
    """Takes robots out of service and brings them back; of a group all or none."""

    def __init__(
        self,
        core: Core,
        *,
        clocks: Mapping[str, Clock],
        waiting: WaitingGoals,
        better_plans: BetterPlans | None = None,
    ) -> None:
        """:param clocks: the worlds' clocks by the world's name.
        :param better_plans: None: none are sought when robots are back.
        """
        self._database = core.database
        self._events = core.events
        self._clocks = clocks
        self._waiting = waiting
        self._better_plans = better_plans

    def take_out(self, robots: Sequence[tuple[str, str]], *, actor: str, reason: str) -> None:
        """Have the robots no longer recruited; for one that is out of service already the reason is replaced.

        :param robots: each with its world first.
        """
        with self._database.write() as session:
            for world, robot in sorted(set(robots)):
                self._take_out(session, world, robot, actor=actor, reason=reason)
            for world in sorted({world for world, _ in robots}):
                session.flush()
                self._waiting.release(session, world)  # goals that wait for such a robot say the new reason

    def take_out_failing(self, session: Session, world: str, names: Mapping[str, str]) -> None:
        """Take doors, hatches and lifts out of service that fail again and again, each with the reason; an operator
        brings them back. Those that are out of service stay so, for their own reason.
        """
        for name, reason in sorted(names.items()):
            if session.get(OutOfServiceRow, (world, name), with_for_update=True) is None:
                self._take_out(session, world, name, actor=FAILING, reason=reason)

    def _take_out(self, session: Session, world: str, robot: str, *, actor: str, reason: str) -> None:
        row = session.get(OutOfServiceRow, (world, robot), with_for_update=True)
        if row is None:
            row = OutOfServiceRow(world=world, robot=robot, since_s=self._clocks[world].now_s())
            session.add(row)
        row.taken_by = actor
        row.reason = reason
        taken = RobotTakenOutOfService(subject=robot, world=world, actor=actor, reason=reason)
        self._events.append(session, taken)

    def bring_back(self, robots: Sequence[tuple[str, str]], *, actor: str, comment: str) -> None:
        """Have the robots recruited again.

        :param robots: each with its world first.
        :raises Conflict: if one of them is not out of service.
        """
        with self._database.write() as session:
            for world, robot in sorted(set(robots)):
                row = session.get(OutOfServiceRow, (world, robot), with_for_update=True)
                if row is None:
                    raise Conflict(f"{robot} is not out of service", code="not-out-of-service")
                session.delete(row)
                back = RobotBroughtBack(subject=robot, world=world, actor=actor, comment=comment)
                self._events.append(session, back)
            session.flush()
            for world in sorted({world for world, _ in robots}):
                self._waiting.release(session, world)
                if self._better_plans is not None:
                    self._better_plans.seek(session, world)
