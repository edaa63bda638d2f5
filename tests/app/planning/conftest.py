"""The sample store is planned by rule, in the process of the test: what is tested is not the planner."""

import pytest

from planner import load_knowledge_base
from planner.engines.oversubscription import OversubscriptionEngine
from tests.app.planning.store_engine import StoreEngine
from tests.app.scripted import InProcessWorker


@pytest.fixture(scope="session")
def worker() -> InProcessWorker:
    return InProcessWorker(OversubscriptionEngine(StoreEngine(), load_knowledge_base()))
