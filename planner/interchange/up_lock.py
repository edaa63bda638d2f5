"""The lock around unified-planning's global environment.

unified-planning's plan validator works only in its one global environment, which is not thread-safe. Whoever creates
or reads its objects holds the lock. It takes seconds to import, so it is imported where it is first needed.
(The environment keeps expressions for good, but equal ones only once.)
"""

from threading import RLock

UNIFIED_PLANNING_LOCK = RLock()
