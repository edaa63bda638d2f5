"""The sample store is planned by rule, in the process of the test: what is tested is not the planner."""

import pytest

from tests.app.planning.store_engine import StoreEngine
from tests.app.scripted import InProcessWorker


@pytest.fixture(scope="session")
def worker() -> InProcessWorker:
    return InProcessWorker(StoreEngine())
