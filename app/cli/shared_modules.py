"""Modules that the child processes of a command share (`robots.child_processes.sharing`)."""

PLANNING = "app.planning.pool.preloaded"
SIMULATING = "sim.process.preloaded"
