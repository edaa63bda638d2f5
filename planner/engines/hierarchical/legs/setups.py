"""Setups: how the agents of a class get from one configuration to another by themselves."""

import heapq
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf

from planner.engines.hierarchical.legs.leg import ClassifiedProblem, Configuration
from planner.fact import Fact
from planner.knowledge import GroundAction, Operator
from planner.knowledge.literal import Literal
from planner.plan_nets.extraction import fault_of
from planner.plan_nets.progression import progressed
from planner.problem.zones import ground

SETUP_STEPS = 2000
"""Maximum number of configurations expanded in the search for one way."""

Binding = dict[str, str]


class FactTable:
    """Facts looked up by predicate and any argument."""

    def __init__(self, facts: Iterable[Fact]) -> None:
        self.facts = frozenset(facts)
        self._by: dict[tuple[str, int, str], list[Fact]] = defaultdict(list)
        self._all: dict[str, list[Fact]] = defaultdict(list)
        for fact in sorted(self.facts):
            self._all[fact.predicate].append(fact)
            for position, arg in enumerate(fact.args):
                self._by[fact.predicate, position, arg].append(fact)

    def matching(self, predicate: str, terms: Sequence[str | None]) -> Sequence[Fact]:
        """A list that contains every fact with these arguments (None: any)."""
        lists = [self._by.get((predicate, n, term), []) for n, term in enumerate(terms) if term is not None]
        return min(lists, key=len) if lists else self._all.get(predicate, [])


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """Actions that bring an agent into the configuration `end`."""

    actions: tuple[GroundAction, ...]
    end: Configuration


@dataclass(frozen=True, slots=True, kw_only=True)
class _ConfigurationChange:
    """What an operator changes about its first agent, as long as it names no other agent and no thing.

    :param gone: which of its deletes are about that agent's configuration. :param come: which of its effects.
    :param facts: how many pre-conditions, deletes and effects it states; None if these name agents or things.
    """

    is_setup: bool
    gone: tuple[int, ...]
    come: tuple[int, ...]
    facts: tuple[int, int, int] | None

    @classmethod
    def of(cls, op: Operator, classified: ClassifiedProblem, named: frozenset[str]) -> "_ConfigurationChange":
        """:param named: the agents and things."""

        def is_own(literal: Literal) -> bool:
            return literal.predicate in classified.fluents and op.agents[0] in literal.terms

        effects = (*op.intended_effects, *op.other_effects)
        stated = {term for one in (*op.preconditions, *op.deletes, *effects) for term in one.terms}
        is_general = stated.isdisjoint(named)
        return cls(
            is_setup=len(op.agents) == 1 and all(map(is_own, op.intended_effects)),
            gone=tuple(n for n, literal in enumerate(op.deletes) if is_own(literal)),
            come=tuple(n for n, literal in enumerate(effects) if is_own(literal)),
            facts=(len(op.preconditions), len(op.deletes), len(effects)) if is_general else None,
        )


class _Search:
    """Dijkstra's algorithm from one configuration on; each way that is asked for continues it as far as it must."""

    def __init__(self, start: Configuration, steps: Callable[[Configuration], Sequence[Way]]) -> None:
        self._start = start
        self._steps = steps
        self._spans = {start: 0.0}
        self._before: dict[Configuration, tuple[Configuration, GroundAction]] = {}
        self._settled: set[Configuration] = set()
        self._with: dict[Fact, list[Configuration]] = defaultdict(list)
        self._count = 0
        self._queue: list[tuple[float, int, Configuration]] = [(0.0, self._count, start)]

    def way(self, need: Configuration) -> Way | None:
        """The quickest way to a configuration that has all of `need`, at least one fact; None if there is none."""
        one = min(need)
        end = next((here for here in self._with[one] if need <= here), None)
        while end is None and self._queue and len(self._settled) < SETUP_STEPS:
            here = self._settle()
            end = here if here is not None and need <= here else None
        return None if end is None else Way(actions=self._actions(end), end=end)

    def _settle(self) -> Configuration | None:
        """The next nearest configuration; None if the queue's next one was settled before."""
        span, _, here = heapq.heappop(self._queue)
        if here in self._settled:
            return None
        self._settled.add(here)
        for fact in here:
            self._with[fact].append(here)
        for way in self._steps(here):
            after = span + way.actions[0].duration_s
            if after < self._spans.get(way.end, inf):
                self._spans[way.end] = after
                self._before[way.end] = here, way.actions[0]
                self._count += 1
                heapq.heappush(self._queue, (after, self._count, way.end))
        return here

    def _actions(self, end: Configuration) -> tuple[GroundAction, ...]:
        actions = []
        while end != self._start:
            end, action = self._before[end]
            actions.append(action)
        return tuple(reversed(actions))


class Setups:
    """The ways of one agent as the representative of its class."""

    def __init__(
        self,
        classified: ClassifiedProblem,
        statics: FactTable,
        agent: str,
        changes: Mapping[str, _ConfigurationChange],
        named: frozenset[str],
    ) -> None:
        """
        :param statics: the static facts that it may rely on.
        :param changes: what each setup's operator changes. :param named: the agents and things.
        """
        self._problem = classified.problem
        self._classified = classified
        self.agent = agent
        self._base = knowledge_base = classified.knowledge_base
        kind = self._problem.objects[agent]
        self._operators = [
            op
            for op in classified.static_facts.setups
            if knowledge_base.file.is_a(kind, op.parameters[op.agents[0]])
        ]
        fluents = classified.fluents
        self._static = {
            op.name: [(lit, statics) for lit in op.preconditions if lit.predicate not in fluents]
            for op in self._operators
        }
        self._own = {
            op.name: [
                lit for lit in op.preconditions if lit.predicate in fluents and op.agents[0] in lit.terms
            ]
            for op in self._operators
        }
        self._detours_pay = classified.detours_pay
        self._changes = changes
        self._named = named
        self._made: dict[Fact, bool] = {}
        self._achievers_of: dict[Fact, Sequence[tuple[Operator, Binding]]] = {}
        self._ways: dict[tuple[Configuration, Configuration], Way | None] = {}
        self._steps: dict[Configuration, tuple[Way, ...]] = {}
        self._static_bindings: dict[str, Sequence[Binding]] = {}
        self._own_bindings: dict[Configuration, Mapping[str, Sequence[Binding]]] = {}
        self._searches: dict[Configuration, _Search] = {}

    def way(self, start: Configuration, need: Configuration) -> Way | None:
        """The quickest way found to a configuration that has all of `need`; None if there is none."""
        if need <= start:
            return Way(actions=(), end=start)
        if (start, need) not in self._ways:
            possible = all(self._is_made(fact) for fact in need - start)
            direct = self._direct(start, need) if possible else None
            if possible and (direct is None or self._detours_pay):
                if start not in self._searches:
                    self._searches[start] = _Search(start, self.steps)
                self._ways[start, need] = self._searches[start].way(need) or direct
            else:
                self._ways[start, need] = direct
        return self._ways[start, need]

    def steps(self, start: Configuration) -> tuple[Way, ...]:
        """Every single action that leads elsewhere."""
        if start not in self._steps:
            self._steps[start] = tuple(self._reached(start))
        return self._steps[start]

    def _is_made(self, wanted: Fact) -> bool:
        """True if some setup may bring the fact about; otherwise a search is useless."""
        if wanted not in self._made:
            self._made[wanted] = any(
                literal.predicate == wanted.predicate
                and op.extended({op.agents[0]: self.agent}, literal.terms, wanted.args) is not None
                for op in self._operators
                for literal in (*op.intended_effects, *op.other_effects)
            )
        return self._made[wanted]

    def _direct(self, start: Configuration, need: Configuration) -> Way | None:
        """The quickest single action that brings about all that is missing."""
        best: Way | None = None
        for op, binding in self._achievers(min(need - start)):
            for own in self._bound_by(start)[op.name]:
                for way in self._ways_of(start, op, _merged(binding, own)):
                    if need <= way.end and (best is None or _span(way) < _span(best)):
                        best = way
        return best

    def _bound_by(self, start: Configuration) -> Mapping[str, Sequence[Binding]]:
        """By operator the bindings of what it asks of its agent's configuration."""
        if start not in self._own_bindings:
            here = FactTable(start)
            self._own_bindings[start] = {
                op.name: list(
                    self._joined(op, [(one, here) for one in self._own[op.name]], {op.agents[0]: self.agent})
                )
                for op in self._operators
            }
        return self._own_bindings[start]

    def _ways_of(self, start: Configuration, op: Operator, binding: Binding | None) -> Iterator[Way]:
        """What the actions of a binding lead to that the statics and the configuration allow; None: there are none."""
        for whole in () if binding is None else self._completed(op, binding):
            if any(whole[one] == whole[other] for one, other in op.distinct):
                continue
            action = ground(op, whole, self._problem, self._base)
            if action is not None and (way := self._outcome(start, op, action)) is not None:
                yield way

    def _achievers(self, wanted: Fact) -> Sequence[tuple[Operator, Binding]]:
        """Operators that intend the fact, bound as far as the fact and the statics bind them."""
        if wanted not in self._achievers_of:
            self._achievers_of[wanted] = [
                (op, full)
                for op in self._operators
                for literal in op.intended_effects
                if literal.predicate == wanted.predicate
                and (binding := op.extended({op.agents[0]: self.agent}, literal.terms, wanted.args))
                is not None
                for full in self._joined(op, self._static[op.name], binding)
            ]
        return self._achievers_of[wanted]

    def _outcome(self, start: Configuration, op: Operator, action: GroundAction) -> Way | None:
        """Where a setup leads from a configuration; None if the action is no setup or changes nothing."""
        change = self._changes[op.name]
        effects = action.effects
        named = [one for one in action.arguments.values() if one in self._named]
        # Further facts are what zones and doors ask for.
        facts = len(action.preconditions), len(action.deletes), len(effects)
        if named == [self.agent] and facts == change.facts:
            if not change.is_setup:
                return None
            gone: Iterable[Fact] = [action.deletes[n] for n in change.gone]
            come: Iterable[Fact] = [effects[n] for n in change.come]
        else:
            classified = self._classified
            if not classified.things.isdisjoint(named) or not classified.is_setup(action):
                return None
            gone = classified.configuration(self.agent, action.deletes)
            come = classified.configuration(self.agent, effects)
        end = start.difference(gone).union(come)
        return Way(actions=(action,), end=end) if end != start else None

    def _reached(self, start: Configuration) -> Iterator[Way]:
        """What every single action leads to."""
        for op in self._operators:
            own = self._bound_by(start)[op.name]
            for binding in self._anywhere(op) if own else ():
                for one in own:
                    yield from self._ways_of(start, op, _merged(binding, one))

    def _anywhere(self, op: Operator) -> Sequence[Binding]:
        """The bindings that the statics allow, whatever the configuration."""
        if op.name not in self._static_bindings:
            named = {op.agents[0]: self.agent}
            self._static_bindings[op.name] = list(self._joined(op, self._static[op.name], named))
        return self._static_bindings[op.name]

    def _joined(
        self, op: Operator, literals: Sequence[tuple[Literal, FactTable]], binding: Binding
    ) -> Iterator[Binding]:
        if not literals:
            yield binding
            return
        options = [
            (table.matching(lit.predicate, _values(lit, binding, op)), n)
            for n, (lit, table) in enumerate(literals)
        ]
        facts, chosen = min(options, key=lambda option: len(option[0]))
        rest = [*literals[:chosen], *literals[chosen + 1 :]]
        for fact in facts:
            joined = op.extended(binding, literals[chosen][0].terms, fact.args)
            if joined is not None:
                yield from self._joined(op, rest, joined)

    def _completed(self, op: Operator, binding: Binding) -> Iterator[Binding]:
        """Parameters that no static fact or configuration determines: any object of the type."""
        free = next((name for name in op.parameters if name not in binding), None)
        if free is None:
            yield binding
            return
        for name, kind in sorted(self._problem.objects.items()):
            if self._base.file.is_a(kind, op.parameters[free]) and name not in self._classified.things:
                yield from self._completed(op, {**binding, free: name})


def _merged(one: Binding, other: Binding) -> Binding | None:
    """Both bindings together; None if they contradict each other."""
    for name, value in other.items():
        if one.get(name, value) != value:
            return None
    return one | other


def _span(way: Way) -> float:
    return sum(action.duration_s for action in way.actions)


def _values(literal: Literal, binding: Mapping[str, str], op: Operator) -> list[str | None]:
    return [binding.get(term) if term in op.parameters else term for term in literal.terms]


class AllSetups:
    """The setups of a problem's agents and classes, each made when it is first asked for."""

    def __init__(self, classified: ClassifiedProblem) -> None:
        self._classified = classified
        self._everywhere = FactTable(classified.statics)
        own = classified.classes.own
        self._shared = FactTable(fact for fact in classified.statics if own.isdisjoint(fact.args))
        self._named = named = classified.agents | classified.things
        self._changes = {
            op.name: _ConfigurationChange.of(op, classified, named) for op in classified.static_facts.setups
        }
        self._made: dict[str | int, Setups] = {}

    def of_agent(self, agent: str) -> Setups:
        """Those of one agent, to its own objects too."""
        if agent not in self._made:
            self._made[agent] = self._setups(self._everywhere, agent)
        return self._made[agent]

    def of_class(self, number: int) -> Setups:
        """Those that every member of the class has, stated for the first."""
        members = self._classified.classes.members[number]
        if len(members) == 1:
            return self.of_agent(members[0])
        if number not in self._made:
            self._made[number] = self._setups(self._shared, members[0])
        return self._made[number]

    def _setups(self, statics: FactTable, agent: str) -> Setups:
        return Setups(self._classified, statics, agent, self._changes, self._named)


class ReturnHome:
    """Returns the agents of a problem to their initial configurations, so that later planning starts there."""

    def __init__(self, classified: ClassifiedProblem) -> None:
        self._classified = classified
        self._setups = AllSetups(classified)

    def after(self, facts: frozenset[Fact], actions: Sequence[GroundAction]) -> frozenset[Fact]:
        """The facts after the actions and the ways back of those agents that find one."""
        state = progressed(facts, actions)
        away = sorted({agent for action in actions for agent in action.agents})
        ways = [way for agent in away if (way := self._way(agent, state))]
        while ways:
            clear = next((way for way in ways if fault_of(way.actions, state, ()) is None), None)
            if clear is None:
                break
            state = progressed(state, clear.actions)
            ways.remove(clear)
        return state

    def _way(self, agent: str, state: frozenset[Fact]) -> Way | None:
        home = self._classified.configuration(agent, self._classified.problem.facts)
        here = self._classified.configuration(agent, state)
        return self._setups.of_agent(agent).way(here, home)
