"""A service that may be killed and started again."""

from contextlib import contextmanager

from fastapi.testclient import TestClient

from app.agents.running_world import RunningWorld
from app.composition import Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.world import WorldFile
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam


class Trial:
    """A service that may be killed and started again, with the same robots."""

    def __init__(self, settings: Settings, file: WorldFile, team: FakeTeam, worker: PlanningWorker) -> None:
        self._settings = settings
        self._file = file
        self._team = team
        self._worker = worker

    @contextmanager
    def running(self, run: str | None = None, file: WorldFile | None = None):  # type: ignore[no-untyped-def]
        world = RunningWorld(
            file=file or self._file,
            link=self._team.link,
            clock=self._team.clock,
            rate=None,
            run=run or self._team.run,
        )
        with (
            Service(self._settings, [world], worker=self._worker) as service,
            TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as api,
        ):
            yield api
