"""A mission's repair being planned: nobody wants it any more once the mission is cancelled or has ended."""

import time

from app.database import Database, MissionRow
from app.plans.process import Watch
from app.recovery.rules import Step
from app.states import MissionState

LOOK_S = 0.25


class RecoveryWatch(Watch):
    """For one thread."""

    def __init__(self, database: Database, mission_id: str) -> None:
        self._database, self._mission_id = database, mission_id
        self._looked_at, self._cancelled = float("-inf"), False

    def is_cancelled(self) -> bool:
        if time.monotonic() >= self._looked_at + LOOK_S:
            with self._database.read() as session:
                mission = session.get_one(MissionRow, self._mission_id)
                ended = MissionState(mission.state).ended
                self._cancelled = ended or mission.recovery_step != Step.PLANNING
            self._looked_at = time.monotonic()
        return self._cancelled
