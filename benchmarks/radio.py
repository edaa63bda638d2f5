"""What becomes of the sample store's mission under a poor radio: `python -m benchmarks.radio [--seeds N] [NAME …]`.

The whole service and the simulated robots, in one process; a row a condition: missions that came true, what they took,
how often they were `unknown` meanwhile, and how many letters (telemetry apart) went each way.
"""

import argparse
import statistics
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from app.cli.truth import holds
from app.composition import RunningWorld, Service, make_engine
from app.goals.desk import GoalRequest
from app.plans.worker import PlanningWorker
from app.settings import Settings
from app.states import MissionState
from app.vocabulary import symbolic_all
from robots.link import InMemoryLink
from robots.wire import Message, PacketReport, PacketState, ScriptState, SymbolicFact, Telemetry
from robots.world import LinkSpec, WorldFile, load_world
from sim.agents import behavioural_agent
from sim.hub import Hub
from sim.pacing import Pacer
from sim.radio import Radio, Way
from sim.world import Simulation

GOAL = "move sample_1 to bay_7"
RATE = 20.0
"""World seconds a second, if the machine can."""
LIMIT_S = 1500.0
NAP_S = 0.002

IsWorst = Callable[[Message], bool]


class Watched(Radio):
    """A radio that counts what is sent, and goes out for `out_s` when the first message of a kind is sent."""

    def __init__(
        self, link: LinkSpec, *, robot: str, seed: int, tally: "Tally", worst: IsWorst | None, out_s: float
    ) -> None:
        super().__init__(link, robot=robot, seed=seed)
        self._tally, self._worst, self._out_s = tally, worst, out_s
        self.out_from_s: float | None = None

    def send(self, way: Way, message: Message, now_s: float) -> None:
        self._tally.note(way, message)
        if self.out_from_s is None and self._worst is not None and self._worst(message):
            self.out_from_s = now_s
        super().send(way, message, now_s)

    def in_contact(self, at_s: float) -> bool:
        begun_s = self.out_from_s
        out = begun_s is not None and begun_s <= at_s < begun_s + self._out_s
        return not out and super().in_contact(at_s)


@dataclass
class Tally:
    """What was sent: letters by way, and the ids of the reports that a packet has finished."""

    letters: Counter[Way] = field(default_factory=Counter)
    finished: dict[tuple[str, str], set[str]] = field(default_factory=dict)

    def note(self, way: Way, message: Message) -> None:
        body = message.body
        if isinstance(body, Telemetry):
            return
        self.letters[way] += 1
        if isinstance(body, PacketReport) and body.state is PacketState.FINISHED:
            self.finished.setdefault((body.script_id, body.packet_id), set()).add(message.id)

    @property
    def twice(self) -> list[tuple[str, str]]:
        """The packets that were carried out more than once."""
        return [packet for packet, ids in self.finished.items() if len(ids) > 1]


class FarWorld:
    """A simulated world in a thread of this process, its robots behind radios that are watched."""

    def __init__(
        self,
        world: WorldFile,
        *,
        seed: int,
        worst: IsWorst | None = None,
        out_s: float = 20.0,
        rate: float = RATE,
    ) -> None:
        self.tally = Tally()
        self.radios = {
            spec.name: Watched(
                world.link_of(spec), robot=spec.name, seed=seed, tally=self.tally, worst=worst, out_s=out_s
            )
            for spec in world.robots
        }
        link, far = InMemoryLink.pair()
        hub = Hub(far, list(self.radios), telemetry_gap_s=0.05, wall_s=time.monotonic, radios=self.radios)
        self.simulation = Simulation(world, make_agent=behavioural_agent, seed=seed, jitter_m=0.0, hub=hub)
        self.running = RunningWorld(
            file=world, link=link, clock=self.simulation.clock, rate=rate, run=self.simulation.run
        )
        self._pacer, self._stop = Pacer(time.monotonic, rate), threading.Event()
        self._thread = threading.Thread(target=self._run, name="far world", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()
        self.simulation.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            wait_s = self._pacer.wait_s(self.simulation.clock.now_s()) or 0.0
            if wait_s > 0:
                self._stop.wait(max(wait_s, NAP_S))
            else:
                self.simulation.step()


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a mission ended in the record, and whether the goal is true in the world itself; `took_s` from approval."""

    state: MissionState
    reason: str
    came_true: bool
    took_s: float
    seen: Sequence[str]
    letters: Mapping[Way, int]
    twice: Sequence[tuple[str, str]]
    facts: Sequence[str]


def carry_out(
    world: WorldFile,
    worker: PlanningWorker,
    folder: Path,
    *,
    seed: int = 0,
    goal: str = GOAL,
    worst: IsWorst | None = None,
    rate: float = RATE,
    limit_s: float = LIMIT_S,
) -> Ended:
    """State the goal, approve the plan, and wait for the mission's end."""
    settings = Settings(data=folder, token="a-token-of-the-benchmark", database_url=None)
    with (
        FarWorld(world, seed=seed, worst=worst, rate=rate) as far,
        Service(settings, [far.running], worker=worker) as service,
    ):
        clock = far.simulation.clock
        row = service.goals.submit(GoalRequest(world=world.name, text=goal), actor="benchmark")
        while (row := service.goals.get(row.id)).state in ("submitted", "planning"):
            time.sleep(0.05)
        if row.plan_id is None:
            raise RuntimeError(f"{goal}: {row.state}, {row.reason}")
        begun_s = clock.now_s()
        _, mission_id = service.plans.approve(row.plan_id, actor="benchmark", comment="")
        seen: list[str] = []
        while True:
            mission, scripts = service.missions.get(mission_id)
            if seen[-1:] != [mission.state]:
                seen.append(mission.state)
            if MissionState(mission.state).ended or clock.now_s() > begun_s + limit_s:
                break
            time.sleep(0.05)
        truth = far.simulation.truth()
        wanted = [SymbolicFact.model_validate(fact) for fact in row.goal]
        facts = _facts(service, world.name)
        failed = [f"{s.robot}: {s.state} {s.detail}" for s in scripts if s.state != ScriptState.FINISHED]
        return Ended(
            state=MissionState(mission.state),
            reason="; ".join([mission.reason, *failed]) if mission.state != "completed" else "",
            came_true=all(holds(fact, world, truth) for fact in wanted),
            took_s=clock.now_s() - begun_s,
            seen=seen,
            letters=dict(far.tally.letters),
            twice=far.tally.twice,
            facts=facts,
        )


def _facts(service: Service, world: str) -> list[str]:
    with service.database.read() as session:
        facts = service._core.facts.facts(session, world)
    return sorted(str(fact) for fact in symbolic_all(facts, service._core.knowledge_base))


def sends(kind: str) -> IsWorst:
    return lambda message: message.body.kind == kind


def finishes(message: Message) -> bool:
    return isinstance(message.body, PacketReport) and message.body.state is PacketState.FINISHED


CONDITIONS: Mapping[str, tuple[Mapping[str, object], IsWorst | None]] = {
    "perfect": ({}, None),
    "half lost": ({"loss": 0.5}, None),
    "half lost, late, repeated": ({"loss": 0.5, "delay_s": 0.5, "jitter_s": 2.0, "duplication": 0.3}, None),
    "20 s out at a script": ({}, sends("script_request")),
    "20 s out at an agreement": ({}, sends("acknowledgement")),
    "20 s out at a packet's end": ({}, finishes),
    "20 s out at a script's end": ({}, sends("script_report")),
    "20 s out in every 40": ({"outages": [{"start_s": 10, "end_s": 30, "every_s": 40}]}, None),
    "in contact 10 s in 120": ({"contacts": [{"for_s": 10, "every_s": 120}]}, None),
    "5 s of light-time": ({"light_time_s": 5.0}, None),
    "all of it": (
        {
            "loss": 0.5,
            "jitter_s": 1.0,
            "light_time_s": 2.0,
            "duplication": 0.2,
            "contacts": [{"for_s": 20, "every_s": 90}],
        },
        None,
    ),
}


def with_link(link: Mapping[str, object], name: str = "sample_store") -> WorldFile:
    """A world that ships with us, with another radio."""
    return WorldFile.model_validate({**load_world(name).model_dump(), "link": link})


def told(name: str, ended: Sequence[Ended]) -> str:
    good = [one for one in ended if one.came_true and one.state is MissionState.COMPLETED]
    spans = [one.took_s for one in good]
    took = f"{statistics.median(spans):.0f} ({min(spans):.0f} to {max(spans):.0f})" if spans else "–"
    unknown = sum("unknown" in one.seen for one in ended)
    twice = sum(len(one.twice) for one in ended)
    down, up = (statistics.median(one.letters.get(way, 0) for one in ended) for way in (Way.DOWN, Way.UP))
    return f"| {name} | {len(good)} of {len(ended)} | {took} | {unknown} | {twice} | {down:.0f} | {up:.0f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(CONDITIONS)}; all unless told")
    parser.add_argument("--seeds", type=int, default=5)
    options = parser.parse_args()
    worker = PlanningWorker(make_engine)
    worker.warm_up().result()
    print("| radio | came true | seconds | unknown meanwhile | packets twice | letters down | up |")
    print("|---|---|---|---|---|---|---|", flush=True)
    try:
        for name in options.names or CONDITIONS:
            link, worst = CONDITIONS[name]
            ended = []
            for seed in range(options.seeds):
                with tempfile.TemporaryDirectory() as folder:
                    ended.append(carry_out(with_link(link), worker, Path(folder), seed=seed, worst=worst))
                if not ended[-1].came_true or ended[-1].state is not MissionState.COMPLETED:
                    print(f"  {name}, seed {seed}: {ended[-1]}")
            print(told(name, ended), flush=True)
    finally:
        worker.close()


if __name__ == "__main__":
    main()
