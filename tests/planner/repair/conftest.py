import pytest

from planner import KnowledgeBase, PlanNet, PlanningRequest
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from tests.planner.repair.carrying import problem


@pytest.fixture(scope="session")
def planner(knowledge_base: KnowledgeBase) -> HierarchicalEngine:
    engine = HierarchicalEngine(knowledge_base)
    engine.warm_up()
    return engine


@pytest.fixture(scope="session")
def plan_net(planner: HierarchicalEngine) -> PlanNet:
    """Two samples from the doors to bays in different aisles: yard_n brings s_n, about 55 s."""
    found = planner.plan(problem(), PlanningRequest(effort_s=0)).plan_net
    assert found is not None
    return found
