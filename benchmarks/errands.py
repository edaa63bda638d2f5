"""Errands in the sample store with scripts written by hand: to store a sample, to retrieve one.

Here nothing is planned; the scripts are what the mission organiser would write for these goals.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import dist

from robots.wire import (
    BehaviourPacket,
    BehaviourScript,
    Clearance,
    Message,
    PacketReport,
    PacketState,
    Performative,
    Receipt,
    ScriptReport,
    ScriptRequest,
    ScriptState,
    SymbolicFact,
)
from robots.world import WorldFile
from sim.agents import behavioural_agent
from sim.world import AgentMaker, Simulation

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
    """Drive from place to place, from home on."""
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


class Crew:
    """A simulated world whose robots are given scripts; keeps their reports, confirms and clears as a service."""

    def __init__(
        self,
        world: WorldFile,
        *,
        seed: int,
        jitter_m: float = 0.4,
        make_agent: AgentMaker = behavioural_agent,
    ) -> None:
        self.world = world
        self.simulation = Simulation(world, make_agent=make_agent, seed=seed, jitter_m=jitter_m)
        self.reports: list[PacketReport] = []
        self.ended: dict[str, ScriptReport] = {}
        self.ran: list[Ran] = []
        self._running_s: dict[str, float] = {}
        self._changed_s: dict[str, float] = {}
        self._retries: dict[str, int] = {}
        self._packets: dict[tuple[str, str], BehaviourPacket] = {}
        self._scripts: list[BehaviourScript] = []
        self._over: set[tuple[str, str]] = set()
        self._seen: set[str] = set()

    def send(self, scripts: Sequence[BehaviourScript]) -> None:
        self._scripts += scripts
        for each in scripts:
            for step in each.packets:
                self._packets[each.id, step.id] = step
            self._say(each.robot, Performative.REQUEST, ScriptRequest(script=each))

    def run(
        self,
        scripts: Sequence[BehaviourScript],
        *,
        timeout_s: float = 600.0,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> bool:
        """Hand out scripts and wait until each has ended; True if all did. `meanwhile` is called at 20 Hz."""
        self.send(scripts)
        names = {each.id for each in scripts}

        def over() -> bool:
            self._hear()
            meanwhile()
            return names <= set(self.ended)

        return self.simulation.run_until(over, timeout_s=timeout_s)

    def _hear(self) -> None:
        for message in self.simulation.link.receive():
            body = message.body
            if isinstance(body, PacketReport | ScriptReport):
                self._say(message.sender, Performative.CONFIRM, Receipt(), in_reply_to=message.id)
                if message.id not in self._seen:
                    self._seen.add(message.id)
                    self._note(message.sender, body)

    def _note(self, robot: str, report: PacketReport | ScriptReport) -> None:
        if isinstance(report, ScriptReport):
            self.ended[report.script_id] = report
            return
        self.reports.append(report)
        if report.state is PacketState.INITIALIZING:
            self._changed_s[robot] = report.at_s
            self._retries[robot] = 0
        elif report.state is PacketState.RUNNING and report.detail:
            self._retries[robot] += 1
        elif report.state is PacketState.RUNNING:
            self._running_s[robot] = report.at_s
        elif report.state in (PacketState.FINISHED, PacketState.FAILED):
            self.ran.append(self._figure(robot, report))
        if report.state is PacketState.FINISHED:
            self._over.add((report.script_id, report.packet_id))
            self._clear(report.packet_id)

    def _clear(self, action: str) -> None:
        """Tell the robots that wait for it that an action has ended, once all who do it have said so."""
        doers = [each for each in self._scripts if any(step.id == action for step in each.packets)]
        if all((each.id, action) in self._over for each in doers):
            for each in self._scripts:
                if any(action in step.after for step in each.packets):
                    clearance = Clearance(script_id=each.id, ended=(action,))
                    self._say(each.robot, Performative.REQUEST, clearance)

    def _figure(self, robot: str, report: PacketReport) -> Ran:
        step = self._packets[report.script_id, report.packet_id]
        since_s = self._running_s.get(robot, report.at_s)
        return Ran(
            robot=robot,
            tag=step.tag,
            distance_m=self._planned_m(step),
            waited_s=since_s - self._changed_s[robot],
            ran_s=report.at_s - since_s,
            finished=report.state is PacketState.FINISHED,
            retries=self._retries[robot],
        )

    def _planned_m(self, step: BehaviourPacket) -> float:
        """From place to place, as a planner measures; 0 for a packet that stays at one."""
        places = (step.arguments.get("ref1"), step.arguments.get("ref2"))
        if step.tag not in ("NAVIGATE", "TRANSPORT") or None in places:
            return 0.0
        return dist(*(self.world.location(str(place)).at for place in places))

    def _say(
        self, robot: str, performative: Performative, body: object, in_reply_to: str | None = None
    ) -> None:
        message = Message.model_validate(
            {
                "performative": performative,
                "sender": "service",
                "receiver": robot,
                "sent_at_s": self.simulation.clock.now_s(),
                "in_reply_to": in_reply_to,
                "body": body,
            }
        )
        self.simulation.link.send(message)


def carry_out(world: WorldFile, *errands: Errand, seed: int, jitter_m: float = 0.4) -> Result:
    """Run errands side by side to their end and look whether the goals became true in the world itself."""
    crew = Crew(world, seed=seed, jitter_m=jitter_m)
    try:
        all_ended = crew.run([each for errand in errands for each in errand.scripts()])
        truth = crew.simulation.truth()
        astray = [errand for errand in errands if truth.samples[errand.sample].ref != errand.goal]
        reports = list(crew.ended.values())
        finished = all_ended and all(report.state is ScriptState.FINISHED for report in reports)
        words = [f"{report.script_id}: {report.state} {report.detail}" for report in reports]
        words += [f"{e.sample} is in {truth.samples[e.sample].ref}, not in {e.goal}" for e in astray]
        return Result(succeeded=finished and not astray, took_s=truth.time_s, ran=crew.ran, words=words)
    finally:
        crew.simulation.close()
