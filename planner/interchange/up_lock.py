"""The lock around unified-planning's global environment.

unified-planning's plan validator works only in its one global environment, which is not thread-safe. Whoever creates
or reads its objects holds the lock. It takes seconds to import, so it is imported where it is first needed.
(Expressions stay in the environment for good, but by content: the same world adds nothing twice.)
"""

from threading import RLock

UNIFIED_PLANNING_LOCK = RLock()
