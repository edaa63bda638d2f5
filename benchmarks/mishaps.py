"""What becomes of robots that something befalls: `python -m benchmarks.mishaps [--seeds 10] [--case WORDS]`.

A yard robot of the sample store carries a sample from a door to an interchange; each case does something to it, to the
sample or to a beacon while a packet runs. Prints a line a case: how often the robot recovered (goal reached in the
world itself), reported a failure, finished without having reached the goal (wrong), or came to no end (silent), and the
seconds from the mishap to the end. With --words also what it reported.
"""

import argparse
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np

from benchmarks.errands import Leg, script
from benchmarks.mishap_cases import GOAL, ROBOT, SAMPLE, START, Case, Stage, cases
from robots.body import RADIUS_M, Pose
from robots.wire import BehaviourScript, PacketState, ScriptState
from robots.world import WorldFile, load_world
from robots.world.walls import clearance_m, panels_of
from sim.crew import Crew
from sim.mishaps import Mishaps

PACKET_S, WAIT_S = 40.0, 60.0
"""Timeouts as the mission organiser gives for packets of ten seconds."""
LIMIT_S = 4 * (PACKET_S + WAIT_S)
WALL_M = RADIUS_M - 0.03
"""A rover whose middle is nearer to a wall's surface than this is in it."""
OUTCOMES = ("recovered", "reported", "wrong", "silent")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How one trial ended: `took_s` after the mishap, None if nothing befell; `walled`: it was in a wall.

    `end`: where it truly came to.
    """

    how: str
    took_s: float | None
    words: str = ""
    walled: bool = False
    end: Pose | None = None


def yard(robots: Sequence[str]) -> WorldFile:
    """The sample store with these robots alone."""
    world = load_world("sample_store").model_dump()
    kept = [robot for robot in world["robots"] if robot["name"] in robots]
    return WorldFile.model_validate({**world, "robots": kept})


def errand() -> BehaviourScript:
    """NAVIGATE, DOCK, TRANSPORT, RELEASE2."""
    whole = script(Leg(robot=ROBOT, fetch=START, deposit=GOAL), SAMPLE, handed_over=False)
    limits = {"timeout_s": PACKET_S, "wait_timeout_s": WAIT_S}
    return whole.model_copy(update={"packets": tuple(p.model_copy(update=limits) for p in whole.packets)})


class Trial:
    """One case in one seed's world."""

    def __init__(self, case: Case, seed: int) -> None:
        mishaps = Mishaps()
        self._case = case
        self._crew = Crew(yard([ROBOT]), seed=seed, make_agent=mishaps.fit)
        self._stage = Stage(crew=self._crew, mishaps=mishaps, rng=np.random.default_rng(seed))
        self._panels = panels_of(self._crew.world.walls)
        self._done_s: float | None = None
        self._undone = False
        self._walled = False

    def run(self) -> Outcome:
        simulation, work = self._crew.simulation, errand()
        try:
            over = self._crew.run([work], timeout_s=LIMIT_S, meanwhile=self._meddle)
            truth = simulation.truth()
            end = self._crew.ended.get(work.id)
            took_s = None if self._done_s is None else truth.time_s - self._done_s
            if not over or end is None:
                return Outcome(how="silent", took_s=took_s, walled=self._walled)
            if end.state is not ScriptState.FINISHED:
                words, pose = end.detail, truth.robots[ROBOT]
                return Outcome(how="reported", took_s=took_s, words=words, walled=self._walled, end=pose)
            sample = truth.samples[SAMPLE]
            right = sample.place == GOAL and not sample.holders
            words = "" if right else f"{SAMPLE} is in {sample.ref}"
            return Outcome(
                how="recovered" if right else "wrong", took_s=took_s, words=words, walled=self._walled
            )
        finally:
            simulation.close()

    def _meddle(self) -> None:
        now_s, case = self._crew.simulation.clock.now_s(), self._case
        if self._done_s is None and self._ran_s() >= case.after_s:
            self._done_s = now_s
            case.do(self._stage)
        elif (
            self._done_s is not None
            and case.undo
            and not self._undone
            and now_s - self._done_s >= case.undo_s
        ):
            self._undone = True
            case.undo(self._stage)
        pose = self._stage.pose
        self._walled |= clearance_m((pose.x_m, pose.y_m), self._panels) < WALL_M

    def _ran_s(self) -> float:
        """How long the patterns of the case's packet have acted; -1 if they do not."""
        last = self._crew.reports[-1] if self._crew.reports else None
        if (
            last is None
            or last.state is not PacketState.RUNNING
            or not last.packet_id.endswith(self._case.during.lower())
        ):
            return -1.0
        return self._crew.simulation.clock.now_s() - last.at_s


def run(order: tuple[int, int]) -> tuple[int, int, Outcome]:
    number, seed = order
    return number, seed, Trial(tuple(cases())[number], seed).run()


def line(case: Case, outcomes: Sequence[Outcome]) -> str:
    counts = Counter(one.how for one in outcomes)
    spans = [one.took_s for one in outcomes if one.took_s is not None]
    how = "  ".join(f"{counts[how]:9d}" for how in OUTCOMES)
    longest = f"{np.median(spans):6.1f} {max(spans):6.1f}" if spans else "  nothing befell"
    walled = f"  IN A WALL {sum(one.walled for one in outcomes)}" if any(o.walled for o in outcomes) else ""
    return f"{case!s:42}{how}  {longest}{walled}"


def said(outcomes: Sequence[Outcome]) -> Iterable[str]:
    for words, count in Counter(one.words for one in outcomes if one.words).most_common():
        yield f"      {count} x {words}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--case", default="", help="only cases whose name holds these words")
    parser.add_argument("--words", action="store_true", help="also what was reported")
    options = parser.parse_args()
    chosen = [(number, case) for number, case in enumerate(cases()) if options.case in str(case)]
    orders = [(number, seed) for number, _ in chosen for seed in range(options.seeds)]
    began_s, found = time.monotonic(), dict[int, list[Outcome]]()
    total: Counter[str] = Counter()
    print(f"{'':42}{'  '.join(f'{how:>9}' for how in OUTCOMES)}  median longest s")
    with get_context("spawn").Pool(options.jobs) as pool:
        for number, _, outcome in pool.imap(run, orders):
            found.setdefault(number, []).append(outcome)
            if len(found[number]) == options.seeds:
                case = dict(chosen)[number]
                print(line(case, found[number]), flush=True)
                total.update(one.how for one in found[number])
                for words in said(found[number]) if options.words else ():
                    print(words)
    print(f"{'all':42}{'  '.join(f'{total[how]:9d}' for how in OUTCOMES)}")
    print(f"in {time.monotonic() - began_s:.0f} s")


if __name__ == "__main__":
    main()
