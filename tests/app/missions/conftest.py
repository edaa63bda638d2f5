"""Fixtures of the tests about missions."""

from pathlib import Path

import pytest

from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.world import WorldFile
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.app.missions.trial import Trial


@pytest.fixture
def trial(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> Trial:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url)
    return Trial(settings, world_file, team, worker)
