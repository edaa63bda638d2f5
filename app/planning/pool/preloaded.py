"""What planning processes share (`robots.child_processes.sharing`): modules, and the machine code of the planner."""

from planner.engines.garbage_collection import garbage_collection_paused
from robots.child_processes import keep_for_children
from robots.compilation import load

with garbage_collection_paused():
    import app.planning.pool.process  # noqa: F401, for the processes that are forked
    from app.planning.pool.work import PLANNER

    # NOTE: whether the planner's functions run compiled is decided where their modules are imported.
    if load(PLANNER):
        import planner.engines.registry  # noqa: F401
    keep_for_children()
