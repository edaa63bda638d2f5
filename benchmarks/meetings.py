"""Two robots that meet head-on in an aisle, by its width: `python -m benchmarks.meetings [--seeds 4]`.

Each is to drive to where the other comes from. Robots are 0.44 m across and keep 0.15 m from each other.
"""

import argparse
from collections.abc import Sequence

from benchmarks.errands import packet
from robots.wire import BehaviourScript, ScriptState
from robots.world import WorldFile
from sim.trials.script_runner import ScriptRunner

LONG_M = 7.0
WIDTHS_M = (2.0, 1.6, 1.3, 1.0)
TIMEOUT_S = 60.0


def aisle(width_m: float) -> WorldFile:
    """Walled all round, a beacon at each end; fred starts in the west, ginger in the east."""
    corners = [(0, 0), (LONG_M, 0), (LONG_M, width_m), (0, width_m)]
    walls = [
        {"start": one, "end": other} for one, other in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    middle_m = width_m / 2
    return WorldFile.model_validate(
        {
            "name": "aisle",
            "compartments": [{"name": "aisle", "x": (0, LONG_M), "y": (0, width_m)}],
            "walls": walls,
            "locations": [
                {"name": "west_end", "kind": "place", "at": (0.1, middle_m), "approach_deg": (0,)},
                {"name": "east_end", "kind": "place", "at": (LONG_M - 0.1, middle_m), "approach_deg": (180,)},
            ],
            "robots": [
                {"name": "fred", "compartment": "aisle", "start": (1, middle_m, 0)},
                {"name": "ginger", "compartment": "aisle", "start": (LONG_M - 1, middle_m, 180)},
            ],
            "samples": [],
        }
    )


def drive(robot: str, start: str, end: str, timeout_s: float) -> BehaviourScript:
    go = packet(1, "NAVIGATE", robot=robot, rel1="near", ref1=start, rel2="near", ref2=end)
    limited = go.model_copy(update={"timeout_s": timeout_s})
    return BehaviourScript(id=robot, mission_id="meeting", robot=robot, packets=(limited,))


def meet(width_m: float, seed: int, timeout_s: float) -> tuple[bool, float, Sequence[str]]:
    """Whether both arrived, the seconds until both had ended, and what they reported if not."""
    runner = ScriptRunner(aisle(width_m), seed=seed, jitter_m=0.2)
    scripts = [
        drive("fred", "west_end", "east_end", timeout_s),
        drive("ginger", "east_end", "west_end", timeout_s),
    ]
    try:
        over = runner.run(scripts, timeout_s=4 * timeout_s)
        failed = [one.detail for one in runner.ended.values() if one.state is not ScriptState.FINISHED]
        return over and not failed, runner.simulation.clock.now_s(), failed if over else ["no end"]
    finally:
        runner.simulation.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=4)
    options = parser.parse_args()
    for width_m in WIDTHS_M:
        met = [meet(width_m, seed, TIMEOUT_S) for seed in range(options.seeds)]
        passed, longest_s = sum(arrived for arrived, _, _ in met), max(took_s for _, took_s, _ in met)
        print(f"{width_m:.1f} m wide: {passed}/{len(met)} passed, all ended within {longest_s:.0f} s")
        for words in [words for _, _, said in met for words in said]:
            print(f"    {words}")


if __name__ == "__main__":
    main()
