import pytest

from planner import FastDownwardEngine, KnowledgeBase, load_knowledge_base


@pytest.fixture(scope="session")
def knowledge_base() -> KnowledgeBase:
    return load_knowledge_base()


@pytest.fixture(scope="session")
def engine(knowledge_base: KnowledgeBase) -> FastDownwardEngine:
    engine = FastDownwardEngine(knowledge_base)
    engine.warm_up()
    return engine
