"""Missions under poor radios: `python -m benchmarks.radio [--seeds N] [--world W --goal G] [NAME …]`.

The whole service and the simulated robots, in one process; a row a condition: missions that came true, what they took,
how often they were `unknown` meanwhile, and how many letters (messages but telemetry) went each way.
"""

import argparse
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.cli.ground_truth import holds
from app.composition import Service, make_engine
from app.domain.lifecycles.mission import MissionState
from app.domain.world_model.vocabulary import symbolic_all
from app.planning.goal_service import GoalRequest
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from benchmarks.far_world import RATE, FarWorld
from benchmarks.planned import planned
from robots.wire import Message, PacketReport, PacketState, ScriptState, SymbolicFact, Telemetry
from robots.world import LinkSpec, WorldFile, load_world
from sim.world.radio import Direction, Radio

GOAL = "move sample_1 to bay_7"
LIMIT_S = 1500.0
OUT_S = 20.0
"""Duration of a radio outage from the worst instant on."""

IsWorst = Callable[[Message], bool]
Meanwhile = Callable[[Service, str], None]


class Watched(Radio):
    """A radio that counts what is sent, and goes out for `out_s` when the first message of a kind is sent."""

    def __init__(
        self, link: LinkSpec, *, robot: str, seed: int, tally: "Tally", worst: IsWorst | None, out_s: float
    ) -> None:
        super().__init__(link, robot=robot, seed=seed)
        self._tally, self._worst, self._out_s = tally, worst, out_s
        self.out_from_s: float | None = None

    def send(self, way: Direction, message: Message, now_s: float) -> None:
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
    """What was sent: letters by direction, and the ids of the reports that a packet has finished."""

    letters: Counter[Direction] = field(default_factory=Counter)
    finished: dict[tuple[str, str], set[str]] = field(default_factory=dict)

    def note(self, way: Direction, message: Message) -> None:
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a mission ended in the record, and whether the goal is true in the world itself; `took_s` from approval.
    `events`: of the mission; `done_by`: by packet, who has done it in its robot's stead.
    """

    state: MissionState
    reason: str
    came_true: bool
    took_s: float
    seen: Sequence[str]
    letters: Mapping[Direction, int]
    twice: Sequence[tuple[str, str]]
    facts: Sequence[str]
    events: Sequence[Mapping[str, Any]]
    done_by: Mapping[str, str]


def carry_out(
    world: WorldFile,
    worker: PlanningWorker,
    folder: Path,
    *,
    seed: int = 0,
    goal: str = GOAL,
    worst: IsWorst | None = None,
    out_s: float = OUT_S,
    rate: float = RATE,
    limit_s: float = LIMIT_S,
    patience_s: float = 10.0,
    delegate: bool = False,
    meanwhile: Meanwhile = lambda service, mission_id: None,
) -> Ended:
    """State the goal, approve the plan, and wait for the mission's end.

    :param out_s: how long a radio is out from its `worst` message on.
    :param patience_s: wall-clock seconds that a robot may take to answer beyond its radio's delay.
    :param delegate: the approval lets robots put legs to each other.
    :param meanwhile: called repeatedly while the mission is under way.
    """
    settings = Settings(
        data=folder, token="a-token-of-the-benchmark", database_url=None, answer_patience_s=patience_s
    )
    tally = Tally()
    radios = {
        spec.name: Watched(
            world.link_of(spec), robot=spec.name, seed=seed, tally=tally, worst=worst, out_s=out_s
        )
        for spec in world.robots
    }
    with (
        FarWorld(world, seed=seed, radios=radios, rate=rate) as far,
        Service(settings, [far.running], worker=worker) as service,
    ):
        clock = far.simulation.clock
        stated, plan_id = planned(service, GoalRequest(world=world.name, text=goal))
        begun_s = clock.now_s()
        _, mission_id = service.plans.approve(plan_id, actor="benchmark", delegate=delegate)
        seen = _followed(service, mission_id, lambda: clock.now_s() > begun_s + limit_s, meanwhile)
        mission, scripts = service.missions.get(mission_id)
        truth = far.simulation.truth()
        wanted = [SymbolicFact.model_validate(fact) for fact in stated.goal]
        facts = _facts(service, world.name)
        failed = [f"{s.robot}: {s.state} {s.detail}" for s in scripts if s.state != ScriptState.FINISHED]
        return Ended(
            state=MissionState(mission.state),
            reason="; ".join([mission.reason, *failed]) if mission.state != "completed" else "",
            came_true=all(holds(fact, world, truth) for fact in wanted),
            took_s=clock.now_s() - begun_s,
            seen=seen,
            letters=dict(tally.letters),
            twice=tally.twice,
            facts=facts,
            events=[
                {"type": row.type, **row.data}
                for row in service.core.events.since(0, limit=10_000)
                if row.subject == mission_id
            ],
            done_by={
                name: packet["delegated_to"]
                for script in scripts
                for name, packet in script.packets.items()
                if "delegated_to" in packet
            },
        )


def _followed(
    service: Service, mission_id: str, late: Callable[[], bool], meanwhile: Meanwhile
) -> Sequence[str]:
    """The successive states of a mission until it ends or it is `late`."""
    seen: list[str] = []
    while True:
        mission, _ = service.missions.get(mission_id)
        if seen[-1:] != [mission.state]:
            seen.append(mission.state)
        if MissionState(mission.state).ended or late():
            return seen
        meanwhile(service, mission_id)
        time.sleep(0.05)


def _facts(service: Service, world: str) -> list[str]:
    with service.database.read() as session:
        facts = service.core.facts.facts(session, world)
    return sorted(str(fact) for fact in symbolic_all(facts, service.core.knowledge_base))


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
    """A shipped world with another radio."""
    return WorldFile.model_validate({**load_world(name).model_dump(), "link": link})


def told(name: str, ended: Sequence[Ended]) -> str:
    good = [one for one in ended if one.came_true and one.state is MissionState.COMPLETED]
    spans = [one.took_s for one in good]
    took = f"{statistics.median(spans):.0f} ({min(spans):.0f} to {max(spans):.0f})" if spans else "–"
    unknown = sum("unknown" in one.seen for one in ended)
    twice = sum(len(one.twice) for one in ended)
    down, up = (
        statistics.median(one.letters.get(way, 0) for one in ended) for way in (Direction.DOWN, Direction.UP)
    )
    return f"| {name} | {len(good)} of {len(ended)} | {took} | {unknown} | {twice} | {down:.0f} | {up:.0f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(CONDITIONS)}; default: all")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--world", default="sample_store")
    parser.add_argument("--goal", default=GOAL)
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
                    world = with_link(link, options.world)
                    ended.append(
                        carry_out(world, worker, Path(folder), seed=seed, goal=options.goal, worst=worst)
                    )
                if not ended[-1].came_true or ended[-1].state is not MissionState.COMPLETED:
                    print(f"  {name}, seed {seed}: {ended[-1]}")
            print(told(name, ended), flush=True)
    finally:
        worker.close()


if __name__ == "__main__":
    main()
