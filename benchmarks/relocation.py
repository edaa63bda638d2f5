"""How reliably and gently Fred and Ginger relocate the rock sample: `python -m benchmarks.relocation --seeds 20`.

The scripts are written by hand, as the mission organiser would. Each seed draws start poses, where the rocks on the way
stand, and all noise. Prints for each seed whether the sample ended at the lander, how long it took, the largest
deflection of a capture head (its travel is 0.06 m) and how often a handle slipped out of one.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from math import dist
from statistics import median

from benchmarks.errands import Ran, fact, figures, packet
from robots.wire import BehaviourScript, ScriptState
from robots.world import load_world
from sim.trials.parallel import run_parallel
from sim.trials.script_runner import ScriptRunner

GIVE_UP_S = 400.0
THING, FROM, TO = "rock_sample", "quarry", "lander"


@dataclass(frozen=True, slots=True, kw_only=True)
class Relocation:
    """How one seed's relocation ended."""

    seed: int
    succeeded: bool
    took_s: float
    deflection_m: float
    slipped: int
    off_m: float
    ran: tuple[Ran, ...]
    words: tuple[str, ...]

    def __str__(self) -> str:
        said = "at the lander" if self.succeeded else "FAILED"
        return (
            f"seed {self.seed:3d}  {said:14s} {self.took_s:6.1f} s  deflection {self.deflection_m:.3f} m"
            f"  slipped {self.slipped}  {self.off_m:.2f} m off"
        )


def scripts(first: str = "fred", second: str = "ginger") -> tuple[BehaviourScript, BehaviourScript]:
    """The first acquires the object while the second tracks it; both transport it; the second deposits it."""
    joint = {"object": THING, "rel1": "at", "ref1": FROM, "rel2": "near", "ref2": TO}
    one = (
        packet(1, "NAVIGATE", robots=first, rel1="near", ref1=f"home_{first}", rel2="near", ref2=FROM),
        packet(2, "DOCK", object=THING, robots=first, rel1="near", ref1=FROM),
        packet(3, "TRANSPORT", **joint, robot=first, partner=second, awaits=[fact("in", THING, second)]),
        packet(4, "RELEASE1", object=THING, robot1=first, robot2=second, rel="near", ref=TO),
    )
    other = (
        packet(1, "TRACK", robot1=second, robot2=first),
        packet(2, "DOCK2", object=THING, robot1=second, robot2=first, ref2=FROM, awaits=[fact("in", THING, first)]),
        packet(3, "TRANSPORT", **joint, robot=second, partner=first),
        packet(4, "RELEASE2", **joint, robots=second, awaits=[fact("holds_alone", second, THING)]),
    )  # fmt: skip
    return (
        BehaviourScript(id=f"{first}_relocates", mission_id="relocation", robot=first, packets=one),
        BehaviourScript(id=f"{second}_relocates", mission_id="relocation", robot=second, packets=other),
    )


def relocate(seed: int) -> Relocation:
    """Run one seed to its end; read the true state at the end, and the capture heads' deflections at 20 Hz."""
    world = load_world("relocation_lab")
    deflections_m = [0.0]
    with ScriptRunner(world, seed=seed) as runner:
        simulation = runner.simulation
        runner.run(
            scripts(),
            timeout_s=GIVE_UP_S,
            meanwhile=lambda: deflections_m.extend(simulation.truth().deflections_m.values()),
        )
        truth, reports = simulation.truth(), list(runner.ended.values())
        ran = tuple(figures(runner))
    sample, there = truth.samples[THING], world.location(TO).at
    finished = len(reports) == 2 and all(report.state is ScriptState.FINISHED for report in reports)
    return Relocation(
        seed=seed,
        succeeded=finished and sample.ref == TO and truth.slipped == 0,
        took_s=truth.time_s,
        deflection_m=max(deflections_m),
        slipped=truth.slipped,
        off_m=dist((sample.x_m, sample.y_m), there),
        ran=ran,
        words=tuple(f"{report.script_id}: {report.state} {report.detail}" for report in reports),
    )


def summary(ended: list[Relocation]) -> Iterator[str]:
    yield f"{sum(one.succeeded for one in ended)} of {len(ended)} at the lander, nothing fallen"
    yield f"median {median(one.took_s for one in ended):.1f} s, longest {max(one.took_s for one in ended):.1f} s"
    yield f"largest deflection {max(one.deflection_m for one in ended):.3f} m"
    for tag in dict.fromkeys(each.tag for one in ended for each in one.ran):
        took_s = [each.ran_s for one in ended for each in one.ran if each.tag == tag and each.finished]
        if took_s:
            yield f"  {tag:10s} median {median(took_s):5.1f} s, longest {max(took_s):5.1f} s"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seeds", type=int, default=20)
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--jobs", type=int, default=2)
    given = options.parse_args()
    seeds = range(given.first, given.first + given.seeds)
    ended = []
    for one in run_parallel(relocate, seeds, workers=given.jobs):
        ended.append(one)
        print(one, *([] if one.succeeded else one.words), sep="\n    ", flush=True)
    print("\n".join(summary(ended)))


if __name__ == "__main__":
    main()
