import pytest

from planner import KnowledgeBase, load_knowledge_base


@pytest.fixture(scope="session")
def knowledge_base() -> KnowledgeBase:
    return load_knowledge_base()
