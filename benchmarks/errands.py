"""Errands in the sample store with scripts written by hand: to store a sample, to retrieve one.

Here nothing is planned; the scripts are what the mission organiser would write for these goals.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import dist

from robots.wire import BehaviourPacket, BehaviourScript, PacketState, ScriptState, SymbolicFact
from robots.world import WorldFile
from sim.trials.script_runner import ScriptRunner

TIMEOUT_S = 120.0
WAIT_S = 400.0


def fact(predicate: str, *args: str) -> SymbolicFact:
    return SymbolicFact(predicate=predicate, args=args)


def packet(
    number: int, tag: str, *, awaits: Sequence[SymbolicFact] = (), **arguments: str
) -> BehaviourPacket:
    return BehaviourPacket(
        id=f"{number}_{tag.lower()}",
        tag=tag,
        arguments=arguments,
        awaits=tuple(awaits),
        expected_start_s=0.0,
        expected_duration_s=10.0,
        timeout_s=TIMEOUT_S,
        wait_timeout_s=WAIT_S,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """One robot's part: fetch the sample at one place, deposit it at another."""

    robot: str
    fetch: str
    deposit: str


def script(leg: Leg, sample: str, *, handed_over: bool) -> BehaviourScript:
    """NAVIGATE, DOCK, TRANSPORT, RELEASE2. `handed_over`: another robot brings the sample to `fetch`."""
    awaits = [fact("in", sample, leg.fetch)] if handed_over else []
    me, home, there = leg.robot, f"home_{leg.robot}", leg.deposit
    packets = (
        packet(1, "NAVIGATE", robot=me, rel1="near", ref1=home, rel2="near", ref2=leg.fetch),
        packet(2, "DOCK", object=sample, robot=me, rel1="near", ref1=leg.fetch, awaits=awaits),
        packet(3, "TRANSPORT", object=sample, robot=me, rel1="at", ref1=leg.fetch, rel2="near", ref2=there),
        packet(4, "RELEASE2", object=sample, robot=me, rel1="at", ref1=leg.fetch, rel2="near", ref2=there),
    )
    return BehaviourScript(id=f"{me}_{sample}_{there}", mission_id="errand", robot=me, packets=packets)


def tour(robot: str, places: Sequence[str]) -> BehaviourScript:
    """Drive from home to these places in turn."""
    stops = [f"home_{robot}", *places]
    legs = enumerate(itertools.pairwise(stops))
    packets = [
        packet(n, "NAVIGATE", robot=robot, rel1="near", ref1=one, rel2="near", ref2=next_one)
        for n, (one, next_one) in legs
    ]
    return BehaviourScript(id=f"tour_{robot}", mission_id="tour", robot=robot, packets=tuple(packets))


@dataclass(frozen=True, slots=True, kw_only=True)
class Errand:
    """A sample's way through the store, leg by leg."""

    sample: str
    legs: tuple[Leg, ...]

    @property
    def goal(self) -> str:
        return self.legs[-1].deposit

    def scripts(self) -> list[BehaviourScript]:
        return [script(leg, self.sample, handed_over=number > 0) for number, leg in enumerate(self.legs)]


def to_store(sample: str, door: str, bay: str, yard_robot: str) -> Errand:
    """From a door over the aisle's interchange to a bay."""
    aisle = _aisle_of(bay)
    interchange = f"interchange_{aisle}"
    legs = (
        Leg(robot=yard_robot, fetch=door, deposit=interchange),
        Leg(robot=f"store_{aisle}", fetch=interchange, deposit=bay),
    )
    return Errand(sample=sample, legs=legs)


def to_retrieve(sample: str, bay: str, door: str, yard_robot: str) -> Errand:
    """From a bay over the aisle's interchange to a door."""
    aisle = _aisle_of(bay)
    interchange = f"interchange_{aisle}"
    legs = (
        Leg(robot=f"store_{aisle}", fetch=bay, deposit=interchange),
        Leg(robot=yard_robot, fetch=interchange, deposit=door),
    )
    return Errand(sample=sample, legs=legs)


def _aisle_of(bay: str) -> int:
    return 1 if int(bay.removeprefix("bay_")) <= 6 else 2


def with_sample(world: WorldFile, sample: str, at: str, *, vacant: str) -> WorldFile:
    """The world with a sample at a place, and none at another; the other samples stay."""
    kept = [s for s in world.samples if s.name != sample and s.at not in (at, vacant)]
    return world.model_validate(
        {**world.model_dump(), "samples": [*(s.model_dump() for s in kept), {"name": sample, "at": at}]}
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Ran:
    """One packet that ran to its end."""

    robot: str
    tag: str
    distance_m: float
    waited_s: float
    ran_s: float
    finished: bool
    retries: int


@dataclass(slots=True, kw_only=True)
class Result:
    """How an errand ended. `succeeded`: in the simulated world itself, and in every script's own report."""

    succeeded: bool
    took_s: float
    ran: list[Ran] = field(default_factory=list)
    words: list[str] = field(default_factory=list)


def figures(runner: ScriptRunner) -> list[Ran]:
    """The packets that ran to their end, from the runner's reports."""
    steps = {(script.id, step.id): step for script in runner.scripts for step in script.packets}
    robots = {script.id: script.robot for script in runner.scripts}
    changed_s: dict[str, float] = {}
    running_s: dict[str, float] = {}
    retries: dict[str, int] = {}
    ran: list[Ran] = []
    for report in runner.reports:
        robot = robots[report.script_id]
        if report.state is PacketState.INITIALIZING:
            changed_s[robot], retries[robot] = report.at_s, 0
        elif report.state is PacketState.RUNNING and report.detail:
            retries[robot] += 1
        elif report.state is PacketState.RUNNING:
            running_s[robot] = report.at_s
        elif report.state in (PacketState.FINISHED, PacketState.FAILED):
            step, since_s = steps[report.script_id, report.packet_id], running_s.get(robot, report.at_s)
            ran.append(
                Ran(
                    robot=robot,
                    tag=step.tag,
                    distance_m=_planned_m(step, runner.world),
                    waited_s=since_s - changed_s[robot],
                    ran_s=report.at_s - since_s,
                    finished=report.state is PacketState.FINISHED,
                    retries=retries[robot],
                )
            )
    return ran


def _planned_m(step: BehaviourPacket, world: WorldFile) -> float:
    """From place to place, as a planner measures; 0 for a packet that stays at one."""
    places = (step.arguments.get("ref1"), step.arguments.get("ref2"))
    if step.tag not in ("NAVIGATE", "TRANSPORT") or None in places:
        return 0.0
    return dist(*(world.location(str(place)).at for place in places))


def carry_out(world: WorldFile, *errands: Errand, seed: int, jitter_m: float = 0.4) -> Result:
    """Run errands in parallel to their end and check the goals in the world itself."""
    with ScriptRunner(world, seed=seed, jitter_m=jitter_m) as runner:
        all_ended = runner.run([each for errand in errands for each in errand.scripts()])
        truth = runner.simulation.truth()
    astray = [errand for errand in errands if truth.samples[errand.sample].ref != errand.goal]
    reports = list(runner.ended.values())
    finished = all_ended and all(report.state is ScriptState.FINISHED for report in reports)
    words = [f"{report.script_id}: {report.state} {report.detail}" for report in reports]
    words += [f"{e.sample} is in {truth.samples[e.sample].ref}, not in {e.goal}" for e in astray]
    return Result(succeeded=finished and not astray, took_s=truth.time_s, ran=figures(runner), words=words)
