"""The run that compiles the simulation calls every function that is compiled."""

import json
import os
import subprocess
import sys

from robots.compilation import DISABLED

RUN = """
import json
import sim.world.agents, sim.world.simulation
from robots.compiled import KERNELS
from sim.process.first_calls import compile_simulation

called = set()

def noting(function):
    def noted(*args):
        called.add(function.__qualname__)
        return function(*args)
    return noted

for kernel in KERNELS:
    kernel.function = noting(kernel.function)
compile_simulation()
print(json.dumps([len(KERNELS), sorted({kernel.__qualname__ for kernel in KERNELS} - called)]))
"""


def test_every_compiled_function_of_the_world_is_called() -> None:
    done = subprocess.run(
        [sys.executable, "-c", RUN],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, DISABLED: "1"},
    )
    count, missed = json.loads(done.stdout.splitlines()[-1])
    assert count > 10
    assert missed == []
