"""Makes Macta's planner known to unified-planning."""

from typing import Any

from planner.interchange.up_import import import_unified_planning
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK

ENGINE = "macta"


def register_with_unified_planning(environment: Any = None) -> None:
    """Let `OneshotPlanner(name="macta")` and `AnytimePlanner(name="macta")` find us.

    :param environment: a `unified_planning.environment.Environment`; the global one unless told.
    """
    with UNIFIED_PLANNING_LOCK:
        import_unified_planning()
        from unified_planning.environment import get_environment

        factory = get_environment(environment).factory
        if ENGINE not in factory.engines:
            factory.add_engine(ENGINE, "planner.up_engine", "MactaEngine")
