"""What worlds' processes share (`robots.child_processes.sharing`): modules, and the machine code of the simulation."""

# ruff: noqa: E402, F401, imported for the processes that are forked

import gc

gc.disable()  # it would scan what is being imported

import sim.process.persistence
import sim.process.world_loop
import sim.world.agents
from robots.child_processes import keep_for_children
from robots.compilation import load
from sim.process.first_calls import SIMULATION

load(SIMULATION)
keep_for_children()
gc.enable()
