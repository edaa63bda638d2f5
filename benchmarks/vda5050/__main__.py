"""Random runs of the VDA 5050 adapter with faults: `python -m benchmarks.vda5050 [--seeds N]`; a row a condition.

`wrong`: runs in which something was done twice, was lost, or was told that was not so; `failed`: runs in which a script
ended early, with a reason.
"""

import argparse
import time

from benchmarks.vda5050.channel import Faults
from benchmarks.vda5050.faults import Run

CONDITIONS = {
    "no faults": Faults(),
    "lost 20 %": Faults(lost=0.2, delay_s=0.2),
    "repeated 30 %, delayed up to 3 s": Faults(repeated=0.3, delay_s=3.0),
    "a restart every 5 s": Faults(restarts_per_s=0.2, delay_s=0.2),
    "an outage every 20 s": Faults(outages_per_s=0.05, delay_s=0.2),
    "all of these": Faults(
        lost=0.2, repeated=0.3, delay_s=3.0, restarts_per_s=0.2, outages_per_s=0.02, outage_s=15.0
    ),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=200, help="runs of each condition")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    asked = parser.parse_args()
    for name, faults in CONDITIONS.items():
        began_s = time.process_time()
        runs = [Run(seed, faults)() for seed in range(asked.first, asked.first + asked.seeds)]
        wrong = [one for one in runs if one.faults]
        failed = [one for one in runs if one.failed]
        restarts = sum(one.restarts for one in runs)
        messages = sum(one.messages for one in runs)
        world_s = sum(one.time_s for one in runs) / len(runs)
        print(
            f"{name}: {len(runs)} runs, wrong {len(wrong)} ({len(wrong) / len(runs):.1%}), failed {len(failed)}, "
            f"{restarts} restarts, {messages} messages, {world_s:.0f} s each, "
            f"{time.process_time() - began_s:.1f} s of CPU",
            flush=True,
        )
        for one in [*wrong, *failed][:5]:
            print(f"    seed {one.seed}: {'; '.join((*one.faults, *one.failed))}")


if __name__ == "__main__":
    main()
