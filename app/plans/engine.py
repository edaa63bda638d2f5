"""The planning engine as planning processes build it."""

from planner import PlanningEngine, load_knowledge_base


def make_engine() -> PlanningEngine:
    """The planning engine, warm. Called inside the planning process."""
    # NOTE: imported here, for only the planning process needs the engines, and they take seconds.
    from planner.engines.registry import portfolio

    engine = portfolio(load_knowledge_base())
    engine.warm_up()
    return engine
