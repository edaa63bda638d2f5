"""Missions with the uplink cut: `python -m benchmarks.peer_clearance [--seeds N]`.

Two yard robots bring a sample each to one interchange; the second waits until the first has left, unsensed.
Simulated robots, stepped; what stands for the service gives the scripts and is cut off for good 1 s later. A row a
condition: missions whose robots have ended their scripts with the samples in place, and messages between robots.
"""

import argparse
import statistics
from collections.abc import Mapping
from dataclasses import dataclass

from app.cli.trials.offline_mission import organised_mission
from benchmarks.errands import with_sample
from robots.wire import ScriptState
from robots.world import LinkSpec, load_world
from sim.trials.script_runner import ScriptRunner
from tests.app.sample_store import Store

CUT_FROM_S = 1.0
LIMIT_S = 250.0
GOALS = {"sample_1": "bay_1", "sample_2": "bay_3"}
CUT = {"outages": [{"start_s": CUT_FROM_S, "end_s": 1e6}]}
PEERS: Mapping[str, LinkSpec | None] = {
    "robots do not hear each other": None,
    "robots hear each other": LinkSpec(),
    "robots hear each other badly": LinkSpec(loss=0.3, delay_s=0.2, jitter_s=2.0, duplication=0.2),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a mission ended. `took_s`: by the world's clock; `letters`: messages between robots."""

    came_true: bool
    took_s: float
    letters: int


def carry_out(peer_link: LinkSpec | None, seed: int) -> Ended:
    """Carry the mission out with the uplink cut."""
    plain = with_sample(load_world("sample_store"), "sample_2", "door_2", vacant="bay_3")
    world = plain.model_copy(update={"link": LinkSpec.model_validate(CUT), "peer_link": peer_link})
    store = Store(world)
    mission = organised_mission(world, store.one_interchange_twice(), store.base)
    names = {script.id for script in mission.scripts}
    with ScriptRunner(world, seed=seed) as runner:
        runner.send(mission.scripts)
        simulation = runner.simulation

        def all_finished() -> bool:
            states = (agent.memory().mind.executive.states for agent in simulation.agents.values())  # type: ignore[attr-defined]
            ended = {
                name for known in states for name, state in known.items() if state is ScriptState.FINISHED
            }
            return names <= ended

        finished = False
        while not finished and simulation.clock.now_s() < LIMIT_S:
            simulation.run_until(lambda: False, timeout_s=5.0)
            finished = all_finished()
        samples = simulation.truth().samples
        in_place = all(samples[name].ref == place for name, place in GOALS.items())
        return Ended(
            came_true=finished and in_place,
            took_s=simulation.clock.now_s(),
            letters=simulation.hub.peer_letters,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=20, help="missions a condition")
    seeds = parser.parse_args().seeds
    print(f"{'condition':32} {'completed':>10} {'took s':>7} {'messages':>9}")
    for name, link in PEERS.items():
        ended = [carry_out(link, seed) for seed in range(seeds)]
        done = [one for one in ended if one.came_true]
        took = f"{statistics.median(one.took_s for one in done):7.0f}" if done else "      -"
        letters = statistics.mean(one.letters for one in ended)
        print(f"{name:32} {len(done):4} of {seeds:2} {took} {letters:9.1f}", flush=True)


if __name__ == "__main__":
    main()
