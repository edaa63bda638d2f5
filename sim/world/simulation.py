"""A simulated world: scene, bodies, agents, clock.

Bit-identical for the same file, seed and messages, and for the same snapshot and messages.
"""

import uuid
from collections.abc import Callable, Mapping, Sequence
from math import hypot

import numpy as np

from robots.executive.breakpoints import Halt
from robots.executive.embodiment import EmbodimentMemory
from robots.executive.hand_over import MindUnfit, read_document
from robots.executive.memory import AgentMind, RobotMemory
from robots.link import InMemoryLink
from robots.physical.body import Pose, Readings, Sensor
from robots.wire import WORLD, ForeignState, Message, Performative, WorldChange, WorldEdition
from robots.world import Edition, RobotSpec, Sample, WorldFile, digest_of
from robots.world.walls import panels_of
from sim.bodies import FloorMap, SimulatedBody, make_bodies
from sim.bodies.exchangeable import ExchangeableBody
from sim.clock import CONTROL_S, TICKS_PER_CONTROL, WorldClock
from sim.physics.jaws import Jaws
from sim.physics.scene import Scene
from sim.physics.sensors import InfraRed, Whiskers
from sim.snapshot import SampleState, StreamState, WorldSnapshot
from sim.truth import SampleTruth, Truth, place_at
from sim.world.agent import Agent, AgentFactory, AgentSetup, TakesMinds
from sim.world.agent_group import AgentGroup, LocalGroup, RemoteGroup
from sim.world.chargers import Chargers
from sim.world.foreign import ForeignRobots
from sim.world.hub import Hub
from sim.world.peripherals import Peripherals
from sim.world.placement import Placement
from sim.world.radio import peers_of, radios_of


class Simulation:
    """A world in this process. `step` advances it by 1/60 s. `run` identifies it, however often it is resumed.

    :param hub: routes the service's messages; without one, `link` is the service's end of an in-memory link.
    :param jitter_m: how far start poses may be from the world file's; headings are then random, too.
    :param world: as in its file. :param edition: the world as changed since; by default, that of the snapshot.
    :param snapshot: state to resume from; `seed` and `jitter_m` are then ignored.
    :param processes: how many the agents are spread over, this one included; the run is the same for any number.
    """

    def __init__(
        self,
        world: WorldFile,
        *,
        make_agent: AgentFactory,
        seed: int = 0,
        jitter_m: float = 0.4,
        hub: Hub | None = None,
        snapshot: WorldSnapshot | None = None,
        edition: Edition | None = None,
        processes: int = 1,
    ) -> None:
        self.run = snapshot.run if snapshot else uuid.uuid4().hex
        self.clock = WorldClock()
        self._seed = snapshot.seed if snapshot else seed
        self._jitter_m = jitter_m
        self._digest = digest_of(world)
        self._make_agent = make_agent
        self._processes = processes
        self._far: list[RemoteGroup] = []
        self._breakpoints: Mapping[str, frozenset[str]] = {}
        self._near: LocalGroup | None = None
        self._exchangeable: dict[str, ExchangeableBody] = {}
        self._edition = _newest(world, edition, snapshot)
        self._delivered = snapshot.delivered if snapshot else frozenset[str]()
        self.link, robots_end = InMemoryLink.pair()
        self.hub = hub or Hub(robots_end, ())
        self._build(snapshot)

    @property
    def edition(self) -> int:
        """The number of the present edition of the world."""
        return self._edition.number

    @property
    def world(self) -> WorldFile:
        """The present edition of the world."""
        return self._edition.world

    def _build(self, snapshot: WorldSnapshot | None, minds: Mapping[str, str] | None = None) -> None:
        """Make scene, bodies, sensors and agents, from a snapshot if there is one; see `take_up`."""
        world = self.world
        self._document = world.model_dump_json(exclude_defaults=True) if self._edition.number else ""
        known = {one.name for one in world.samples}
        unseen = (one for one in world.deliveries if one.name in self._delivered - known)
        self._samples: tuple[Sample, ...] = (*world.samples, *unseen)
        self.hub.connect(radios_of(world, self._seed), peers_of(world, self._seed))
        names = [spec.name for spec in world.simulated]
        seeds = np.random.SeedSequence(self._seed).spawn(len(names) + 1)
        placement_rng, *streams = [np.random.default_rng(each) for each in seeds]
        self._rngs = dict(zip(names, streams, strict=True))
        if snapshot is not None:
            snapshot = snapshot.only(robots=names, samples=[one.name for one in self._samples])
        panels = panels_of(world.walls)
        self._placement = (
            Placement.restore(world, self._samples, snapshot, panels, placement_rng)
            if snapshot
            else Placement.draw(world, panels, placement_rng, self._jitter_m)
        )
        self.scene = Scene(panels, self._placement.rovers, self._placement.samples, world.slopes)
        for rock in self._placement.rocks:
            self.scene.put_rock(rock)
        for place in world.places:
            self.scene.put_beacon(place.at)
        self.peripherals = Peripherals(
            world,
            scene=self.scene,
            hub=self.hub,
            clock=self.clock,
            run=self.run,
            states=snapshot.peripherals if snapshot else {},
        )
        self._jaws = Jaws(self.scene, names, self._placement.samples)
        self._whiskers = Whiskers(world.simulated)
        reach = {spec.name: {place.name for place in world.reach_of(spec)} for spec in world.simulated}
        foreign = [spec.name for spec in world.robots if spec.external]
        self._infra_red = InfraRed(world.places, reach, self._samples, foreign)
        self._foreign = ForeignRobots(world, self._samples, self.scene, self._jaws, foreign)
        self.bodies = make_bodies(
            world.simulated,
            scene=self.scene,
            floor=FloorMap(panels, self._placement.rocks),
            jaws=self._jaws,
            # A body in place of a former one counts on from where that one reckoned to be.
            told={**self._placement.told, **({} if snapshot is None else snapshot.reckoned)},
            rngs=self._rngs,
        )
        self._exchangeable = {
            name: self._exchangeable.get(name) or ExchangeableBody(body) for name, body in self.bodies.items()
        }
        for name, body in self.bodies.items():
            self._exchangeable[name].body = body
        self._chargers = Chargers(world)
        self._touched: set[str] = set()
        if snapshot is not None:
            self._restore(snapshot)
            self._foreign.restore(snapshot.foreign)
        self._sense()
        memories = dict(snapshot.robots) if snapshot else {}
        for spec in world.simulated:
            if minds and spec.name in minds and spec.name not in memories:
                memories[spec.name] = RobotMemory(mind=self._taken_mind(spec, minds[spec.name]))
        setups = [self._agent_setup(spec, memories.get(spec.name)) for spec in world.simulated]
        shares = np.array_split(np.arange(len(setups)), self._processes)
        mine, *others = [[setups[n] for n in share] for share in shares]
        self._make_far([share for share in others if share])
        self._near = LocalGroup(self._make_agent, mine, before=self._near)
        self.agents: Mapping[str, Agent] = self._near.agents
        """Those in this process."""
        self._groups: tuple[AgentGroup, ...] = (self._near, *self._far)
        if self._breakpoints:
            self.break_at(self._breakpoints)

    def _make_far(self, shares: Sequence[Sequence[AgentSetup]]) -> None:
        """Have each share run by a process of its own, by one that is there already if possible."""
        for group in self._far[len(shares) :]:
            group.close()
        self._far = self._far[: len(shares)]
        for group, share in zip(self._far, shares, strict=False):
            group.make(self._make_agent, share, self.clock)
        new = shares[len(self._far) :]
        self._far += [RemoteGroup(self._make_agent, share, self.clock) for share in new]

    def _taken_mind(self, spec: RobotSpec, text: str) -> AgentMind:
        """The mind of a document, at rest until it is told to go on.

        :raises MindUnfit: if the robot's software here cannot carry it on.
        """
        document = read_document(text)
        agent = self._make_agent(self._agent_setup(spec, None))
        if not isinstance(agent, TakesMinds):
            raise MindUnfit(f"the software of {spec.name} takes no minds")
        if (reason := agent.take_over(document, body=None)) is not None:
            raise MindUnfit(reason)
        resting = EmbodimentMemory(fence=document.fence, rests=True, is_handed_over=True)
        return document.mind.model_copy(update={"embodiment": resting})

    def take_up(self, edition: Edition, minds: Mapping[str, str] | None = None) -> None:
        """Go on in a changed world; between two control cycles.

        The world is resumed from its snapshot: what was there goes on, what is new is placed as at a start. Robots'
        software goes on with all that it has in mind.

        :param minds: of robots that were not simulated before, the texts of the documents that their own software has
            handed over (`robots.executive.hand_over`).
        :raises Exception: whatever making the changed world raises; the present one then goes on.
        """
        snapshot = self.snapshot(is_whole=True)
        before = self._edition
        self._edition = edition
        try:
            self._rebuild(snapshot, minds)
        except Exception:
            self._edition = before
            self._rebuild(snapshot)
            raise

    def _rebuild(self, snapshot: WorldSnapshot, minds: Mapping[str, str] | None = None) -> None:
        self.scene.close()
        self._build(snapshot, minds)

    def _deliver(self) -> None:
        """Put down the samples whose delivery is due, if their places are free."""
        made = self._delivered.union(one.name for one in self.world.samples)
        now_s = self.clock.now_s()
        due = [one for one in self.world.deliveries if one.after_s <= now_s and one.name not in made]
        taken = {self._sample_truth(one).place for one in self._samples} if due else set()
        if new := {one.name for one in due if one.at not in taken}:
            snapshot = self.snapshot(is_whole=True)
            self._delivered |= new
            self._rebuild(snapshot)

    def snapshot(self, *, is_whole: bool = False) -> WorldSnapshot:
        """Everything needed to resume from here; to be taken between two steps.

        :param is_whole: robots' memories have what does not outlive a power failure, too.
        """
        return WorldSnapshot(
            run=self.run,
            digest=self._digest,
            edition=self._edition.number,
            document=self._document,
            delivered=self._delivered,
            seed=self._seed,
            ticks=self.clock.ticks,
            rovers=self._poses(),
            told=dict(self._placement.told),
            samples={
                one.name: SampleState(
                    point=self.scene.sample_point(one.name)[:2],
                    heading_rad=self.scene.sample_heading(one.name),
                    velocity_m_s=self.scene.sample_velocity(one.name),
                )
                for one in self._samples
            },
            rocks=self._placement.rocks,
            jaws=self._jaws.snapshot(),
            bodies={name: body.state() for name, body in self.bodies.items()},
            streams={name: StreamState.of(rng) for name, rng in self._rngs.items()},
            touched=frozenset(self._touched),
            robots=self._memories(is_whole=is_whole),
            peripherals=self.peripherals.snapshot(),
            foreign=self._foreign.snapshot(),
        )

    def _restore(self, snapshot: WorldSnapshot) -> None:
        """Restore what the placement does not contain: time, grips, bodies, random streams."""
        self.clock.ticks = snapshot.ticks
        self._touched = set(snapshot.touched)
        self._jaws.restore(snapshot.jaws)
        for name in snapshot.rovers:
            self.bodies[name].restore(snapshot.bodies[name])
            snapshot.streams[name].restore(self._rngs[name])

    @property
    def is_still(self) -> bool:
        """True while no robot is commanded to move, no ball rolls, and no door, hatch or lift moves."""
        is_driven = any(body.is_commanded for body in self.bodies.values())
        return self.peripherals.is_still and not is_driven and not self.scene.is_rolling

    def step(self) -> None:
        """One tick of 1/60 s; every third begins with the agents' sensing and acting.

        :raises LinkClosed: if the service is gone.
        """
        if self.clock.ticks % TICKS_PER_CONTROL == 0:
            self.hub.receive(self.clock.now_s())
            for message in self.hub.to_world():
                self._answer(message)
            self._deliver()
            self._drain_batteries()
            self._sense()
            self._tick_agents()
            self.peripherals.tick(CONTROL_S)
            self.hub.flush(self.clock.now_s())
        for body in self.bodies.values():
            body.drive()
        self.scene.step()
        self._note_touches()
        self._jaws.carry()
        self.clock.ticks += 1

    def step_control_cycle(self) -> None:
        """Step until the agents' next turn: three ticks, fewer after a snapshot of an instant between two turns."""
        for _ in range(TICKS_PER_CONTROL - self.clock.ticks % TICKS_PER_CONTROL):
            self.step()

    def run_until(self, done: Callable[[], bool], *, timeout_s: float) -> bool:
        """Step until `done`, checked at 20 Hz, or the timeout in world time; True if done."""
        end_s = self.clock.now_s() + timeout_s
        while not done():
            if self.clock.now_s() >= end_s:
                return False
            for _ in range(TICKS_PER_CONTROL):
                self.step()
        return True

    def break_at(self, rules: Mapping[str, frozenset[str]]) -> None:
        """Set breakpoints on rules, "guard:3" and the like, by robot, in place of those before.

        What a rule commits to at one is held back until the robot's next turn.
        """
        self._breakpoints = rules
        for group in self._groups:
            group.break_at(rules)

    def halts(self, robots: frozenset[str] = frozenset()) -> Sequence[Halt]:
        """Where minds stand: of robots that have met a breakpoint in their last turn, and of these."""
        return [one for group in self._groups for one in group.halts(robots)]

    def truth(self) -> Truth:
        """The world as it is; never for an agent."""
        return Truth(
            time_s=self.clock.now_s(),
            robots=self._poses(),
            samples={sample.name: self._sample_truth(sample) for sample in self._samples},
            deflections_m={name: hypot(*self._jaws.deflection_m(name)) for name in self.bodies},
            slipped=self._jaws.slipped,
            batteries={name: body.battery.level for name, body in self.bodies.items()},
        )

    def drop(self, sample: str) -> None:
        """Let a sample slip out of all jaws that hold it."""
        self._jaws.drop(sample)

    def put(self, sample: str, point: tuple[float, float]) -> None:
        """Lay a sample somewhere by hand; no robot is told."""
        self._jaws.drop(sample)
        self.scene.set_down(sample, point)

    def _answer(self, message: Message) -> None:
        """Follow what the service tells of foreign robots; take up the edition that it asks for, if that is later."""
        asked = message.body
        if isinstance(asked, ForeignState):
            self._foreign.take(asked)
        if not isinstance(asked, WorldChange):
            return
        reason = ""
        if asked.edition > self.edition:
            try:
                self.take_up(Edition(asked.edition, WorldFile.model_validate(asked.world)), asked.minds)
            except MindUnfit as error:
                reason = str(error)
            except Exception as error:  # another software's world may fail anywhere
                reason = f"{type(error).__name__}: {error}"
        self.hub.answer(
            Message(
                performative=Performative.REFUSE if reason else Performative.AGREE,
                sender=WORLD,
                receiver=message.sender,
                sent_at_s=self.clock.now_s(),
                in_reply_to=message.id,
                body=WorldEdition(edition=self.edition, reason=reason),
            )
        )

    def close(self) -> None:
        for group in self._groups:
            group.close()
        self.scene.close()

    def _tick_agents(self) -> None:
        for group in reversed(self._groups):  # the one in this process last: the others work beside it
            group.begin_tick(self.clock.ticks)
        for group in self._groups:
            group.finish_tick()

    def _memories(self, *, is_whole: bool) -> dict[str, RobotMemory]:
        for group in self._groups:
            group.begin_memories(is_whole=is_whole)
        return {name: memory for group in self._groups for name, memory in group.finish_memories().items()}

    def _agent_setup(self, spec: RobotSpec, memory: RobotMemory | None) -> AgentSetup:
        return AgentSetup(
            spec=spec,
            reach=self.world.reach_of(spec),
            others=tuple(other for other in (*self.bodies, *self._foreign.names) if other != spec.name),
            samples=frozenset(one.name for one in self.world.samples),
            zones=self.world.zones,
            lengths_m=self.world.lengths_m,
            told=self._placement.told[spec.name],
            round_trip_s=self.world.link_of(spec).round_trip_s,
            body=self._exchangeable[spec.name],
            link=self.hub.link_of(spec.name),
            clock=self.clock,
            memory=memory,
            edition=self.edition,
            speaks=self.world.has_social_level(spec),
            peer_round_trip_s=0.0 if self.world.peer_link is None else self.world.peer_link.round_trip_s,
        )

    def _drain_batteries(self) -> None:
        """Account for the energy since the last control tick."""
        at_charger = self._chargers.serve(self.bodies, self.scene)
        for name, body in self.bodies.items():
            body.drain_battery(CONTROL_S, at_charger=name in at_charger)

    def _note_touches(self) -> None:
        """Bumpers latch a touch until they are read."""
        for name, body in self._bodies_running(Sensor.BUMPER).items():
            if name not in self._touched and body.touches():
                self._touched.add(name)

    def _bodies_running(self, sensor: Sensor) -> Mapping[str, SimulatedBody]:
        return {name: body for name, body in self.bodies.items() if sensor in body.running}

    def _sense(self) -> None:
        """Refresh the readings; sensors that are off cost nothing: no ray is cast for them."""
        poses = self._poses()
        for name, body in self.bodies.items():
            body.update_odometry(poses[name])
        ranges = self._whiskers.read(self.scene, poses, self._rngs, self._bodies_running(Sensor.ULTRASONIC))
        seen = self._infra_red.read(
            self.scene,
            poses,
            self._rngs,
            self._bodies_running(Sensor.INFRA_RED),
            self._jaws.hidden_tags(),
            self._foreign.poses,
        )
        grippers = self._jaws.states(self._bodies_running(Sensor.GRIPPER))
        for name, body in self.bodies.items():
            running = body.running
            body.refresh(
                Readings(
                    time_s=self.clock.now_s(),
                    ranges_m=ranges.get(name),
                    bumper=name in self._touched if Sensor.BUMPER in running else None,
                    sightings=seen.get(name),
                    gripper=grippers.get(name),
                    capture_head_m=self._jaws.deflection_m(name) if Sensor.CAPTURE_HEAD in running else None,
                    battery=body.battery.level,
                    charging=body.battery.charging,
                )
            )
        self._touched.clear()

    def _poses(self) -> dict[str, Pose]:
        return {name: self.scene.pose(name) for name in self.bodies}

    def _sample_truth(self, sample: Sample) -> SampleTruth:
        x, y, _ = self.scene.sample_point(sample.name)
        holders = self._jaws.holders(sample.name) or self._foreign.holders(sample.name)
        return SampleTruth(
            x_m=x,
            y_m=y,
            heading_rad=self.scene.sample_heading(sample.name) if sample.length_m else 0.0,
            place=None if holders else place_at(self.world, (x, y)),
            holders=holders,
        )


def _newest(world: WorldFile, edition: Edition | None, snapshot: WorldSnapshot | None) -> Edition:
    """The latest known edition of a world."""
    known = edition or Edition(0, world)
    if snapshot is None or snapshot.edition <= known.number:
        return known
    return Edition(snapshot.edition, WorldFile.model_validate_json(snapshot.document))
