import pytest

from planner import KnowledgeBase, load_knowledge_base
from planner.engines.fast_downward import FastDownwardEngine


@pytest.fixture(scope="session")
def knowledge_base() -> KnowledgeBase:
    return load_knowledge_base()


@pytest.fixture(scope="session")
def engine(knowledge_base: KnowledgeBase) -> FastDownwardEngine:
    engine = FastDownwardEngine(knowledge_base)
    engine.warm_up()
    return engine
