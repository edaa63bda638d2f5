"""The same errand on every kind of body, and what a body costs: `python -m benchmarks.bodies`.

Prints for each kind how often the sample store's main job came true over seeds, how long it took, how far odometry had
drifted at its end, and the processor's time for a tick of a world of 16 such robots, sensing included, without agents.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import hypot
from statistics import mean, median
from typing import Any

from benchmarks.errands import to_store
from robots.wire import ScriptState
from robots.world import WorldFile, generate_world, load_world, store_shape
from sim.trials.parallel import run_parallel
from sim.trials.script_runner import ScriptRunner
from sim.world.agent import AgentSetup
from sim.world.simulation import Simulation

KINDS: dict[str, tuple[Any, ...]] = {
    "velocity": ("velocity",),
    "wheeled": ("wheeled",),
    "avatar": ("avatar",),
    "all together": ("avatar", "velocity", "wheeled", "avatar"),
    "slipping wheels": ({"kind": "wheeled", "slip": 0.2},),
}


def embodied(world: WorldFile, *bodies: Any) -> WorldFile:
    """The world with these bodies, in the order of its robots; all further robots get the last one."""
    file = world.model_dump()
    for number, robot in enumerate(file["robots"]):
        robot["body"] = bodies[min(number, len(bodies) - 1)]
    return WorldFile.model_validate(file)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How one errand ended; the drift is of the robot whose odometry is worst."""

    succeeded: bool
    took_s: float
    drift_m: float
    words: tuple[str, ...]


def run(kind: str, seed: int) -> Ended:
    """The main job once."""
    errand = to_store("sample_1", "door_1", "bay_7", "yard_1")
    with ScriptRunner(embodied(load_world("sample_store"), *KINDS[kind]), seed=seed) as runner:
        runner.run(errand.scripts())
        truth, bodies = runner.simulation.truth(), runner.simulation.bodies
        drifts_m = [
            hypot(true.x_m - felt.x_m, true.y_m - felt.y_m)
            for name, true in truth.robots.items()
            for felt in [bodies[name].get_position()]
        ]
    ended = list(runner.ended.values())
    finished = len(ended) == 2 and all(report.state is ScriptState.FINISHED for report in ended)
    return Ended(
        succeeded=finished and truth.samples[errand.sample].ref == errand.goal,
        took_s=truth.time_s,
        drift_m=max(drifts_m),
        words=tuple(f"{report.script_id}: {report.state} {report.detail}" for report in ended),
    )


class Circling:
    """An agent that drives in circles."""

    def __init__(self, setup: AgentSetup) -> None:
        self._body = setup.body

    def tick(self) -> None:
        self._body.set_velocity(0.2, 0.8)


def tick_us(kind: str, *, world_s: float = 5.0) -> float:
    """Processor microseconds for a tick of a store of 16 robots that drive in circles, sensing included."""
    world = embodied(generate_world(store_shape(samples=64), seed=1), *KINDS[kind])
    simulation = Simulation(world, make_agent=Circling, seed=1)
    ticks = round(world_s * 60)
    began_s = time.process_time()
    for _ in range(ticks):
        simulation.step()
    took_s = time.process_time() - began_s
    simulation.close()
    return took_s / ticks * 1e6


def row(kind: str, ended: Sequence[Ended], cost_us: float) -> str:
    good = [one.took_s for one in ended if one.succeeded]
    times = f"{mean(good):.1f} s, longest {max(good):.1f} s" if good else "no time"
    drift = f"odometry off by {median(one.drift_m for one in ended):.2f} m"
    return f"{kind:16} {len(good)}/{len(ended)} came true, {times}, {drift}, {cost_us:.0f} us a tick"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of {', '.join(KINDS)}; all if none")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    if unknown := set(options.kinds) - set(KINDS):
        parser.error(f"unknown kinds: {', '.join(sorted(unknown))}; choices: {', '.join(KINDS)}")
    for kind in options.kinds or KINDS:
        ended = list(run_parallel(partial(run, kind), range(options.seeds), workers=options.jobs))
        for seed, one in enumerate(ended):
            if not one.succeeded:
                print(f"{kind}, seed {seed}: {one.words}")
        print(row(kind, ended, tick_us(kind)), flush=True)


if __name__ == "__main__":
    main()
