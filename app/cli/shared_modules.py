"""Modules that the child processes of a command share (`robots.child_processes.share`)."""

PLANNING = "app.planning.pool.preloaded"
SIMULATING = "sim.process.preloaded"
