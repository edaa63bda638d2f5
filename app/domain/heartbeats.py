"""When a process counts as dead: the rules of the processes that share a database."""

from typing import Final

HEARTBEAT_S: Final = 1.0
DEAD_AFTER_S: Final = 6.0
"""Silence after which a process counts as dead, and the others take over its work."""
PLANNING_QUEUE: Final = "planning"
"""The queue that a process serves if it plans."""
