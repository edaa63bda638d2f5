"""The service as a whole: how it begins and ends."""

from pathlib import Path

import pytest

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings, lock_folder
from robots.world import load_world
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam


def test_a_start_that_is_interrupted_leaves_nothing_open(
    tmp_path: Path, team: FakeTeam, worker: PlanningWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None)
    world = RunningWorld(
        file=load_world("sample_store"), link=team.link, clock=team.clock, rate=None, run=team.run
    )
    service = Service(settings, [world], worker=worker)

    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(service.core.workflows, "launch", interrupted)
    with pytest.raises(KeyboardInterrupt), service:
        pass
    lock_folder(tmp_path).close()
