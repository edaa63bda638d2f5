"""What worlds' processes share (`robots.child_processes.sharing`): modules, and the machine code of the simulation."""

# ruff: noqa: F401, imported for the processes that are forked

import gc

import sim.process.persistence
import sim.process.world_loop
import sim.world.agents
from robots.compilation import load
from sim.process.first_calls import SIMULATION

load(SIMULATION)
gc.collect()
gc.freeze()  # a collection in a process that is forked would write to each object, and so share none
