"""One behaviour packet's run: wait for clearance and its sensor pre-conditions, let its patterns act, stop at
its post-conditions.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from robots.conditions import Verdict, in_words, unmet
from robots.executive.events import TIMEOUT, TOO_FAR, EventWatch
from robots.executive.memory import PacketMemory
from robots.executive.patience import LOST_S, UNSEEN_S
from robots.executive.plans import Phase, name_of
from robots.executive.situation import plight
from robots.perception.percepts import Percepts
from robots.perception.progress import Odometer
from robots.physical.profile import RobotProfile
from robots.reactive.avoidance import Filter, Velocity
from robots.reactive.patterns import BehaviourPattern, Responses, respond
from robots.reactive.stall import StallGuard
from robots.reactive.synthesis import DegreeOfFreedom, Motion, motion
from robots.repertoire import BoundPacket
from robots.wire import BehaviourPacket, FailureCategory, PacketState


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A packet's new state, or news within a state, with words for the operator and the events raised."""

    state: PacketState
    detail: str = ""
    events: tuple[str, ...] = ()
    category: FailureCategory | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What one tick of a packet asks for, and what changed."""

    motion: Motion = field(default_factory=Motion)
    responses: Responses = field(default_factory=Responses)
    change: Change | None = None


class PacketRun:
    """The state machine of one packet. `step_s` is the time since the last tick; paused ticks are not given
    to it.
    """

    def __init__(self, packet: BehaviourPacket, content: BoundPacket, profile: RobotProfile) -> None:
        self.packet = packet
        self.state = PacketState.WAITING
        self.content = content
        self.perceived: Percepts | None = None
        """What its last tick went by."""
        self._profile = profile
        self._uncleared = set(packet.after)
        self._missing: list[str] = []
        self._waited_s = 0.0
        self._lost_s = self._unseen_s = 0.0
        self._told: set[str] = set()
        self._guard = StallGuard(content.goal, content.retries or 0, content.stalled_s)
        self._odometer = Odometer()
        self._filter = Filter(content.avoid.begin(), content.goal) if content.avoid else None
        self._watch = EventWatch(content.events)
        self._actions = [name_of(packet, phase) for phase in (Phase.WAIT, Phase.ACT, Phase.RETRY)]

    @property
    def over(self) -> bool:
        return self.state in (PacketState.FINISHED, PacketState.FAILED)

    @property
    def grips(self) -> bool:
        """True while it opens or closes the jaws, which must not be left half done."""
        gripping = any(one.dof is DegreeOfFreedom.GRIP for one in self.content.patterns)
        return gripping and self.state is PacketState.RUNNING

    @property
    def action(self) -> str:
        """The actuator action of the script's plan that it is at."""
        waits, acts, retries = self._actions
        if self.state in (PacketState.WAITING, PacketState.INITIALIZING):
            return waits
        return retries if self._guard.manoeuvring else acts

    @property
    def waits_for(self) -> str:
        """What it could not start for when last tried, in words; empty once it runs."""
        return "; ".join(self._missing)

    def clear(self, ended: Iterable[str]) -> None:
        """These actions have ended; it need not wait for them any more. May come long before its turn."""
        self._uncleared.difference_update(ended)

    def rebound(self, content: BoundPacket) -> "PacketRun":
        """The same packet, not begun, with another content."""
        fresh = PacketRun(self.packet, content, self._profile)
        fresh._uncleared &= self._uncleared
        return fresh

    def memory(self) -> PacketMemory:
        return PacketMemory(
            state=self.state,
            uncleared=frozenset(self._uncleared),
            waited_s=self._waited_s,
            lost_s=self._lost_s,
            unseen_s=self._unseen_s,
            told=frozenset(self._told),
            stall=self._guard.memory(),
            way=self._odometer.memory(),
            raised=self._watch.raised,
            held_s=dict(self._watch.held_s),
        )

    def recall(self, memory: PacketMemory) -> None:
        """Go on where a run of the same packet stood; what is around it is sensed anew."""
        self.state, self._uncleared = memory.state, set(memory.uncleared)
        self._waited_s, self._lost_s, self._unseen_s = memory.waited_s, memory.lost_s, memory.unseen_s
        self._told = set(memory.told)
        self._guard.recall(memory.stall)
        self._odometer.recall(memory.way)
        self._watch.raised, self._watch.held_s = memory.raised, dict(memory.held_s)

    def step(self, percepts: Percepts, step_s: float) -> Outcome:
        """Advance by one tick."""
        self.perceived = percepts
        if self.state is PacketState.WAITING:
            self.state = PacketState.INITIALIZING
            return Outcome(change=Change(state=self.state, detail=self._awaited_clearance()))
        if self.state is PacketState.INITIALIZING:
            return self._wait(percepts, step_s)
        if self.state is PacketState.RUNNING:
            return self._advance(percepts, step_s)
        return Outcome()

    def fault(self, why: str, last: Percepts | None) -> Outcome:
        """Give up for want of a sensor. `last`: what was perceived before it failed."""
        return self.fail(FailureCategory.ROBOT, f"broke off: {why}", last, when="before that ")

    def fail(
        self, category: FailureCategory, why: str, percepts: Percepts | None, *, when: str = ""
    ) -> Outcome:
        """Give up, and say what was perceived."""
        self.state = PacketState.FAILED
        detail = f"{self.packet.tag} {why}"
        if percepts is not None:
            detail += f"; {when}{plight(percepts, self.packet.arguments.values())}"
        return Outcome(change=Change(state=self.state, category=category, detail=detail))

    def _wait(self, percepts: Percepts, step_s: float) -> Outcome:
        clearance = self._awaited_clearance()
        unmet_now = unmet(self.content.before, percepts)
        said = filter(None, (clearance, *(one.words for one in unmet_now)))
        self._missing = list(dict.fromkeys(said))
        if not self._missing:
            self.state = PacketState.RUNNING
            return Outcome(change=Change(state=self.state))
        self._waited_s += step_s
        if self._waited_s > self.packet.wait_timeout_s:
            why = f"could not start within {self.packet.wait_timeout_s:.0f} s: the robot {self.waits_for}"
            category = FailureCategory.DEADLINE if clearance else FailureCategory.WORLD_CHANGED
            return self.fail(category, why, percepts)
        unseen = any(one.unseen for one in unmet_now)
        self._unseen_s = self._unseen_s + step_s if unseen else 0.0
        if self._unseen_s > UNSEEN_S:
            why = f"could not start for {UNSEEN_S:.0f} s for want of sight: the robot {self.waits_for}"
            return self.fail(FailureCategory.WORLD_CHANGED, why, percepts)
        return self._act(self.content.waiting, percepts)

    def _awaited_clearance(self) -> str:
        uncleared = [action for action in self.packet.after if action in self._uncleared]
        return f"waits for clearance: {', '.join(uncleared)}" if uncleared else ""

    def _advance(self, percepts: Percepts, step_s: float) -> Outcome:
        """One tick of acting; the events it raises go with its change of state, or are news of their own."""
        progress = self._odometer.update(percepts.odometry, step_s, self._watch.raised)
        percepts.progress = progress
        news = self._watch.update(percepts)
        if news:
            percepts.progress = replace(progress, raised=self._watch.raised)
        outcome = self._run(percepts, step_s)
        spared = self._spared(percepts)
        if not news and not spared:
            return outcome
        change = outcome.change or Change(state=self.state)
        said = "; ".join([*spared, *(f"{name}: the robot {words}" for name, words in news.items())])
        detail = f"{change.detail}; {said}" if change.detail else said
        events = (*news, *change.events)
        return replace(outcome, change=replace(change, detail=detail, events=events))

    def _spared(self, percepts: Percepts) -> list[str]:
        """Readings that it newly does without: told once a packet."""
        fresh = [words for words in percepts.degraded if words.partition(" reads")[0] not in self._told]
        self._told.update(words.partition(" reads")[0] for words in fresh)
        return [f"goes on though {words}" for words in fresh]

    def _run(self, percepts: Percepts, step_s: float) -> Outcome:
        missing = unmet(self.content.after, percepts)
        if not missing:
            self.state = PacketState.FINISHED
            return Outcome(change=Change(state=self.state))
        lost = unmet(self.content.maintain, percepts)
        self._lost_s = self._lost_s + step_s if lost else 0.0
        if self._lost_s > (UNSEEN_S if any(one.unseen for one in lost) else LOST_S):
            why = f"broke off: the robot {in_words(lost)}"
            return self.fail(FailureCategory.WORLD_CHANGED, why, percepts)
        for limit in (TOO_FAR, TIMEOUT):
            if limit in percepts.progress.raised:
                return self._overrun(limit, percepts, missing)
        return self._move(percepts, step_s, missing)

    def _overrun(self, limit: str, percepts: Percepts, missing: list[Verdict]) -> Outcome:
        if limit == TIMEOUT:
            why = f"did not end within {self.packet.timeout_s:.0f} s: the robot {in_words(missing)}"
            return self.fail(FailureCategory.DEADLINE, why, percepts)
        why = f"did not end within {self.content.max_distance_m} m: the robot {in_words(missing)}"
        return self.fail(FailureCategory.ROBOT, why, percepts)

    def _move(self, percepts: Percepts, step_s: float, missing: list[Verdict]) -> Outcome:
        profile, guard = self._profile, self._guard
        manoeuvre = guard.manoeuvre(percepts, step_s, profile.speed_m_s, profile.turn_rad_s)
        if manoeuvre is not None:
            return Outcome(motion=manoeuvre)
        if self.content.retries is not None:
            guard.watch(percepts, step_s)
        if guard.spent:
            why = f"made no progress after {guard.allowed} retries: the robot {in_words(missing)}"
            return self.fail(FailureCategory.ROBOT, why, percepts)
        if guard.stalled:
            guard.begin_manoeuvre()
            detail = f"no progress, backs off and tries again ({guard.retries} of {guard.allowed})"
            return Outcome(change=Change(state=self.state, detail=detail))
        return self._act(self.content.patterns, percepts)

    def _act(self, patterns: tuple[BehaviourPattern, ...], percepts: Percepts) -> Outcome:
        responses = respond(patterns, percepts)
        speed_m_s = min(self._profile.speed_m_s, self.content.max_velocity_m_s)
        wanted = motion(responses.resultant, speed_m_s=speed_m_s, turn_rad_s=self._profile.turn_rad_s)
        if self._filter is not None and self.state is PacketState.RUNNING:
            limits = Velocity(speed_m_s, self._profile.turn_rad_s)
            wanted = self._filter.apply(wanted, responses.resultant, percepts, limits)
        return Outcome(motion=wanted, responses=responses)
