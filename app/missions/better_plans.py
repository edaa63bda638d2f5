"""Looks for better plans of missions under way when a robot of their world becomes available, and tells operators."""

from functools import partial
from math import inf
from threading import Lock

from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import MactaError
from app.domain.events import MissionBetterPlanFound
from app.domain.ids import new_id
from app.domain.lifecycles.mission import OPEN, MissionState, has_ended
from app.missions.replanning import MissionPreview, MissionReplanning
from app.planning.pool.waiting_line import Priority
from app.store import MissionRow
from app.workflows import BETTER_PLANS, SEEK_BETTER_PLANS, step

STOP_S = 5.0
"""What the stop of a mission's robots costs, world seconds; it is counted against the better plan."""
MIN_SHARE = 0.1
"""The least share of the time until a mission's end that a better plan saves; less is not worth a decision."""

AGAIN_AFTER_S = 60.0
"""The least time between two looks at a world because robots became available there, wall-clock seconds: a robot may be
in contact now and then only."""


class BetterPlans:
    """Previews missions under way as they would be planned now, and records where that saves much of their time.

    The mission goes on as it is: whether its robots are stopped for the better plan is the operator's decision.
    """

    def __init__(self, core: Core, *, replanning: MissionReplanning, clock: WallClock = SYSTEM_CLOCK) -> None:
        self._database = core.database
        self._events = core.events
        self._workflows = core.workflows
        self._replanning = replanning
        self._clock = clock
        self._has_available: set[str] = set()
        self._looked_at_s: dict[str, float] = {}
        self._lock = Lock()

    def robot_available(self, world: str) -> None:
        """Note that a robot of the world may be recruited again, for the next `follow`."""
        with self._lock:
            self._has_available.add(world)

    def follow(self, world: str) -> None:
        """Look for better plans in the world if a robot has become available there, unless it was done just now."""
        now_s = self._clock.monotonic_s()
        with self._lock:
            is_early = now_s < self._looked_at_s.get(world, -inf) + AGAIN_AFTER_S
            if is_early or world not in self._has_available:
                return
            self._has_available.discard(world)
            self._looked_at_s[world] = now_s
        try:
            with self._database.write() as session:
                self.seek(session, world)
        except BaseException:  # the database is away; the next call tries again
            with self._lock:
                self._has_available.add(world)
                del self._looked_at_s[world]
            raise

    def seek(self, session: Session, world: str) -> None:
        """Look for better plans of the world's missions once the caller's transaction commits."""
        if session.scalar(_under_way(world).limit(1)) is not None:
            self._workflows.start(session, BETTER_PLANS, SEEK_BETTER_PLANS, new_id("better"), world)

    def run(self, world: str) -> None:
        """The workflow."""
        for mission_id in step("missions", lambda: self._missions(world)):
            step("preview", partial(self._seek_for, mission_id))

    def _missions(self, world: str) -> list[str]:
        with self._database.read() as session:
            return list(session.scalars(_under_way(world).order_by(MissionRow.id)))

    def _seek_for(self, mission_id: str) -> None:
        try:
            preview = self._replanning.preview(mission_id, (), priority=Priority.ALTERNATIVES)
        except MactaError:  # it has ended or is planned again meanwhile, or no planning process is free
            return
        saves_s = saving_s(preview)
        if saves_s is None:
            return
        with self._database.write() as session:
            mission = session.get_one(MissionRow, mission_id, with_for_update=True)
            if has_ended(mission) or mission.plan_id != preview.plan_id or mission.replanning is not None:
                return
            mission.better_plan = {
                "plan_id": preview.plan_id,
                "made_at_s": preview.made_at_s,
                "ends_in_s": preview.ends_in_s,
                "saves_s": saves_s,
                "robots": list(preview.robots),
            }
            self._events.append(
                session,
                MissionBetterPlanFound(
                    subject=mission.id,
                    ends_in_s=preview.ends_in_s,
                    saves_s=saves_s,
                    robots=tuple(preview.robots),
                    state=MissionState(mission.state),
                ),
            )


def _under_way(world: str) -> Select[str]:
    states = (MissionRow.world == world, MissionRow.state.in_(OPEN), MissionRow.started_at_s.is_not(None))
    return select(MissionRow.id).where(*states)


def saving_s(preview: MissionPreview) -> float | None:
    """World seconds by which the mission would end sooner, with the stop; None if it is not worth it."""
    if preview.ends_in_s is None or preview.expected_in_s is None:
        return None
    saves_s = preview.expected_in_s - preview.ends_in_s - STOP_S
    return round(saves_s, 1) if saves_s > MIN_SHARE * preview.expected_in_s else None
