"""One run of a behaviour packet: it waits for clearance and its sensor pre-conditions, acts, and ends at its
post-conditions.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from robots.conditions.composition import in_words, unmet
from robots.conditions.own_state import Holding
from robots.conditions.sight import InView, LiesAt
from robots.conditions.verdict import Verdict
from robots.errors import ResultError
from robots.executive.events import EventWatch
from robots.executive.memory import PacketMemory
from robots.executive.result_taking import taken
from robots.executive.sensing_plan import Phase
from robots.executive.situation import describe_situation
from robots.perception.percepts import Percepts
from robots.perception.progress import Odometer, Progress
from robots.physical.profile import RobotProfile
from robots.reactive.avoidance import Filter, Velocity
from robots.reactive.patterns import BehaviourPattern, Responses, respond
from robots.reactive.stall import MET, MISSED, STUCK, StallGuard
from robots.reactive.synthesis import DegreeOfFreedom, Motion, motion
from robots.repertoire import BoundPacket
from robots.repertoire.schema import TIMEOUT, TOO_FAR
from robots.wire import BehaviourPacket, FailureCategory, PacketResult, PacketState, TracedCondition

LOST_S = 1.0
"""A maintained condition may be unmet for this long before the packet is given up."""
UNSEEN_S = 20.0
"""Likewise if it is unmet because what it asks about is out of view."""
MISSING_S = 4.0
"""A packet waits for so long to see what it expects where it starts, then raises the event `missing` (our choice)."""
MISSING = "missing"
MET_M = 2.5
"""Another robot in view this near may be what holds up a packet: both swerve long before they touch (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A new state of a packet, or an event within a state. `detail` is for the operator."""

    state: PacketState
    detail: str = ""
    events: tuple[str, ...] = ()
    results: tuple[PacketResult, ...] = ()
    category: FailureCategory | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """The result of one tick."""

    motion: Motion = field(default_factory=Motion)
    responses: Responses = field(default_factory=Responses)
    change: Change | None = None


class PacketRun:
    """The state machine of one packet. It is not stepped while the script is paused."""

    def __init__(self, packet: BehaviourPacket, content: BoundPacket, profile: RobotProfile) -> None:
        self.packet = packet
        self.content = content
        self.perceived: Percepts | None = None
        """The percepts of the last tick."""
        self._profile = profile
        self._missing: list[str] = []
        self._left_to_rules = frozenset[str]()
        self._yields = False
        """Whether rules may act though the packet moves the jaws: it has missed what it is to grip."""
        self._astray_s = 0.0
        """How long what it expects has not been where it starts."""
        self._grips = any(one.dof is DegreeOfFreedom.GRIP for one in content.patterns)
        self._is_to_hold = self._grips and any(isinstance(one, Holding) for one in content.after)
        self._guard = StallGuard(content.goal, content.retries or 0, content.stalled_s)
        self._odometer = Odometer()
        self._filter = Filter(content.avoid.begin(), content.goal) if content.avoid else None
        self.recall(PacketMemory(state=PacketState.WAITING, uncleared=frozenset(packet.after)))

    @property
    def state(self) -> PacketState:
        return self._memory.state

    @property
    def grips(self) -> bool:
        """True while it moves the jaws, which must not be interrupted."""
        return self._grips and self.state is PacketState.RUNNING and not self._yields

    @property
    def moves_jaws(self) -> bool:
        """True if it takes something or puts it down."""
        return self._grips

    @property
    def has_begun(self) -> bool:
        """True once its patterns have acted."""
        return self._memory.has_begun

    @property
    def done_by(self) -> str:
        """The robot that has done it in this one's stead; empty if none has."""
        return self._memory.done_by

    def end_by(self, robot: str) -> None:
        """Note that another robot has done it."""
        self._memory.state = PacketState.FINISHED
        self._memory.done_by = robot

    @property
    def is_missing_something(self) -> bool:
        """True while it waits, and what it expects is not where it is to start."""
        return self._astray_s > 0

    @property
    def phase(self) -> Phase:
        """The current actuator action."""
        if self.state in (PacketState.WAITING, PacketState.INITIALIZING):
            return Phase.WAIT
        if self._memory.captures:
            return Phase.CAPTURE
        return Phase.RETRY if self._guard.manoeuvring else Phase.ACT

    @property
    def elapsed_s(self) -> float:
        """How long its patterns have acted."""
        return self._odometer.way.elapsed_s

    @property
    def waits_for(self) -> str:
        """The unmet conditions for starting, in words; empty once it runs."""
        return "; ".join(self._missing)

    def clear(self, ended: Iterable[str]) -> None:
        """Stop waiting for these actions, which have ended. May be called before the packet's turn."""
        self._memory.uncleared -= frozenset(ended)

    def clear_by(self, action: str, robot: str) -> bool:
        """Note that a robot says to have ended its part of an action; False if the packet does not wait for that."""
        named = self.packet.told_by.get(action, ())
        if robot not in named or action not in self.packet.after:
            return False
        said = self._memory.said_by.get(action, frozenset()) | {robot}
        self._memory.said_by = {**self._memory.said_by, action: said}
        if said >= set(named):
            self.clear([action])
        return True

    @property
    def cleared_by(self) -> dict[str, tuple[str, ...]]:
        """By action that the packet waited for, the robots that have said to have ended it, if all have that did it."""
        said_by = self._memory.said_by
        return {
            action: tuple(sorted(said_by[action]))
            for action, named in self.packet.told_by.items()
            if action in said_by and said_by[action] >= set(named)
        }

    def rebound(self, content: BoundPacket) -> "PacketRun":
        """A new run of the same packet with another content."""
        run = PacketRun(self.packet, content, self._profile)
        run._memory.uncleared &= self._memory.uncleared
        run._memory.said_by = dict(self._memory.said_by)
        return run

    def resume_after_own(self) -> None:
        """Go on after other packets have moved the robot: their way and their time are not this packet's."""
        self._odometer.leave_out()
        self._guard.forget_distance()
        self._yields = False
        self._astray_s = 0.0
        content = self.content
        self._filter = Filter(content.avoid.begin(), content.goal) if content.avoid else None

    def memory(self) -> PacketMemory:
        self._memory.raised = self._watch.raised
        self._memory.held_s = self._watch.held_s
        return self._memory.saved()

    def recall(self, memory: PacketMemory) -> None:
        """Restore the state of an earlier run of the same packet."""
        self._memory = memory.saved()
        self._guard.state = self._memory.stall
        self._odometer.way = self._memory.way
        self._watch = EventWatch(self.content.events, memory.raised, dict(memory.held_s))

    def step(
        self, percepts: Percepts, step_s: float, *, left_to_rules: frozenset[str] = frozenset()
    ) -> Outcome:
        """Advance by one tick.

        :param step_s: the time since the last one. :param left_to_rules: the events on which rules act in place of
            the packet's own retries and limits.
        """
        self.perceived = percepts
        self._left_to_rules = left_to_rules
        if self.state is PacketState.WAITING:
            self._memory.state = PacketState.INITIALIZING
            return Outcome(change=Change(state=self.state, detail=self._awaited_clearance()))
        if self.state is PacketState.INITIALIZING:
            return self._wait(percepts, step_s)
        if self.state is PacketState.RUNNING:
            return self._advance(percepts, step_s)
        return Outcome()

    def fault(self, reason: str, last: Percepts | None) -> Outcome:
        """Give up because of a sensor fault. `last`: the percepts before it."""
        return self.fail(FailureCategory.ROBOT, f"broke off: {reason}", last, when="before that ")

    def fail(
        self, category: FailureCategory, reason: str, percepts: Percepts | None, *, when: str = ""
    ) -> Outcome:
        """Give up, with a detail that describes the robot's situation."""
        self._memory.state = PacketState.FAILED
        detail = f"{self.packet.tag} {reason}"
        if percepts is not None:
            detail += f"; {when}{describe_situation(percepts, self.packet.arguments.values())}"
        return Outcome(change=Change(state=self.state, category=category, detail=detail))

    def _wait(self, percepts: Percepts, step_s: float) -> Outcome:
        clearance = self._awaited_clearance()
        unmet_now = unmet(self.content.before, percepts)
        words = filter(None, (clearance, *(verdict.words for verdict in unmet_now)))
        self._missing = list(dict.fromkeys(words))
        if not self._missing:
            self._memory.state = PacketState.RUNNING
            self._memory.has_begun = True
            return Outcome(change=Change(state=self.state))
        self._memory.waited_s += step_s
        if self._memory.waited_s > self.packet.wait_timeout_s:
            reason = f"could not start within {self.packet.wait_timeout_s:.0f} s: the robot {self.waits_for}"
            category = FailureCategory.DEADLINE if clearance else FailureCategory.WORLD_CHANGED
            return self.fail(category, reason, percepts)
        unseen = any(one.unseen for one in unmet_now)
        self._memory.unseen_s = self._memory.unseen_s + step_s if unseen else 0.0
        is_astray = self._is_astray(percepts)
        is_left_to_rules = is_astray and MISSING in self._left_to_rules
        if self._memory.unseen_s > UNSEEN_S and not is_left_to_rules:
            reason = f"could not start for {UNSEEN_S:.0f} s for want of sight: the robot {self.waits_for}"
            return self.fail(FailureCategory.WORLD_CHANGED, reason, percepts)
        outcome = self._act(self.content.waiting, percepts)
        if self._notes_missing(step_s, is_astray=is_astray):
            change = Change(state=self.state, detail=f"waits: the robot {self.waits_for}", events=(MISSING,))
            return replace(outcome, change=change)
        return outcome

    def _is_astray(self, percepts: Percepts) -> bool:
        """Whether what the packet expects is not where it is to start; what others bring may take its time."""
        return not (self.packet.awaits or self._awaited_clearance()) and any(
            isinstance(one, LiesAt | InView) and not one.check(percepts).holds for one in self.content.before
        )

    def _notes_missing(self, step_s: float, *, is_astray: bool) -> bool:
        """Whether what the packet expects has just been astray for `MISSING_S`."""
        before_s = self._astray_s
        self._astray_s = before_s + step_s if is_astray else 0.0
        return before_s < MISSING_S <= self._astray_s

    def _awaited_clearance(self) -> str:
        uncleared = [action for action in self.packet.after if action in self._memory.uncleared]
        return f"waits for clearance: {', '.join(uncleared)}" if uncleared else ""

    def _advance(self, percepts: Percepts, step_s: float) -> Outcome:
        """One tick of acting, with the events that it raises."""
        progress = self._odometer.update(percepts.odometry, step_s, self._watch.raised)
        percepts.progress = progress
        news = self._watch.update(percepts)
        if news:
            percepts.progress = replace(progress, raised=self._watch.raised)
        outcome = self._run(percepts, step_s)
        defects = self._new_defects(percepts)
        if not news and not defects:
            return outcome
        change = outcome.change or Change(state=self.state)
        words = [*(f"goes on though {defect}" for defect in defects)]
        words += [f"{name}: the robot {perceived}" for name, perceived in news.items()]
        detail = "; ".join([change.detail, *words] if change.detail else words)
        events = (*news, *change.events)
        return replace(outcome, change=replace(change, detail=detail, events=events))

    def _new_defects(self, percepts: Percepts) -> list[str]:
        """Defects of sensors that this packet has not reported yet, in words."""
        new = [defect for defect in percepts.degraded if defect.sensor not in self._memory.told]
        self._memory.told |= {defect.sensor for defect in new}
        return [defect.words for defect in new]

    def _run(self, percepts: Percepts, step_s: float) -> Outcome:
        missing = [] if self._memory.captures else unmet(self.content.after, percepts)
        if not missing:
            return self._finish(percepts)
        lost = unmet(self.content.maintain, percepts)
        self._memory.lost_s = self._memory.lost_s + step_s if lost else 0.0
        if self._memory.lost_s > (UNSEEN_S if any(one.unseen for one in lost) else LOST_S):
            reason = f"broke off: the robot {in_words(lost)}"
            return self.fail(FailureCategory.WORLD_CHANGED, reason, percepts)
        for limit in (TOO_FAR, TIMEOUT):
            if limit in percepts.progress.raised:
                return self._overrun(limit, percepts, missing)
        return self._move(percepts, step_s, missing)

    def _finish(self, percepts: Percepts) -> Outcome:
        """End with its results. Images are taken last: it is stepped again once the cameras have read."""
        if self.content.cameras and not self._memory.captures:
            self._memory.captures = True
            return Outcome()
        try:
            results = tuple(taken(wanted, percepts) for wanted in self.content.results)
        except ResultError as error:
            return self.fail(FailureCategory.ROBOT, f"brings no result: {error}", percepts)
        self._memory.state = PacketState.FINISHED
        return Outcome(change=Change(state=self.state, results=results))

    def _overrun(self, limit: str, percepts: Percepts, missing: list[Verdict]) -> Outcome:
        if limit == TIMEOUT:
            reason = f"did not end within {self.packet.timeout_s:.0f} s: the robot {in_words(missing)}"
            return self.fail(FailureCategory.DEADLINE, reason, percepts)
        reason = f"did not end within {self.content.max_distance_m} m: the robot {in_words(missing)}"
        return self.fail(FailureCategory.ROBOT, reason, percepts)

    def _move(self, percepts: Percepts, step_s: float, missing: list[Verdict]) -> Outcome:
        guard = self._guard
        if (manoeuvre := guard.manoeuvre(step_s, self.content.retry_s)) is not None:
            return self._retry(percepts, manoeuvre)
        if self.content.retries is not None:
            guard.watch(percepts, step_s)
            if not guard.state.idle_s:
                self._yields = False
        if guard.spent:
            reason = f"made no progress after {guard.allowed} retries: the robot {in_words(missing)}"
            return self.fail(FailureCategory.ROBOT, reason, percepts)
        if guard.stalled:
            events = (STUCK, *self._hindrance(percepts))
            # NOTE: only if the jaws hold nothing may others move a robot that is at gripping.
            freed_by = {MISSED} & set(events) if self._grips else set(events)
            acting = freed_by & self._left_to_rules
            # NOTE: another robot in view need not be what holds it up, so its own manoeuvre is tried once.
            by_rules = bool(acting) and (MET not in acting or guard.state.retries > 0)
            self._yields = by_rules and self._grips
            guard.retry(manoeuvre=not by_rules)
            how = "its rules free it" if by_rules else "backs off and tries again"
            detail = f"no progress, {how} ({guard.state.retries} of {guard.allowed})"
            return Outcome(change=Change(state=self.state, detail=detail, events=events))
        return self._act(self.content.patterns, percepts)

    def _hindrance(self, percepts: Percepts) -> tuple[str, ...]:
        """What may have stalled it, as an event."""
        if any(abs(at) <= MET_M for _, at in percepts.robots_in_view()):
            return (MET,)
        return (MISSED,) if self._is_to_hold and percepts.holding is None else ()

    def _retry(self, percepts: Percepts, manoeuvre: Progress) -> Outcome:
        """One tick of the retry, whose patterns count time from its begin; no avoidance method holds it up."""
        progress, percepts.progress = percepts.progress, manoeuvre
        outcome = self._act(self.content.retry, percepts, filtered=False)
        percepts.progress = progress
        return outcome

    def _act(
        self, patterns: tuple[BehaviourPattern, ...], percepts: Percepts, *, filtered: bool = True
    ) -> Outcome:
        responses = respond(patterns, percepts)
        speed_m_s = min(self._profile.speed_at(percepts.pose), self.content.max_velocity_m_s)
        wanted = motion(responses.resultant, speed_m_s=speed_m_s, turn_rad_s=self._profile.turn_rad_s)
        if filtered and self._filter is not None and self.state is PacketState.RUNNING:
            limits = Velocity(speed_m_s, self._profile.turn_rad_s)
            wanted = self._filter.apply(wanted, responses.resultant, percepts, limits)
        return Outcome(motion=wanted, responses=responses)

    def traced_conditions(self) -> Iterator[TracedCondition]:
        """The conditions that start, sustain and end the packet, as of its last tick."""
        percepts = self.perceived
        if percepts is None:
            return
        content = self.content
        groups = (("before", content.before), ("maintain", content.maintain), ("after", content.after))
        for when, conditions in groups:
            for condition in conditions:
                if not percepts.data.holds(condition.needs):  # of a pre-condition, once the packet runs
                    words = f"does not sense {', '.join(sorted(condition.needs))} now"
                    yield TracedCondition(when=when, words=words)
                    continue
                verdict = condition.check(percepts)
                yield TracedCondition(when=when, words=verdict.words, holds=verdict.holds)
