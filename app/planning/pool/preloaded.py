"""What planning processes share (`robots.child_processes.sharing`): modules, and the machine code of the planner."""

import gc

import app.planning.pool.process  # noqa: F401, for the processes that are forked
from app.planning.pool.work import PLANNER
from robots.compilation import load

# NOTE: whether the planner's functions run compiled is decided where their modules are imported.
if load(PLANNER):
    import planner.engines.registry  # noqa: F401
gc.collect()
gc.freeze()  # a collection in a process that is forked would write to each object, and so share none
