"""The demonstrations over many seeds: `python -m benchmarks.demonstrations waltz|soccer [--seeds N]`.

Without a service: robots of the shipped worlds do what the rule files of their worlds say. A row a condition.
"""

import argparse
from collections.abc import Sequence
from functools import partial
from statistics import mean, median

from benchmarks.demonstrations.soccer import GOALS, Match, play
from benchmarks.demonstrations.waltz import FIGURES, Waltz, dance
from sim.trials.parallel import run_parallel

IN_STEP_S = 0.5
"""Robots that begin a figure within this time of each other are in step."""
LOSSES = (0.0, 0.3)


def show_waltz(seeds: int, workers: int) -> None:
    print(
        f"{'messages lost':>13} {'completed':>10} {'figures':>12} {'in step':>12} {'late s, longest':>16}"
        f" {'apart m, mean, most':>20} {'open m':>7} {'touched':>8} {'nearest m':>10} {'took s':>7} {'messages':>9}"
    )
    for loss in LOSSES:
        danced: Sequence[Waltz] = list(run_parallel(partial(dance, loss=loss), range(seeds), workers=workers))
        late = [one for waltz in danced for one in waltz.late_s]
        done = sum(waltz.figures for waltz in danced)
        in_step = sum(one <= IN_STEP_S for one in late)
        print(
            f"{loss:13.0%} {sum(one.succeeded for one in danced):4} of {seeds:2}"
            f" {done:5} of {FIGURES * seeds:3} {in_step:5} of {len(late):3} {max(late):16.1f}"
            f" {mean(one.apart_m for one in danced):14.2f} {max(one.apart_at_most_m for one in danced):5.2f}"
            f" {max(one.closed_m for one in danced):7.2f} {sum(one.touches for one in danced):8}"
            f" {min(one.nearest_m for one in danced):10.2f} {median(one.took_s for one in danced):7.0f}"
            f" {mean(one.messages for one in danced):9.0f}",
            flush=True,
        )


def show_soccer(seeds: int, workers: int) -> None:
    print(
        f"{'messages lost':>13} {'completed':>10} {'goals':>10} {'conceded':>9} {'role changes':>13} {'resets':>10}"
        f" {'reset s, most':>14} {'ball laid back':>15} {'robots met':>11} {'took s':>7}"
    )
    for loss in LOSSES:
        played: Sequence[Match] = list(run_parallel(partial(play, loss=loss), range(seeds), workers=workers))
        reset_s = [one for match in played for one in match.reset_s]
        scored = sum(match.scored for match in played)
        goals = sum(match.goals for match in played)
        print(
            f"{loss:13.0%} {sum(one.succeeded for one in played):4} of {seeds:2}"
            f" {goals:4} of {GOALS * seeds:2} {goals - scored:9}"
            f" {sum(one.changes for one in played):6} of {scored:3} {sum(one.resets for one in played):4} of {goals:2}"
            f" {median(reset_s):8.0f} {max(reset_s):5.0f} {sum(one.outs for one in played):15}"
            f" {sum(one.meetings for one in played):11} {median(one.took_s for one in played):7.0f}",
            flush=True,
        )


SHOWS = {"soccer": show_soccer, "waltz": show_waltz}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("demonstration", choices=sorted(SHOWS))
    parser.add_argument("--seeds", type=int, default=20, help="runs a condition")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    given = parser.parse_args()
    SHOWS[given.demonstration](given.seeds, given.workers)


if __name__ == "__main__":
    main()
