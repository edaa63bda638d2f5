"""Minds that move from body to body during the sample store's main job: `python -m benchmarks.embodiments`.

Every few seconds one of the two robots is moved into the next kind of body, and the power fails now and then at any
step of a move. Prints how often the job came true, each packet finished once, and what became of the moves.
"""

import argparse
from collections import Counter
from dataclasses import dataclass, field
from functools import partial
from random import Random

from benchmarks.errands import to_store
from robots.wire import Message, MindOrder, MindOrderReport, MindVerb, PacketState, Performative, ScriptState
from robots.world import Edition, WorldFile, load_world
from sim.trials.parallel import run_parallel
from sim.trials.script_runner import ScriptRunner

KINDS = ("avatar", "wheeled", "velocity")
EVERY_S = 6.0
"""Between the end of a move and the next one."""
CYCLES_A_SECOND = 20
TIMEOUT_S = 400.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How one job ended. `moves`: how often moves ended so."""

    succeeded: bool
    took_s: float
    moves: Counter[str]
    failures: int
    words: tuple[str, ...]


@dataclass(slots=True)
class Mover:
    """Moves minds while a job is carried out; called at 20 Hz."""

    runner: "MovingRunner"
    rng: Random
    failures_a_move: float
    moves: Counter[str] = field(default_factory=Counter)
    failures: int = 0
    _fence: int = 0
    _robot: str = ""
    _kind: str = ""
    _verb: MindVerb | None = None
    _due_s: float = EVERY_S

    def __call__(self) -> None:
        now_s = self.runner.simulation.clock.now_s()
        answer = self.runner.answers.pop((self._robot, self._verb, self._fence), None)
        if self._verb is None and now_s >= self._due_s:
            self._begin()
        elif answer is not None and self._verb is MindVerb.REST and answer.reason:
            self._end("refused")
        elif answer is not None and self._verb is MindVerb.REST:
            self._fail_perhaps()
            self.runner.exchange(self._robot, self._kind)
            self._fail_perhaps()
            self._order(MindVerb.GO_ON)
        elif answer is not None:
            self._end("embodied")
        elif self._verb is not None and round(now_s * CYCLES_A_SECOND) % CYCLES_A_SECOND == 0:
            self._order(self._verb)  # said again, as the service does

    def _begin(self) -> None:
        self._fence += 1
        self._robot = self.rng.choice([script.robot for script in self.runner.scripts])
        now = self.runner.simulation.world.robot(self._robot).body.kind
        self._kind = KINDS[(KINDS.index(now) + 1) % len(KINDS)]
        self._order(MindVerb.REST)
        self._fail_perhaps()

    def _order(self, verb: MindVerb) -> None:
        self._verb = verb
        order = MindOrder(verb=verb, fence=self._fence)
        self.runner.tell(self._robot, Performative.REQUEST, order)

    def _fail_perhaps(self) -> None:
        if self.rng.random() < self.failures_a_move / 3:
            self.failures += 1
            self.runner.restart()

    def _end(self, how: str) -> None:
        self.moves[how] += 1
        self._verb = None
        self._due_s = self.runner.simulation.clock.now_s() + EVERY_S


class MovingRunner(ScriptRunner):
    """Keeps what robots answer to orders to their minds, and exchanges bodies as editions of the world."""

    def __init__(self, world: WorldFile, *, seed: int) -> None:
        super().__init__(world, seed=seed)
        self.answers: dict[tuple[str, MindVerb | None, int], MindOrderReport] = {}

    def take(self, message: Message) -> None:
        super().take(message)
        if isinstance(message.body, MindOrderReport):
            self.answers[message.sender, message.body.verb, message.body.fence] = message.body

    def exchange(self, robot: str, kind: str) -> None:
        document = self.simulation.world.model_dump()
        for one in document["robots"]:
            one.update({"body": kind} if one["name"] == robot else {})
        world = WorldFile.model_validate(document)
        self.simulation.take_up(Edition(self.simulation.edition + 1, world))


def run(failures_a_move: float, seed: int) -> Ended:
    """The main job once."""
    errand = to_store("sample_1", "door_1", "bay_7", "yard_1")
    with MovingRunner(load_world("sample_store"), seed=seed) as runner:
        mover = Mover(runner, Random(seed), failures_a_move)
        scripts = errand.scripts()
        runner.send(scripts)
        while len(runner.ended) < len(scripts) and runner.simulation.clock.now_s() < TIMEOUT_S:
            runner.simulation.step_control_cycle()
            runner.receive()
            mover()
        truth = runner.simulation.truth()
    ended = list(runner.ended.values())
    finished = Counter(
        (report.script_id, report.packet_id)
        for report in runner.reports
        if report.state is PacketState.FINISHED
    )
    came_true = truth.samples[errand.sample].ref == errand.goal
    return Ended(
        succeeded=came_true
        and len(ended) == 2
        and all(report.state is ScriptState.FINISHED for report in ended)
        and set(finished.values()) == {1},
        took_s=truth.time_s,
        moves=mover.moves,
        failures=mover.failures,
        words=tuple(f"{report.script_id}: {report.state} {report.detail}" for report in ended),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--failures", type=float, default=0.5, help="power failures a move")
    options = parser.parse_args()
    job = partial(run, options.failures)
    ended = list(run_parallel(job, range(options.seeds), workers=options.jobs))
    for seed, one in enumerate(ended):
        if not one.succeeded:
            print(f"seed {seed}: {dict(one.moves)} {one.words}")
    moves = sum((one.moves for one in ended), Counter[str]())
    good = sum(one.succeeded for one in ended)
    failures = sum(one.failures for one in ended)
    longest_s = max(one.took_s for one in ended)
    print(
        f"{good}/{len(ended)} came true, longest {longest_s:.0f} s; moves {dict(moves)}; {failures} power failures"
    )


if __name__ == "__main__":
    main()
