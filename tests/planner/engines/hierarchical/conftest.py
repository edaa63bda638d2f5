import pytest

from planner import KnowledgeBase, load_knowledge_base
from planner.engines.hierarchical.fragments.fragment import Fragments


@pytest.fixture(scope="session")
def knowledge_base() -> KnowledgeBase:
    return load_knowledge_base()


@pytest.fixture
def fragments(knowledge_base: KnowledgeBase) -> Fragments:
    return Fragments(knowledge_base)
