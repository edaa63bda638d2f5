"""A mission's repair being planned: nobody wants it any more once the mission is cancelled or has ended."""

import time

from app.domain.lifecycles.mission import has_ended
from app.domain.lifecycles.recovery import RecoveryStep
from app.domain.states import GoalState
from app.planning.progress_watch import LOOK_S, GoalWatch
from app.store import Database, MissionRow
from app.store.event_log import EventLog


class RecoveryWatch(GoalWatch):
    """Its progress is the goal's, which stays committed meanwhile. For one thread."""

    def __init__(self, database: Database, events: EventLog, mission: MissionRow) -> None:
        super().__init__(database, events, mission.goal_id, during=GoalState.COMMITTED)
        self._mission_id = mission.id

    def _look(self) -> None:
        if time.monotonic() < self._looked_at + LOOK_S:
            return
        with self._database.read() as session:
            mission = session.get_one(MissionRow, self._mission_id)
            self._cancelled = has_ended(mission) or mission.recovery_step != RecoveryStep.PLANNING
        self._looked_at = time.monotonic()
