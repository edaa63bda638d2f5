"""How often and how fast goals in the sample store are planned: `uv run python -m benchmarks.planning [INSTANCES]`.

Random instances, seeded: samples at doors or in bays, half of the goals store and half retrieve where possible.
"""

import random
import sys
from collections import Counter
from statistics import mean, median

from planner import FastDownwardEngine, PlanningProblem, load_knowledge_base
from tests.planner.store import inside, store_problem

BAYS = [f"bay_{number}" for number in range(1, 13)]
DOORS = ["door_1", "door_2"]


def instance(goals: int, seed: int) -> PlanningProblem:
    choose = random.Random(f"{goals}/{seed}")
    stores = min(goals // 2 + goals % 2 * choose.randint(0, 1), len(DOORS))
    bays = choose.sample(BAYS, goals + stores)
    doors = choose.sample(DOORS, len(DOORS))
    samples, targets = {}, {}
    for number in range(goals):
        name = f"sample_{number + 1}"
        if number < stores:
            samples[name], targets[name] = doors[number], bays.pop()
        elif number < stores + len(DOORS):
            samples[name], targets[name] = bays.pop(), doors[number - stores]
        else:
            samples[name], targets[name] = bays.pop(), choose.choice(free_bays(bays, targets, samples))
    return store_problem([inside(name, place) for name, place in targets.items()], samples=samples)


def free_bays(bays: list[str], targets: dict[str, str], samples: dict[str, str]) -> list[str]:
    return [bay for bay in BAYS if bay not in (*bays, *targets.values(), *samples.values())]


def main(instances: int) -> None:
    engine = FastDownwardEngine(load_knowledge_base())
    engine.warm_up()
    for goals in (1, 2, 3, 4):
        results = [engine.plan(instance(goals, seed), time_limit_s=30) for seed in range(instances)]
        spans = [result.planning_s for result in results]
        makespans = [result.plan_net.makespan_s for result in results if result.plan_net]
        print(
            f"{goals} goals: {dict(Counter(str(result.status) for result in results))}; planning "
            f"{median(spans):.2f} s median, {max(spans):.2f} s worst; makespan {mean(makespans or [0]):.0f} s mean"
        )
        for reason in {result.reason for result in results if result.reason}:
            print(f"    {reason}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
