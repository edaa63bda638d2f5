"""The interpreter of one agent's rules: beliefs to commitments, commitments to actions, a cycle at a time."""

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from robots.deliberative import commitments as life
from robots.deliberative.actuators import Actuators, Outcome
from robots.deliberative.beliefs import LASTING, Belief, BeliefStore, Origin
from robots.deliberative.commitments import Commitment, DropReason
from robots.deliberative.matching import Change, Key, Matcher, satisfied
from robots.deliberative.perceptors import Perceptor
from robots.deliberative.program import (
    Activate,
    Await,
    Conditions,
    Delay,
    Literal,
    Plan,
    Rule,
    RuleFile,
    RunPlan,
    Say,
    Steer,
    Step,
    parts_of,
)
from robots.deliberative.steps import FIRST_READING_S, Means, StepRun, begin
from robots.deliberative.stored import restored_key, restored_term, stored, stored_key
from robots.deliberative.terms import (
    NOT,
    Term,
    Value,
    as_term,
    as_value,
    opposite,
    renamed,
    shown,
    substitute,
    unify,
    variables_in,
)
from robots.deliberative.vocabulary import EVENTS, FAILED, FULFILLED, HOME, ME, ROLE, STARTUP
from robots.errors import RuleError
from robots.executive.breakpoints import HeldFiring
from robots.executive.mind_memory import AgentMemory, BeliefMemory, CommitmentMemory
from robots.perception.percepts import NOTHING, Needs, Percepts

MAX_COMMITMENTS = 256
"""Of one agent at a time; further ones are dropped (our choice)."""
GIVEN = (ME, HOME, ROLE)
KEPT_ENDED = 64
"""The last commitments that have ended, for people to read."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _LoadedRule:
    """A rule with what was derived from it. `perceptors` by number: of its conditions, and of its actions."""

    rule: Rule
    file: RuleFile
    kept: tuple[str, ...]
    maintain: Conditions
    perceptors: frozenset[int]
    while_live: frozenset[int]

    @property
    def origin(self) -> str:
        return f"{self.file.name}:{self.rule.place.line}"


class Agent:
    """One agent: call `cycle` at the control rate.

    The changes of beliefs that commitments make take effect in the next cycle, so that a cycle always ends.
    """

    def __init__(
        self,
        name: str,
        files: Sequence[RuleFile],
        actuators: Actuators,
        *,
        known: Iterable[Term] = (),
        now_s: float = 0.0,
    ) -> None:
        """:param files: that passed the linter. :param known: what always holds."""
        self.name = name
        self.files = tuple(files)
        self.beliefs = BeliefStore()
        self._actuators = actuators
        self._matcher = Matcher(self.beliefs)
        self._events: list[Term] = []
        self._intended: list[tuple[Term, bool, str]] = []
        self._outcomes: list[Term] = [Term(STARTUP)]
        self._live: dict[tuple[int, Key], tuple[Commitment, StepRun | None]] = {}
        self._count = 0
        self.made: list[Commitment] = []
        """The commitments that rules have made in the last cycle."""
        self.ended: deque[Commitment] = deque(maxlen=KEPT_ENDED)
        self.breakpoints = frozenset[str]()
        """Rules, "guard:3" and the like: when one fires, what the cycle commits to is held back until the next one."""
        self._held: list[tuple[int, Key]] = []
        self._plans: dict[str, tuple[Plan, ...]] = {}
        for file in files:
            for called, plans in file.plans.items():
                self._plans[called] = (*self._plans.get(called, ()), *plans)
        self._carries = frozenset[str]().union(*(file.carries for file in files))
        self._perceptors = [Perceptor(spec) for file in files for spec in file.perceptors]
        self._sensed: dict[Term, str] = {}
        self._known = frozenset[Term]()
        self._rules = [self._loaded(rule, file) for file in files for rule in file.rules]
        self.initial = (*known, *(one.term for file in files for one in file.initial))
        """What it believed at first."""
        for term in self.initial:
            self._believe(Belief(term=term, origin=Origin.INITIAL, since_s=now_s))
        for number, one in enumerate(self._rules):
            when = one.rule.when
            if one.file.is_role:
                role = Literal(Term(ROLE, (one.file.name,)), False, one.rule.place)
                when = Conditions((role, *when.literals), when.guards)
            self._matcher.add(("rule", number), when, one.kept)
            if one.perceptors:
                self._matcher.add(("needs", number), self._context(when), ())
        self._needed_rules = {number for number, one in enumerate(self._rules) if one.perceptors}
        self._demanded = frozenset[int]()
        self._read = frozenset[int]()
        """Perceptors that were read in this cycle, as far as their sensors run."""
        self._percepts: Percepts | None = None
        self._renew_demand()
        self._pending = self._matcher.changes()

    @property
    def needs(self) -> Needs:
        """The sensors that the rules need now: of perceptors whose rules' other lasting conditions hold."""
        return NOTHING.union(*(self._perceptors[number].needs for number in self._demanded))

    @property
    def all_needs(self) -> Needs:
        """The sensors that any of the rules may need."""
        return NOTHING.union(*(one.needs for one in self._perceptors))

    @property
    def commitments(self) -> list[Commitment]:
        """Those that have not ended, oldest first."""
        return [commitment for commitment, _ in self._live.values()]

    def cycle(
        self,
        now_s: float,
        events: Iterable[Term] = (),
        percepts: Percepts | None = None,
        known: frozenset[Term] = frozenset(),
    ) -> None:
        """Revise the beliefs, adopt the commitments that follow, and carry them on.

        :param events: beliefs of this cycle alone. :param known: what the robot knows of itself now.
        """
        self.made = []
        if self._held:
            held = self._held
            self._held = []
            self._go_on(held, now_s)
        if known != self._known:
            self._renew_known(known, now_s)
        began = self._revise(now_s, events, percepts)
        if self.breakpoints and any(self._breaks_at(*one) for one in began):
            self._held = began
            return
        self._go_on(began, now_s)

    @property
    def held(self) -> Sequence[HeldFiring]:
        """The rules that have fired in the last cycle, if it has met a breakpoint."""
        firings = []
        for number, key in self._held:
            loaded = self._rules[number]
            bound = {name: shown(value) for name, value in zip(loaded.kept, key, strict=True)}
            does = _name_of(loaded.rule.step)
            firings.append(HeldFiring(agent=self.name, rule=loaded.origin, does=does, bindings=bound))
        return firings

    def _breaks_at(self, number: int, key: Key) -> bool:
        return self._rules[number].origin in self.breakpoints and (number, key) not in self._live

    def _go_on(self, began: Iterable[tuple[int, Key]], now_s: float) -> None:
        """Adopt the commitments of rules that have fired, and carry all on."""
        for number, key in began:
            self._commit(number, key, now_s)
        if self._live:
            self._carry_on(now_s)

    def lasting(self) -> list[Term]:
        """The beliefs that commitments have adopted."""
        return [one.term for one in self.beliefs if one.origin is Origin.ADOPTED]

    def retracted(self) -> list[Term]:
        """What it believed at first and has ceased to believe."""
        return [term for term in self.initial if term not in self.beliefs]

    def adopt(self, terms: Iterable[Term], now_s: float) -> None:
        """Believe what another run of the agent has believed."""
        for term in terms:
            self._believe(Belief(term=term, origin=Origin.ADOPTED, since_s=now_s, source="memory"))

    def retract(self, terms: Iterable[Term]) -> None:
        """Cease to believe these, unless they are sensed or events."""
        for term in terms:
            known = self.beliefs.get(term)
            if known is not None and known.origin in LASTING:
                self._cease(term)

    def memory(self) -> AgentMemory:
        """All that it believes and is committed to, between two cycles."""
        firing = {(one.query[1], one.key) for one in self._pending if one.query[0] == "rule" and one.holds}
        return AgentMemory(
            beliefs=tuple(
                BeliefMemory(
                    term=stored(one.term),
                    origin=one.origin.value,
                    source=one.source,
                    since_s=one.since_s,
                    words=one.words,
                )
                for one in self.beliefs
            ),
            commitments=tuple(
                CommitmentMemory(
                    rule=number,
                    key=stored_key(key),
                    number=made.number,
                    towards=made.towards,
                    made_s=made.made_s,
                    due_s=made.due_s,
                    words=made.words,
                    run=None if run is None else run.memory(),
                )
                for (number, key), (made, run) in self._live.items()
            ),
            settled=tuple(
                (number, stored_key(key))
                for number in range(len(self._rules))
                for key in self._matcher.holding(("rule", number))
                if (number, key) not in firing
            ),
            held=tuple((number, stored_key(key)) for number, key in self._held),
            events=tuple(map(stored, self._events)),
            intended=tuple((stored(term), adopts, source) for term, adopts, source in self._intended),
            outcomes=tuple(map(stored, self._outcomes)),
            sensed=tuple((stored(term), words) for term, words in self._sensed.items()),
            known=tuple(map(stored, sorted(self._known, key=str))),
            count=self._count,
        )

    def recall(self, memory: AgentMemory) -> None:
        """Go on from there, with the same rule files; of a new agent.

        :raises RuleError: if the memory is of an agent with other rules.
        """
        given = [one for one in self.beliefs if _is_given(one)]
        for belief in list(self.beliefs):
            self._cease(belief.term)
        for one in memory.beliefs:
            belief = Belief(
                term=restored_term(one.term),
                origin=Origin(one.origin),
                source=one.source,
                since_s=one.since_s,
                words=one.words,
            )
            if not _is_given(belief) or any(belief.term == now.term for now in given):
                self._believe(belief)
        for now in given:  # what the robot is told of itself may be otherwise here
            self._believe(now)
        settled = {(number, restored_key(key)) for number, key in memory.settled}
        self._matcher.changes()
        self._pending = [
            Change(("rule", number), key, True)
            for number in range(len(self._rules))
            for key in self._matcher.holding(("rule", number))
            if (number, key) not in settled
        ]
        self._held = [(number, restored_key(key)) for number, key in memory.held]
        self._events = [restored_term(one) for one in memory.events]
        self._intended = [(restored_term(term), adopts, why) for term, adopts, why in memory.intended]
        self._outcomes = [restored_term(one) for one in memory.outcomes]
        self._sensed = {restored_term(term): words for term, words in memory.sensed}
        self._known = frozenset(restored_term(one) for one in memory.known)
        self._count = memory.count
        for commitment in memory.commitments:
            self._recall_commitment(commitment)
        self._renew_demand()

    def _recall_commitment(self, memory: CommitmentMemory) -> None:
        loaded = self._rules[memory.rule] if memory.rule < len(self._rules) else None
        key = restored_key(memory.key)
        if loaded is None or len(key) != len(loaded.kept):
            raise RuleError(f"{self.name} has no rule {memory.rule} that commits it to {memory.key}")
        made = Commitment(
            number=memory.number,
            origin=loaded.origin,
            towards=memory.towards,
            step=loaded.rule.step,
            bindings=dict(zip(loaded.kept, key, strict=True)),
            maintain=loaded.maintain,
            made_s=memory.made_s,
            due_s=memory.due_s,
            name=_name_of(loaded.rule.step),
        )
        life.note(made, memory.words)
        run = None
        if memory.run is not None:
            life.activate(made)
            run = begin(made.step, made.bindings, self._means(made))
            run.recall(memory.run)
        self._live[memory.rule, key] = (made, run)

    def end(self, reason: DropReason, words: str, now_s: float) -> None:
        """Drop all commitments."""
        for key in list(self._live):
            self._drop(key, reason, words, now_s)

    def _revise(
        self, now_s: float, events: Iterable[Term], percepts: Percepts | None
    ) -> list[tuple[int, Key]]:
        """Beliefs of the last cycle end, what was intended and perceived begins; the rules that begin to hold."""
        for term in self._events:
            known = self.beliefs.get(term)
            if known is not None and known.origin is Origin.EVENT:
                self._cease(term)
        changes = [*self._pending, *self._matcher.changes()]
        self._pending = []
        intended = self._intended
        self._intended = []
        for term, is_adopted, source in intended:
            if is_adopted:
                self._believe_if_possible(term, Origin.ADOPTED, source, now_s)
            else:
                self.retract([term])
        self._read = self._demanded
        self._percepts = percepts
        if self._demanded or self._sensed:
            self._perceive(percepts, now_s)
        self._events = [*self._outcomes, *events]
        self._outcomes = []
        for term in self._events:
            self._believe_if_possible(term, Origin.EVENT, "", now_s)
        began: dict[tuple[int, Key], None] = {}
        is_demand_changed = False
        for change in (*changes, *self._matcher.changes()):
            kind, number = change.query
            if kind == "needs":
                is_demand_changed = True
            elif change.holds:
                began[number, change.key] = None
            else:
                began.pop((number, change.key), None)
        if is_demand_changed:
            self._renew_demand()
        return sorted(began, key=lambda one: one[0])

    def _renew_known(self, known: frozenset[Term], now_s: float) -> None:
        for term in sorted(self._known - known, key=str):
            self._cease(term)
        for term in sorted(known - self._known, key=str):
            self._believe_if_possible(term, Origin.PERCEPTOR, "", now_s)
        self._known = known

    def _has_read(self, conditions: Conditions) -> bool:
        """Whether the sensors of all perceptors that the conditions may match have read in this cycle."""
        needed = self._perceptors_of(conditions)
        percepts = self._percepts
        if not needed or percepts is None:
            return not needed
        return needed <= self._read and all(
            percepts.data.holds(self._perceptors[number].needs) for number in needed
        )

    def _perceive(self, percepts: Percepts | None, now_s: float) -> None:
        sensed: dict[Term, str] = {}
        if percepts is not None:
            for number in sorted(self._demanded):
                for percept in self._perceptors[number].read(percepts):
                    sensed[percept.term] = percept.words
        for term in [one for one in sensed if one.functor == NOT and opposite(one) in sensed]:
            del sensed[term]  # what one of several perceptors senses, holds
        for term in self._sensed:
            if term not in sensed:
                known = self.beliefs.get(term)
                if known is not None and known.origin is Origin.PERCEPTOR:
                    self._cease(term)
        for term, words in sensed.items():
            if term not in self._sensed:
                self._believe_if_possible(term, Origin.PERCEPTOR, words, now_s)
        self._sensed = sensed

    def _commit(self, number: int, key: Key, now_s: float) -> None:
        """Adopt the commitment of a rule, unless the same one is still live."""
        if (number, key) in self._live:
            return
        loaded = self._rules[number]
        rule = loaded.rule
        bindings = dict(zip(loaded.kept, key, strict=True))
        delay_s = substitute(rule.delay_s, bindings)
        self._count += 1
        made = Commitment(
            number=self._count,
            origin=loaded.origin,
            towards=str(substitute(rule.agent, bindings)),
            step=rule.step,
            bindings=bindings,
            maintain=loaded.maintain,
            made_s=now_s,
            due_s=now_s + (delay_s if isinstance(delay_s, float | int) else 0.0),
            name=_name_of(rule.step),
        )
        self.made.append(made)
        if not isinstance(delay_s, float | int):
            life.fail(made, f"Now + {delay_s} is no time", now_s)
            self._note_end(made)
        elif len(self._live) >= MAX_COMMITMENTS:
            life.drop(made, DropReason.OVERFLOW, f"there are {MAX_COMMITMENTS} commitments already", now_s)
            self._note_end(made)
        else:
            self._live[number, key] = (made, None)
            if loaded.while_live:
                self._renew_demand()

    def _carry_on(self, now_s: float) -> None:
        for key, (commitment, begun) in list(self._live.items()):
            if not satisfied(commitment.maintain, commitment.bindings, self.beliefs):
                is_new = now_s < commitment.made_s + FIRST_READING_S
                if begun is None and is_new and not self._has_read(commitment.maintain):
                    continue  # what it is to keep may hold, and is not sensed yet
                self._drop(key, DropReason.CONDITION, "its condition no longer holds", now_s)
                continue
            if now_s < commitment.due_s:
                continue
            run = begun
            if run is None:
                life.activate(commitment)
                run = begin(commitment.step, commitment.bindings, self._means(commitment))
                self._live[key] = (commitment, run)
            outcome = run.advance(now_s)
            if outcome is not None:
                self._conclude(key, commitment, outcome, now_s)

    def _conclude(self, key: tuple[int, Key], commitment: Commitment, outcome: Outcome, now_s: float) -> None:
        if outcome.is_fulfilled:
            life.fulfil(commitment, now_s)
        elif outcome.dropped is not None:
            life.drop(commitment, outcome.dropped, outcome.words, now_s)
        else:
            life.fail(commitment, outcome.words, now_s)
        self._forget(key, commitment)

    def _drop(self, key: tuple[int, Key], reason: DropReason, words: str, now_s: float) -> None:
        commitment, run = self._live[key]
        if run is not None:
            run.cancel(words)
        life.drop(commitment, reason, words, now_s)
        self._forget(key, commitment)

    def _forget(self, key: tuple[int, Key], commitment: Commitment) -> None:
        del self._live[key]
        self._note_end(commitment)
        if self._rules[key[0]].while_live:
            self._renew_demand()

    def _note_end(self, commitment: Commitment) -> None:
        self.ended.append(commitment)
        ended = FULFILLED if commitment.state is life.CommitmentState.FULFILLED else FAILED
        if commitment.name:
            self._outcomes.append(Term(ended, (commitment.name,)))

    def _means(self, commitment: Commitment) -> Means:
        return Means(
            agent=self.name,
            store=self.beliefs,
            actuators=self._actuators,
            plans=self._plans,
            carries=self._carries,
            intend=lambda term, is_adopted, source: self._intended.append((term, is_adopted, source)),
            because=commitment.origin,
            note=lambda words: life.note(commitment, words),
            has_read=self._has_read,
        )

    def _believe_if_possible(self, term: Term, origin: Origin, source: str, now_s: float) -> None:
        words = source if origin is Origin.PERCEPTOR else ""
        belief = Belief(term=term, origin=origin, source="" if words else source, since_s=now_s, words=words)
        try:
            self._believe(belief)
        except RuleError:
            # NOTE: there are too many beliefs; the robot goes on with those it has.
            return

    def _believe(self, belief: Belief) -> None:
        changed = self.beliefs.adopt(belief)
        for ceased in changed[:-1]:
            self._matcher.untold(ceased)
        if changed:
            self._matcher.told(changed[-1])

    def _cease(self, term: Term) -> None:
        if self.beliefs.retract(term):
            self._matcher.untold(term)

    def _loaded(self, rule: Rule, file: RuleFile) -> _LoadedRule:
        steps = _reached(rule.step, self._plans)
        awaited = [one.conditions for one in steps if isinstance(one, Await)]
        run = {one.name for one in steps if isinstance(one, RunPlan)}
        contexts = [plan.when for name in run for plan in self._plans[name]]
        chosen_by = frozenset[int]().union(*(self._perceptors_of(one) for one in contexts))
        maintain = rule.maintain
        if file.is_role:
            role = Literal(Term(ROLE, (file.name,)), False, rule.place)
            maintain = Conditions((role, *maintain.literals), maintain.guards)
        bound = {name for one in rule.when.positive for name in variables_in(as_value(one.term))}
        used = (name for name in _used_by(rule) if name in bound)
        return _LoadedRule(
            rule=rule,
            file=file,
            kept=tuple(dict.fromkeys(used)),
            maintain=maintain,
            perceptors=self._perceptors_of(rule.when) | chosen_by,
            while_live=chosen_by.union(*(self._perceptors_of(one) for one in (maintain, *awaited))),
        )

    def _perceptors_of(self, conditions: Conditions) -> frozenset[int]:
        return frozenset(
            number
            for number, perceptor in enumerate(self._perceptors)
            if any(_may_be(literal.term, perceptor.spec.belief) for literal in conditions.literals)
        )

    def _context(self, when: Conditions) -> Conditions:
        """The lasting conditions of a rule: while they do not hold, its perceptors need not be read."""
        perceived = [one.spec.belief for one in self._perceptors]
        lasting = [
            one
            for one in when.literals
            if one.term.functor not in EVENTS and not any(_may_be(one.term, other) for other in perceived)
        ]
        bound = {name for one in lasting if not one.negated for name in variables_in(as_value(one.term))}
        kept = [one for one in lasting if not one.negated or set(variables_in(as_value(one.term))) <= bound]
        guards = [one for one in when.guards if {*variables_in(one.left), *variables_in(one.right)} <= bound]
        return Conditions(tuple(kept), tuple(guards))

    def _renew_demand(self) -> None:
        numbers = [
            one.perceptors
            for number, one in enumerate(self._rules)
            if one.perceptors and self._matcher.holding(("needs", number))
        ]
        live = [self._rules[number].while_live for number, _ in self._live]
        self._demanded = frozenset[int]().union(*numbers, *live)


def _is_given(belief: Belief) -> bool:
    """True for what a robot is told of itself when its software is made."""
    return belief.origin is Origin.INITIAL and belief.term.functor in GIVEN


def _may_be(term: Term, belief: Term) -> bool:
    """True if a perceptor's belief or its opposite may be the term."""
    plain = as_term(term.args[0]) if term.functor == NOT else term
    return unify(as_value(plain), renamed(as_value(belief), "'")) is not None


def _reached(step: Step, plans: Mapping[str, Sequence[Plan]]) -> list[Step]:
    """The step with all that it contains, of the plans that it runs, too."""
    found = list(parts_of(step))
    for one in list(found):
        if isinstance(one, RunPlan):
            for plan in plans[one.name]:
                found += _reached(plan.step, plans)
    return found


def _used_by(rule: Rule) -> Iterable[str]:
    """The variables of a commitment: those that tell two of a rule apart."""
    yield from variables_in(rule.agent)
    yield from variables_in(rule.delay_s)
    for conditions in (
        rule.maintain,
        *(one.conditions for one in parts_of(rule.step) if isinstance(one, Await)),
    ):
        for literal in conditions.literals:
            yield from variables_in(as_value(literal.term))
        for guard in conditions.guards:
            yield from (*variables_in(guard.left), *variables_in(guard.right))
    for step in parts_of(rule.step):
        for value in _values_of(step):
            yield from variables_in(value)


def _values_of(step: Step) -> tuple[Value, ...]:
    match step:
        case Activate(arguments=arguments):
            return tuple(value for _, value in arguments)
        case Say(performative=performative, receiver=receiver, content=content):
            return (performative, receiver, content)
        case Steer(reason=reason):
            return (reason,)
        case RunPlan(values=values):
            return values
        case Delay(seconds=seconds):
            return (seconds,)
    term = getattr(step, "term", None)
    return () if term is None else tuple(term.args)


def _name_of(step: Step) -> str:
    """By what `fulfilled(name)` and `failed(name)` name a commitment: its packet or plan; empty for a belief's."""
    for one in parts_of(step):
        if isinstance(one, Activate):
            return one.tag
        if isinstance(one, RunPlan):
            return one.name
        if isinstance(one, Steer):
            return one.verb.value
        if isinstance(one, Say):
            return "say"
    return ""
