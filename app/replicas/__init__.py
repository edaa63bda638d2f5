"""Several processes on one database: which of them live, who speaks for a world, and who takes over from a dead one."""

from app.replicas.presence import BEAT_S, DEAD_AFTER_S, HELD_S, Executor, Presence, executors

__all__ = ["BEAT_S", "DEAD_AFTER_S", "HELD_S", "Executor", "Presence", "executors"]
