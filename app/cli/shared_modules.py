"""Modules that the child processes of a command share (`robots.child_processes.sharing`)."""

import os

PLANNING = "app.planning.pool.preloaded"
SIMULATING = "sim.process.preloaded"


def shared_by_service(broker: str | None) -> list[str]:
    """What a service's children share, by its option and environment alone: they are started before settings are read.

    :param broker: as it is given to the command.
    """
    started = {
        PLANNING: os.environ.get("MACTA_PLANNING_PROCESSES") != "0",
        SIMULATING: not (broker or os.environ.get("MACTA_BROKER_URL")),
    }
    return [module for module, is_started in started.items() if is_started]
