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

    def __init__(self, classified: ClassifiedProblem, statics: FactTable, agent: str) -> None:
        """:param statics: the static facts that it may rely on."""
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
        self._made: dict[Fact, bool] = {}
        self._achievers_of: dict[Fact, Sequence[tuple[Operator, Binding]]] = {}
        self._ways: dict[tuple[Configuration, Configuration], Way | None] = {}
        self._steps: dict[Configuration, tuple[Way, ...]] = {}
        self._tables: dict[Configuration, FactTable] = {}
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
            found = (self._outcome(start, action) for action in self._actions(start))
            self._steps[start] = tuple(way for way in found if way is not None)
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
        if start not in self._tables:
            self._tables[start] = FactTable(start)
        here = self._tables[start]
        for op, binding in self._achievers(min(need - start)):
            for action in self._grounded(op, binding, here):
                way = self._outcome(start, action)
                if way is not None and need <= way.end and (best is None or _span(way) < _span(best)):
                    best = way
        return best

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

    def _outcome(self, start: Configuration, action: GroundAction) -> Way | None:
        classified = self._classified
        if not classified.things.isdisjoint(action.arguments.values()) or not classified.is_setup(action):
            return None
        gone = classified.configuration(self.agent, action.deletes)
        end = (start - gone) | classified.configuration(self.agent, action.effects)
        return Way(actions=(action,), end=end) if end != start else None

    def _actions(self, start: Configuration) -> Iterator[GroundAction]:
        here = FactTable(start)
        for op in self._operators:
            for binding in self._joined(op, self._static[op.name], {op.agents[0]: self.agent}):
                yield from self._grounded(op, binding, here)

    def _grounded(self, op: Operator, binding: Binding, here: FactTable) -> Iterator[GroundAction]:
        """The actions of a binding that the statics allow, from a configuration that has their conditions."""
        literals = [(literal, here) for literal in self._own[op.name]]
        for full in self._joined(op, literals, binding):
            for whole in self._completed(op, full):
                if any(whole[one] == whole[other] for one, other in op.distinct):
                    continue
                action = ground(op, whole, self._problem, self._base)
                if action is not None:
                    yield action

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
        self._made: dict[str | int, Setups] = {}

    def of_agent(self, agent: str) -> Setups:
        """Those of one agent, to its own objects too."""
        if agent not in self._made:
            self._made[agent] = Setups(self._classified, self._everywhere, agent)
        return self._made[agent]

    def of_class(self, number: int) -> Setups:
        """Those that every member of the class has, stated for the first."""
        members = self._classified.classes.members[number]
        if len(members) == 1:
            return self.of_agent(members[0])
        if number not in self._made:
            self._made[number] = Setups(self._classified, self._shared, members[0])
        return self._made[number]


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
