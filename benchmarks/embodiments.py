"""Minds that move from body to body during the sample store's main job: `python -m benchmarks.embodiments`.

Every few seconds one of the two robots is moved into the next kind of body, and the power fails now and then at any
step of a move. With `--real` the robots have real bodies, too, outside of the simulation: their minds are handed over
between the world's program and the robots' own, and each of the two, or who moves the minds, is killed now and then.
Prints how often the job came true, each packet finished once, and what became of the moves.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from math import dist
from random import Random

from benchmarks.errands import to_store
from benchmarks.real_robot import RealRobot
from robots.executive.hand_over import Pieces
from robots.physical.body import Pose
from robots.wire import (
    WORLD,
    Body,
    ForeignState,
    Message,
    MindOrder,
    MindOrderReport,
    MindPiece,
    MindTransfer,
    MindTransferReport,
    MindVerb,
    MovedSample,
    PacketState,
    Performative,
    Program,
    Receipt,
    ScriptState,
)
from robots.world import Edition, WorldFile, load_world
from sim.trials.parallel import run_parallel
from sim.trials.script_runner import ScriptRunner

KINDS = ("avatar", "wheeled", "velocity")
REAL = "real"
WITH_REAL = ("velocity", REAL, "wheeled", REAL)
EVERY_S = 6.0
"""Between the end of a move and the next one."""
EVERY_REAL_S = 2.0
"""Likewise with real bodies, into which no mind moves that holds something."""
CYCLES_A_SECOND = 20
TIMEOUT_S = 400.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How one job ended. `moves`: how often moves ended so; `crossings`: those of them from program to program."""

    succeeded: bool
    took_s: float
    moves: Counter[str]
    crossings: int
    failures: Counter[str]
    words: tuple[str, ...]


@dataclass(slots=True)
class Mover:
    """Moves minds while a job is carried out; called at 20 Hz. What it knows of a move outlives its being killed."""

    runner: "MovingRunner"
    rng: Random
    failures_a_move: float
    kinds: Sequence[str] = KINDS
    every_s: float = EVERY_S
    moves: Counter[str] = field(default_factory=Counter)
    crossings: int = 0
    failures: Counter[str] = field(default_factory=Counter)
    _fence: int = 0
    _robot: str = ""
    _kind: str = ""
    _former: str = ""
    _step: str = ""
    """What is asked for: rest, transfer, go_on, or return; empty between moves."""
    _document: str = ""
    _pieces: list[MindPiece] = field(default_factory=list)
    _taken: int = 0
    _due_s: float = 2.0
    _turns: Counter[str] = field(default_factory=Counter)

    def __call__(self) -> None:
        now_s = self.runner.simulation.clock.now_s()
        if not self._step:
            if now_s >= self._due_s:
                self._begin()
            return
        answer = self.runner.answers.pop((self._robot, self._step, self._fence), None)
        if answer is not None:
            self._take(answer)
        elif round(now_s * CYCLES_A_SECOND) % CYCLES_A_SECOND == 0:
            self._ask()  # said again, as the service does

    @property
    def _crosses(self) -> bool:
        return REAL in (self._kind, self._former)

    def _begin(self) -> None:
        robot = self.rng.choice([script.robot for script in self.runner.scripts])
        former = self.runner.kind_of(robot)
        kind = self._next(robot, former)
        if kind == former or (REAL in (kind, former) and self.runner.holds(robot)):
            self._due_s = self.runner.simulation.clock.now_s() + 1.0  # as the service refuses it
            return
        self._fence += 1
        self._robot, self._kind, self._former = robot, kind, former
        self._document, self._pieces, self._taken = "", [], 0
        self._go("rest")

    def _next(self, robot: str, former: str) -> str:
        if REAL not in self.kinds:
            return self.kinds[(self.kinds.index(former) + 1) % len(self.kinds)]
        self._turns[robot] += 1
        return self.kinds[self._turns[robot] % len(self.kinds)]

    def _take(self, answer: MindOrderReport | MindTransferReport) -> None:
        if self._step == "rest":
            self._note_rest(answer)
        elif self._step == "transfer":
            self._note_transfer(answer)
        elif self._step == "go_on" and answer.reason:
            self._taken = 0
            self._go("transfer")  # its program has lost the mind
        else:
            self._end("embodied" if self._step == "go_on" else "returned")

    def _note_rest(self, answer: MindOrderReport | MindTransferReport) -> None:
        if answer.reason:
            self._end("refused")
            return
        if not self._crosses:
            self._exchange({})
            return
        assert isinstance(answer, MindOrderReport)
        assert answer.mind is not None
        if self._pieces and self._pieces[0].digest != answer.mind.digest:
            self._pieces = []  # the program was killed, and has written its mind again
        if answer.mind.number == len(self._pieces):
            self._pieces.append(answer.mind)
        if len(self._pieces) < answer.mind.count:
            self._ask()
            return
        taken = Pieces()
        for piece in self._pieces:
            self._document = taken.put(piece) or ""
        if self.runner.holds(self._robot):
            self._go("return")
        elif self._kind == REAL:
            self.runner.bring(self._robot)
            self._go("transfer")
        else:
            self._exchange({self._robot: self._document})

    def _note_transfer(self, answer: MindOrderReport | MindTransferReport) -> None:
        assert isinstance(answer, MindTransferReport)
        if answer.reason:
            self._go("return")
            return
        if answer.digest == self._pieces[0].digest:
            self._taken = max(self._taken, answer.number + 1)
        if self._taken < len(self._pieces):
            self._ask()
        elif self.runner.kind_of(self._robot) == self._kind:
            self._go("go_on")
        else:
            self._exchange({})

    def _exchange(self, minds: dict[str, str]) -> None:
        self._fail_perhaps()
        self.runner.exchange(self._robot, self._kind, minds)
        self._go("go_on")

    def _go(self, step: str) -> None:
        self._step = step
        self._fail_perhaps()
        self._ask()
        self._fail_perhaps()

    def _ask(self) -> None:
        holder = self._kind if self._step == "go_on" else self._former
        body: MindOrder | MindTransfer
        if self._step == "transfer":
            body = MindTransfer(fence=self._fence, mind=self._pieces[self._taken])
        else:
            body = MindOrder(
                verb=MindVerb.REST if self._step == "rest" else MindVerb.GO_ON,
                fence=self._fence,
                to=Program.OWN if holder == REAL else Program.WORLD,
                piece=len(self._pieces) if self._step == "rest" and self._crosses else None,
            )
        self.runner.tell(self._robot, Performative.REQUEST, body)

    def _fail_perhaps(self) -> None:
        if self.rng.random() >= self.failures_a_move / 6:
            return
        who = self.rng.choice(["world", *(["robot", "service"] if REAL in self.kinds else [])])
        self.failures[who] += 1
        if who == "world":
            self.runner.restart()
        elif who == "robot":
            self.runner.reals[self._robot].kill()
        else:
            self.runner.forget()

    def _end(self, how: str) -> None:
        self.moves[how] += 1
        self.crossings += how == "embodied" and self._crosses
        self._step = ""
        self._due_s = self.runner.simulation.clock.now_s() + self.every_s


class RunnersClock:
    """The clock of the simulation that runs now."""

    def __init__(self, runner: ScriptRunner) -> None:
        self._runner = runner

    def now_s(self) -> float:
        return self._runner.simulation.clock.now_s()


class MovingRunner(ScriptRunner):
    """Keeps what robots answer to orders to their minds, and exchanges bodies as editions of the world.

    Requests are repeated until they are answered. Beside the simulation stand the robots' real bodies, whose poses and
    grips it is told, as a service tells it.
    """

    def __init__(self, world: WorldFile, *, seed: int, real: Sequence[str] = ()) -> None:
        super().__init__(world, seed=seed)
        self.answers: dict[tuple[str, str, int], MindOrderReport | MindTransferReport] = {}
        clock = RunnersClock(self)
        self.reals = {name: RealRobot(world, name, clock) for name in real}
        self._asked: dict[str, Message] = {}
        self._moved: dict[str, MovedSample] = {}
        self._version = 0

    def step(self) -> None:
        """One control cycle of everything."""
        self.simulation.step_control_cycle()
        self.receive()
        for name, real in self.reals.items():
            truth = self.simulation.truth()
            others = {one: complex(pose.x_m, pose.y_m) for one, pose in truth.robots.items() if one != name}
            samples = {one: complex(at.x_m, at.y_m) for one, at in truth.samples.items()}
            before = real.body.held
            for message in real.tick(samples, others):
                self.take(message)
            self._note_grip(real, before)
        self._tell_foreign()
        if round(self.simulation.clock.now_s() * CYCLES_A_SECOND) % CYCLES_A_SECOND == 0:
            for message in list(self._asked.values()):
                self._send(message)

    def take(self, message: Message) -> None:
        super().take(message)
        self._asked.pop(message.in_reply_to or "", None)
        body = message.body
        if isinstance(body, MindTransferReport):
            self.answers[message.sender, "transfer", body.fence] = body
        elif isinstance(body, MindOrderReport) and body.verb is MindVerb.REST:
            self.answers[message.sender, "rest", body.fence] = body
        elif isinstance(body, MindOrderReport):
            self.answers[message.sender, "go_on", body.fence] = body
            self.answers[message.sender, "return", body.fence] = body

    def tell(
        self, robot: str, performative: Performative, body: Body, in_reply_to: str | None = None
    ) -> None:
        message = Message(
            performative=performative,
            sender="service",
            receiver=robot,
            sent_at_s=self.simulation.clock.now_s(),
            in_reply_to=in_reply_to,
            body=body,
        )
        if not isinstance(body, Receipt | MindOrder | MindTransfer):
            self._asked[message.id] = message
        self._send(message)

    def forget(self) -> None:
        """What was answered and not read is lost with its reader."""
        self.answers.clear()

    def kind_of(self, robot: str) -> str:
        spec = self.simulation.world.robot(robot)
        return REAL if spec.external else spec.body.kind

    def holds(self, robot: str) -> bool:
        truth = self.simulation.truth()
        return any(robot in one.holders for one in truth.samples.values()) or (
            robot in self.reals and self.reals[robot].body.held is not None
        )

    def bring(self, robot: str) -> None:
        """Carry the real body to where the simulated one stands."""
        self.reals[robot].body.place(self.simulation.truth().robots[robot])

    def exchange(self, robot: str, kind: str, minds: dict[str, str]) -> None:
        document = self.simulation.world.model_dump()
        wanted = {"external": True} if kind == REAL else {"body": kind, "external": False}
        for one in document["robots"]:
            one.update(wanted if one["name"] == robot else {})
        world = WorldFile.model_validate(document)
        self._tell_foreign()
        self.simulation.step_control_cycle()
        self.simulation.take_up(Edition(self.simulation.edition + 1, world), minds)

    def _send(self, message: Message) -> None:
        self.simulation.link.send(message)
        if message.receiver in self.reals:
            self.reals[message.receiver].deliver(message)

    def _note_grip(self, real: RealRobot, before: str | None) -> None:
        """Note what the real body has gripped or let go of, as the service knows it by its reports."""
        held = real.body.held
        if held == before:
            return
        at_s = self.simulation.clock.now_s()
        if held is not None:
            self._moved[held] = MovedSample(sample=held, place=real.name, at_s=at_s)
        elif before is not None:
            point = (real.body.jaws.real, real.body.jaws.imag)
            place = min(self.world.points, key=lambda name: dist(self.world.location(name).at, point))
            self._moved[before] = MovedSample(sample=before, place=place, at_s=at_s)

    def _tell_foreign(self) -> None:
        poses: dict[str, Pose] = {
            name: real.body.get_position()
            for name, real in self.reals.items()
            if self.simulation.world.robot(name).external
        }
        if not poses and not self._moved:
            return
        self._version += 1
        state = ForeignState(
            version=self._version,
            robots={name: (one.x_m, one.y_m, one.heading_rad) for name, one in poses.items()},
            samples=tuple(self._moved.values()),
        )
        self.simulation.link.send(
            Message(
                performative=Performative.INFORM,
                sender="service",
                receiver=WORLD,
                sent_at_s=self.simulation.clock.now_s(),
                body=state,
            )
        )


def run(failures_a_move: float, seed: int, *, real: bool = False) -> Ended:
    """The main job once.

    :param real: the robots have real bodies, too.
    """
    errand = to_store("sample_1", "door_1", "bay_7", "yard_1")
    scripts = errand.scripts()
    reals = [script.robot for script in scripts] if real else []
    with MovingRunner(load_world("sample_store"), seed=seed, real=reals) as runner:
        mover = Mover(runner, Random(seed), failures_a_move)
        if real:
            mover.kinds = WITH_REAL
            mover.every_s = EVERY_REAL_S
        runner.send(scripts)
        while len(runner.ended) < len(scripts) and runner.simulation.clock.now_s() < TIMEOUT_S:
            runner.step()
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
        crossings=mover.crossings,
        failures=mover.failures,
        words=tuple(f"{report.script_id}: {report.state} {report.detail}" for report in ended),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--failures", type=float, default=0.5, help="kills a move")
    parser.add_argument("--real", action="store_true", help="between simulated and real bodies")
    options = parser.parse_args()
    job = partial(run, options.failures, real=options.real)
    ended = list(run_parallel(job, range(options.seeds), workers=options.jobs))
    for seed, one in enumerate(ended):
        if not one.succeeded:
            print(f"seed {seed}: {dict(one.moves)} {one.words}")
    moves = sum((one.moves for one in ended), Counter[str]())
    failures = sum((one.failures for one in ended), Counter[str]())
    good = sum(one.succeeded for one in ended)
    crossings = sum(one.crossings for one in ended)
    longest_s = max(one.took_s for one in ended)
    print(
        f"{good}/{len(ended)} came true, longest {longest_s:.0f} s; moves {dict(moves)}, {crossings} of them between "
        f"programs; kills {dict(failures)}"
    )


if __name__ == "__main__":
    main()
