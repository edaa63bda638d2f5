"""How reliably and fast the rovers do errands in the sample store: `python -m benchmarks.sample_store`.

Prints the success of the main job over seeds, of storing to and retrieving from every bay, of joint tours,
and what each packet takes: for those that drive, seconds = a + b * metres from place to place (least squares).
"""

import argparse
import random
import time
from collections.abc import Iterable, Sequence
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from benchmarks.errands import Ran, Result, carry_out, figures, to_retrieve, to_store, tour, with_sample
from robots.wire import ScriptState
from robots.world import load_world
from sim.trials.script_runner import ScriptRunner

BAYS = [f"bay_{number}" for number in range(1, 13)]
DRIVING = ("NAVIGATE", "TRANSPORT")


class Trial(NamedTuple):
    """One run: `kind` main, store, retrieve or tour."""

    kind: str
    seed: int
    bay: str = ""
    door: str = ""
    robot: str = ""

    def __str__(self) -> str:
        return " ".join(str(part) for part in self if part != "")


def trials(seeds: int) -> list[Trial]:
    """The main job and a tour for every seed, and each bay both ways by each door and yard robot."""
    bays = [
        Trial(kind, 1000 + number, bay, door, robot)
        for number, bay in enumerate(BAYS)
        for kind in ("store", "retrieve")
        for door in ("door_1", "door_2")
        for robot in ("yard_1", "yard_2")
    ]
    main = [Trial("main", seed) for seed in range(seeds)]
    return [*main, *bays, *(Trial("tour", seed) for seed in range(seeds))]


def run(trial: Trial) -> tuple[Trial, Result]:
    world = load_world("sample_store")
    if trial.kind == "main":
        return trial, carry_out(world, to_store("sample_1", "door_1", "bay_7", "yard_1"), seed=trial.seed)
    if trial.kind == "tour":
        return trial, all_tour(trial.seed)
    if trial.kind == "store":
        world = with_sample(world, "sample_1", trial.door, vacant=trial.bay)
        errand = to_store("sample_1", trial.door, trial.bay, trial.robot)
    else:
        world = with_sample(world, "sample_1", trial.bay, vacant=trial.door)
        errand = to_retrieve("sample_1", trial.bay, trial.door, trial.robot)
    return trial, carry_out(world, errand, seed=trial.seed)


def all_tour(seed: int) -> Result:
    """All four robots visit their places in random order, never two the same place."""
    world = load_world("sample_store")
    rng = random.Random(seed)
    scripts = [
        tour(
            "yard_1", rng.sample(["door_2", "interchange_2"], 2)
        ),  # both cross the yard, in each other's way
        tour("yard_2", rng.sample(["door_1", "interchange_1"], 2)),
    ]
    for aisle, bays in ((1, BAYS[:6]), (2, BAYS[6:])):
        scripts.append(tour(f"store_{aisle}", rng.sample([*bays, f"interchange_{aisle}"], 5)))
    with ScriptRunner(world, seed=seed) as runner:
        runner.run(scripts)
        took_s = runner.simulation.clock.now_s()
    words = [f"{r.script_id}: {r.state} {r.detail}" for r in runner.ended.values()]
    finished = [r for r in runner.ended.values() if r.state is ScriptState.FINISHED]
    return Result(succeeded=len(finished) == len(scripts), took_s=took_s, ran=figures(runner), words=words)


def report(results: Sequence[tuple[Trial, Result]]) -> None:
    for kind in ("main", "store", "retrieve", "tour"):
        of_kind = [result for trial, result in results if trial.kind == kind]
        good = [result.took_s for result in of_kind if result.succeeded]
        mean, most = (np.mean(good), max(good)) if good else (0.0, 0.0)
        print(f"{kind:9} {len(good)}/{len(of_kind)} succeeded, mean {mean:.1f} s, longest {most:.1f} s")
    ran = [one for _, result in results for one in result.ran]
    for tag in ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"):
        print(f"{tag:9} {spread(tag, [one for one in ran if one.tag == tag and one.finished])}")
    print(f"retries: {sum(one.retries for one in ran)} in {len(ran)} packets")


def spread(tag: str, ran: Sequence[Ran]) -> str:
    seconds = np.array([one.ran_s for one in ran])
    most = np.quantile(seconds, 0.95)
    told = f"n {len(ran)}, mean {seconds.mean():.1f} s, 95 % {most:.1f} s, longest {max(seconds):.1f} s"
    if tag not in DRIVING:
        return told
    metres = np.array([one.distance_m for one in ran])
    slope, offset = np.polyfit(metres, seconds, 1)
    off = seconds - (offset + slope * metres)
    return f"{offset:.2f} + {slope:.2f} * metres (off by {off.std():.1f} s, at most {max(off):+.1f}); {told}"


def run_all(chosen: Sequence[Trial], jobs: int) -> Iterable[tuple[Trial, Result]]:
    with get_context("spawn").Pool(jobs) as pool:
        yield from pool.imap_unordered(run, chosen)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    began_s = time.monotonic()
    results = []
    for trial, result in run_all(trials(options.seeds), options.jobs):
        results.append((trial, result))
        if not result.succeeded or any(one.retries for one in result.ran):
            shaken = [f"{one.robot} {one.tag} {one.retries} retries" for one in result.ran if one.retries]
            print(f"{trial}: {'succeeded' if result.succeeded else 'FAILED'} {shaken} {result.words}")
    report(results)
    world_s = sum(result.took_s for _, result in results)
    wall_s = time.monotonic() - began_s
    print(f"{world_s:.0f} s of the world in {wall_s:.0f} s: {world_s / wall_s:.1f} times real time")


if __name__ == "__main__":
    main()
