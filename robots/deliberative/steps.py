"""Carrying out a commitment's actions and plans, a cycle at a time."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from robots.deliberative.actuators import (
    DONE,
    Activation,
    Actuators,
    Attempt,
    Claim,
    Outcome,
    Utterance,
    restored_outcome,
    stored_outcome,
)
from robots.deliberative.beliefs import BeliefStore
from robots.deliberative.costs import cost_of
from robots.deliberative.matching import satisfied, solutions
from robots.deliberative.program import (
    Activate,
    Adopt,
    Await,
    Conditions,
    Delay,
    Group,
    Joint,
    Plan,
    Retract,
    RunPlan,
    Say,
    Steer,
    Step,
)
from robots.deliberative.stored import restored_bindings, stored_bindings
from robots.deliberative.terms import Bindings, Term, Value, instance, shown, substitute
from robots.errors import RuleError
from robots.executive.mind_memory import (
    AttemptMemory,
    ChosenStep,
    DelayStep,
    PacketStep,
    ParallelStep,
    PlainStep,
    StepMemory,
    TurnStep,
)

TIMEOUT = "timeout_s"
WAIT_TIMEOUT = "wait_timeout_s"
FIRST_READING_S = 5.0
"""How long a choice between plans, and a commitment's beginning, wait for the readings that their conditions need (our
choice).
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Means:
    """What steps are carried out by. `intend`: adopts or retracts a belief in the next cycle;
    `note`: says for people which plan was chosen; `has_read`: whether the sensors of conditions have read; `claim`: of
    the plan that the step belongs to.
    """

    agent: str
    store: BeliefStore
    actuators: Actuators
    plans: Mapping[str, Sequence[Plan]]
    carries: frozenset[str]
    intend: Callable[[Term, bool, str], None]
    because: str
    note: Callable[[str], None] = lambda words: None
    has_read: Callable[[Conditions], bool] = lambda conditions: True
    claim: Claim | None = None


class StepRun(Protocol):
    """One step that is being carried out."""

    def advance(self, now_s: float) -> Outcome | None:
        """Carry it on; None while it has not ended."""
        ...

    def cancel(self, words: str) -> None:
        """End what it has begun."""
        ...

    def memory(self) -> StepMemory:
        """How far it is."""
        ...

    def recall(self, memory: StepMemory) -> None:
        """Go on from there; of a new run.

        :raises RuleError: if the memory is of another kind of step.
        """
        ...


def begin(step: Step, bindings: Bindings, means: Means) -> StepRun:
    """A new run of a step; nothing happens before it is advanced."""
    if isinstance(step, RunPlan):
        return _begin_plan(step, bindings, means)
    if isinstance(step, Group):
        if step.joint is Joint.PAR:
            return _Parallel([begin(one, bindings, means) for one in step.steps])
        return _InTurn(step.steps, bindings, means, until_fulfilled=step.joint is Joint.OR)
    if isinstance(step, Await):
        return _Awaited(step, bindings, means)
    if isinstance(step, Delay):
        return _Delayed(step, bindings)
    return _Packet(step, bindings, means) if isinstance(step, Activate) else _Instant(step, bindings, means)


def _begin_plan(called: RunPlan, bindings: Bindings, means: Means) -> StepRun:
    plans = means.plans[called.name]
    given = [substitute(one, bindings) for one in called.values]
    if any(plan.competes for plan in plans):
        return _Chosen(plans, given, means)
    (plan,) = plans
    return begin(plan.step, dict(zip(plan.parameters, given, strict=True)), means)


class _Instant:
    """An action that ends at once."""

    def __init__(self, step: Adopt | Retract | Say | Steer, bindings: Bindings, means: Means) -> None:
        self._step = step
        self._bindings = bindings
        self._means = means

    def advance(self, now_s: float) -> Outcome | None:
        means = self._means
        match self._step:
            case Adopt(term=term):
                means.intend(instance(term, self._bindings), True, means.because)
            case Retract(term=term):
                means.intend(instance(term, self._bindings), False, means.because)
            case Say(performative=performative, receiver=receiver, content=content):
                values = [substitute(one, self._bindings) for one in (performative, receiver, content)]
                said = Utterance(performative=_plain(values[0]), other=_plain(values[1]), content=values[2])
                return means.actuators.say(said)
            case Steer(verb=verb, reason=reason):
                return means.actuators.steer(verb, _plain(substitute(reason, self._bindings)))
        return DONE

    def cancel(self, words: str) -> None:
        """Nothing: it has not begun, or has ended."""

    def memory(self) -> StepMemory:
        return PlainStep()

    def recall(self, memory: StepMemory) -> None:
        if not isinstance(memory, PlainStep):
            raise _unfit(memory)


class _Packet:
    """A packet of the repertoire."""

    def __init__(self, step: Activate, bindings: Bindings, means: Means) -> None:
        given = {name: substitute(value, bindings) for name, value in step.arguments}
        limits = {name: given.pop(name) for name in (TIMEOUT, WAIT_TIMEOUT) if name in given}
        numbers = {name: value for name, value in limits.items() if isinstance(value, float | int)}
        self._faults = [
            f"{step.tag}: {name} = {shown(value)} is no number of seconds"
            for name, value in limits.items()
            if name not in numbers
        ]
        self._wanted = Activation(
            agent=means.agent,
            tag=step.tag,
            arguments={name: _plain(value) for name, value in given.items()},
            timeout_s=numbers.get(TIMEOUT),
            wait_timeout_s=numbers.get(WAIT_TIMEOUT),
            may_carry=step.tag in means.carries,
            because=means.because,
            claim=means.claim,
        )
        self._actuators = means.actuators
        self._attempt: Attempt | None = None

    def advance(self, now_s: float) -> Outcome | None:
        if self._attempt is not None:
            return self._attempt.outcome
        if self._faults:
            return Outcome(False, "; ".join(self._faults))
        begun = self._actuators.activate(self._wanted)
        if begun is not None and self._wanted.claim is not None:
            self._wanted.claim.has_begun = True
        if begun is None or isinstance(begun, Outcome):
            return begun
        self._attempt = begun
        return begun.outcome

    def cancel(self, words: str) -> None:
        if self._attempt is not None:
            self._attempt.cancel(words)

    def memory(self) -> StepMemory:
        attempt = self._attempt
        if attempt is None:
            return PacketStep()
        outcome = stored_outcome(attempt.outcome)
        return PacketStep(attempt=AttemptMemory(script_id=attempt.script_id, outcome=outcome))

    def recall(self, memory: StepMemory) -> None:
        if not isinstance(memory, PacketStep):
            raise _unfit(memory)
        if memory.attempt is not None:
            self._attempt = self._actuators.resume(self._wanted, memory.attempt)


class _InTurn:
    """SEQ ends with the first step that fails, OR with the first that is fulfilled."""

    def __init__(
        self, steps: Sequence[Step], bindings: Bindings, means: Means, *, until_fulfilled: bool
    ) -> None:
        self._steps = tuple(steps)
        self._left = list(steps)
        self._bindings = bindings
        self._means = means
        self._until_fulfilled = until_fulfilled
        self._current: StepRun | None = None

    def advance(self, now_s: float) -> Outcome | None:
        while True:
            if self._current is None:
                self._current = begin(self._left.pop(0), self._bindings, self._means)
            outcome = self._current.advance(now_s)
            if outcome is None:
                return None
            if outcome.dropped or outcome.is_fulfilled is self._until_fulfilled or not self._left:
                return outcome
            self._current = None

    def cancel(self, words: str) -> None:
        if self._current is not None:
            self._current.cancel(words)

    def memory(self) -> StepMemory:
        current = None if self._current is None else self._current.memory()
        return TurnStep(left=len(self._left), current=current)

    def recall(self, memory: StepMemory) -> None:
        if not isinstance(memory, TurnStep) or memory.left > len(self._steps):
            raise _unfit(memory)
        next_one = len(self._steps) - memory.left
        self._left = list(self._steps[next_one:])
        if memory.current is not None:
            if next_one == 0:
                raise _unfit(memory)
            self._current = begin(self._steps[next_one - 1], self._bindings, self._means)
            self._current.recall(memory.current)


class _Parallel:
    """All at once; it ends when all have ended."""

    def __init__(self, runs: list[StepRun]) -> None:
        self._runs = dict(enumerate(runs))
        self._worst = DONE

    def advance(self, now_s: float) -> Outcome | None:
        left = {}
        for number, run in self._runs.items():
            outcome = run.advance(now_s)
            if outcome is None:
                left[number] = run
            elif not outcome.is_fulfilled and self._worst is DONE:
                self._worst = outcome
        self._runs = left
        return None if left else self._worst

    def cancel(self, words: str) -> None:
        for run in self._runs.values():
            run.cancel(words)

    def memory(self) -> StepMemory:
        runs = {number: run.memory() for number, run in self._runs.items()}
        return ParallelStep(runs=runs, worst=None if self._worst is DONE else stored_outcome(self._worst))

    def recall(self, memory: StepMemory) -> None:
        if not isinstance(memory, ParallelStep) or not memory.runs.keys() <= self._runs.keys():
            raise _unfit(memory)
        self._runs = {number: self._runs[number] for number in memory.runs}
        for number, one in memory.runs.items():
            self._runs[number].recall(one)
        self._worst = restored_outcome(memory.worst) or DONE


class _Chosen:
    """The cheapest plan whose context holds (P-SMPA §4); if it fails, the next one."""

    def __init__(self, plans: Sequence[Plan], given: Sequence[Value], means: Means) -> None:
        self._plans = plans
        self._given = given
        self._means = means
        self._tried: set[tuple[int, str]] = set()
        self._failed: list[str] = []
        self._current: StepRun | None = None
        self._title = ""
        self._rejected: list[str] = []
        self._begun_s: float | None = None
        self._plan: Plan | None = None
        self._key = (-1, "")
        self._bindings: Bindings = {}
        self._words = ""
        self._claim = Claim(title="", cost=lambda: None, tell=means.note)

    def advance(self, now_s: float) -> Outcome | None:
        if self._begun_s is None:
            self._begun_s = now_s
        if self._current is None and not self._is_informed() and now_s < self._begun_s + FIRST_READING_S:
            return None
        if self._current is not None and self._means.actuators.senses and self._may_choose_again():
            self._tried.discard(self._key)
            self._current = None
        while True:
            if self._current is None:
                self._current = self._choose()
            if self._current is None:
                words = f"no plan {self._plans[0].name} is left: "
                return Outcome(False, words + "; ".join([*self._failed, *self._rejected]))
            outcome = self._current.advance(now_s)
            if outcome is None or outcome.is_fulfilled or outcome.dropped:
                return outcome
            self._failed.append(f"{self._title} failed: {outcome.words}")
            self._current = None

    def _is_informed(self) -> bool:
        """Whether all has been sensed that the choice depends on."""
        means = self._means
        return means.actuators.senses and all(means.has_read(plan.when) for plan in self._plans)

    def _may_choose_again(self) -> bool:
        """Whether the plan waits for the robot's body and has done nothing yet: another one may be better now."""
        plan = self._plan
        if plan is None or plan.cost is None or self._claim.has_begun:
            return False
        return _begins_with_packet(plan.step)

    def _choose(self) -> StepRun | None:
        means = self._means
        found: list[tuple[float, int, dict[str, Value]]] = []
        self._rejected = []
        for number, plan in enumerate(self._plans):
            bound = dict(zip(plan.parameters, self._given, strict=True))
            instances = list(solutions(plan.when, bound, means.store))
            if not instances:
                self._rejected.append(f"{_titled(plan)} does not apply")
            for one in instances:
                cost = self._cost(plan, one)
                if cost is None:
                    self._rejected.append(f"{_titled(plan)} has no known cost")
                elif (number, str(one)) not in self._tried:
                    found.append((cost, number, one))
        found.sort(key=lambda one: one[:2])
        if not found:
            return None
        cost, number, bindings = found[0]
        plan = self._plans[number]
        key = (number, str(bindings))
        is_new = key != self._key
        self._plan = plan
        self._key = key
        self._tried.add(key)
        self._title = _titled(plan)
        others = [f"{_titled(self._plans[other])} costs {more:.3g}" for more, other, _ in found[1:]]
        words = "; ".join([f"{self._title} costs {cost:.3g}", *self._failed, *others, *self._rejected])
        if is_new:
            means.note(words)
        return self._begun(plan, bindings, words)

    def _begun(self, plan: Plan, bindings: Bindings, words: str) -> StepRun:
        self._bindings = bindings
        self._words = words
        if plan.cost is None:
            return begin(plan.step, bindings, self._means)
        claim = self._claimed(plan, bindings, words)
        return begin(plan.step, bindings, replace(self._means, claim=claim))

    def _claimed(self, plan: Plan, bindings: Bindings, words: str) -> Claim:
        """The claim, which stays the same while it waits, now of this plan."""
        means = self._means
        claim = self._claim
        claim.title = f"{plan.name} of {means.because}"
        claim.cost = lambda: self._cost(plan, bindings)
        claim.tell = lambda chosen: means.note(f"{words}; {chosen}")
        claim.has_begun = False
        return claim

    def _cost(self, plan: Plan, bindings: Bindings) -> float | None:
        return 0.0 if plan.cost is None else cost_of(plan.cost, bindings, self._means.actuators.measure)

    def cancel(self, words: str) -> None:
        if self._current is not None:
            self._current.cancel(words)

    def memory(self) -> StepMemory:
        plan = self._plan if self._current is not None else None
        is_granted, keeps = self._means.actuators.standing(self._claim)
        return ChosenStep(
            begun_s=self._begun_s,
            tried=tuple(sorted(self._tried)),
            failed=tuple(self._failed),
            plan=None if plan is None else next(n for n, one in enumerate(self._plans) if one is plan),
            bindings=stored_bindings(self._bindings) if plan is not None else {},
            key=self._key,
            current=None if self._current is None else self._current.memory(),
            words=self._words,
            has_begun=self._claim.has_begun,
            is_granted=is_granted,
            keeps=keeps,
        )

    def recall(self, memory: StepMemory) -> None:
        if not isinstance(memory, ChosenStep):
            raise _unfit(memory)
        self._begun_s = memory.begun_s
        self._tried = set(memory.tried)
        self._failed = list(memory.failed)
        self._key = memory.key
        if memory.plan is not None:
            if memory.plan >= len(self._plans) or memory.current is None:
                raise _unfit(memory)
            self._plan = self._plans[memory.plan]
            self._title = _titled(self._plan)
            self._current = self._begun(self._plan, restored_bindings(memory.bindings), memory.words)
            self._current.recall(memory.current)
        self._claim.has_begun = memory.has_begun
        self._means.actuators.restore_standing(self._claim, is_granted=memory.is_granted, keeps=memory.keeps)


def _begins_with_packet(step: Step) -> bool:
    while isinstance(step, Group) and step.joint is not Joint.PAR:
        step = step.steps[0]
    return isinstance(step, Activate)


def _titled(plan: Plan) -> str:
    return f"{plan.name} of line {plan.place.line}"


class _Awaited:
    """Ends once its conditions hold."""

    def __init__(self, step: Await, bindings: Bindings, means: Means) -> None:
        self._conditions = step.conditions
        self._bindings = bindings
        self._store = means.store

    def advance(self, now_s: float) -> Outcome | None:
        return DONE if satisfied(self._conditions, self._bindings, self._store) else None

    def cancel(self, words: str) -> None:
        """Nothing: it only waits."""

    def memory(self) -> StepMemory:
        return PlainStep()

    def recall(self, memory: StepMemory) -> None:
        if not isinstance(memory, PlainStep):
            raise _unfit(memory)


class _Delayed:
    """Ends after some seconds."""

    def __init__(self, step: Delay, bindings: Bindings) -> None:
        self._seconds = substitute(step.seconds, bindings)
        self._until_s: float | None = None

    def advance(self, now_s: float) -> Outcome | None:
        if not isinstance(self._seconds, float | int):
            return Outcome(False, f"DELAY({shown(self._seconds)}) is no number of seconds")
        if self._until_s is None:
            self._until_s = now_s + self._seconds
        return DONE if now_s >= self._until_s else None

    def cancel(self, words: str) -> None:
        """Nothing: it only waits."""

    def memory(self) -> StepMemory:
        return DelayStep(until_s=self._until_s)

    def recall(self, memory: StepMemory) -> None:
        if not isinstance(memory, DelayStep):
            raise _unfit(memory)
        self._until_s = memory.until_s


def _unfit(memory: StepMemory) -> RuleError:
    return RuleError(f"the memory of a {memory.kind} step is of another step than the rule has")


def _plain(value: object) -> str:
    """A value as an argument of a packet or a message: names without quotes, numbers as short as they can be."""
    if isinstance(value, str):
        return value
    if isinstance(value, float | int):
        return f"{value:.12g}"
    return str(value)
