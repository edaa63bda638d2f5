"""Stops: variants of a fragment in which an agent that carries something first clears the place it leaves.

A place is clear again only when the agent has arrived elsewhere (effects hold at an action's end). On a long way it may
pay to stop at its initial position, which is near and needed by nobody, and to go on from there.
"""

from collections import Counter
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, field

from planner.engines.hierarchical.legs.leg import ClassifiedProblem, renamed
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.knowledge.base import binding_of
from planner.plan_nets.progression import progressed
from planner.problem.zones import ground

MAX_MEMBERS = 4
"""Maximum size of a class whose members are varied: in larger ones another member is usually free."""

MAX_NEAR_STOPPING = 128
"""Maximum number of tasks for which stops near busy places are computed."""
NEAR_STOPS = 3
"""Number of places near a busy one that are considered for stops."""

SHARE = 0.5
"""Maximum share of the whole way's time that the way to a stop may take."""

Sequenced = tuple[GroundAction, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stops:
    """Makes the variants of one problem."""

    classified: ClassifiedProblem
    share: float = SHARE
    nearest: dict[tuple[str, str, int], list[str]] = field(default_factory=dict)
    """Cache: by tag, origin and class the places near the origin."""

    def variants(self, actions: Sequenced) -> Iterator[Sequenced]:
        """The fragment with one stop on one way, for each agent of the class that could make it."""
        for position, action in enumerate(actions):
            if len(action.agents) != 1 or self.classified.is_setup(action) or not self._left(action):
                continue
            old = action.agents[0]
            members = self.classified.classes.members[self.classified.classes.number(old)]
            for agent in members if len(members) <= MAX_MEMBERS else ():
                names = {old: agent, agent: old}
                played = tuple(
                    renamed(a, names) if old in a.agents or agent in a.agents else a for a in actions
                )
                for stop in self._initial_places(agent):
                    varied = self._with_stop(played, position, stop)
                    if varied is not None:
                        yield varied

    def near_variants(self, actions: Sequenced, busy: Set[str]) -> Iterator[Sequenced]:
        """The fragment with one stop on one way out of a busy place, at each of the places near to it."""
        for position, action in enumerate(actions):
            if (
                len(action.agents) == 1
                and not self.classified.is_setup(action)
                and self._left(action) in busy
            ):
                for stop in self._near(action, busy):
                    varied = self._with_stop(actions, position, stop)
                    if varied is not None:
                        yield varied

    def places(self, actions: Sequenced) -> set[str]:
        """The places that a fragment's actions leave and thereby clear for others."""
        return {place for action in actions if (place := self._left(action)) is not None}

    def _near(self, action: GroundAction, busy: Set[str]) -> Sequence[str]:
        """The places soonest reached by an action like this one, without busy ones and those of one agent only."""
        origin = str(self._left(action))
        kind = action.tag, origin, self.classified.classes.number(action.agents[0])
        if kind not in self.nearest:
            ends = self._reached(action)
            kinds = {self.classified.problem.objects[end] for end in ends}
            spans = []
            for name in sorted(
                self.classified.problem.objects.keys()
                - busy
                - self.classified.classes.own
                - self.classified.things
            ):
                if self.classified.problem.objects[name] in kinds:
                    first = self._exchanged(action, dict.fromkeys(ends, name), None)
                    if first is not None:
                        spans.append((first.duration_s, name))
            self.nearest[kind] = [name for _, name in sorted(spans)[:NEAR_STOPS]]
        return self.nearest[kind]

    def _left(self, action: GroundAction) -> str | None:
        """The place that the action leaves and thereby clears for others."""
        cleared = {
            arg
            for fact in action.other_effects
            if self.classified.knowledge_base.predicates[fact.predicate].make_way
            for arg in fact.args
        }
        before = {
            arg for fact in action.deletes if self.classified.is_configuration(fact) for arg in fact.args
        }
        return min(cleared & before & self.classified.problem.objects.keys(), default=None)

    def _reached(self, action: GroundAction) -> set[str]:
        after = {
            arg for fact in action.effects if self.classified.is_configuration(fact) for arg in fact.args
        }
        return after & self.classified.problem.objects.keys() - set(action.agents)

    def _initial_places(self, agent: str) -> list[str]:
        """Where the agent stands at first."""
        start = self.classified.configuration(agent, self.classified.problem.facts)
        return sorted(
            {arg for fact in start for arg in fact.args if arg in self.classified.problem.objects} - {agent}
        )

    def _with_stop(self, actions: Sequenced, position: int, stop: str) -> Sequenced | None:
        action = actions[position]
        origin = self._left(action)
        ends = self._reached(action)
        if origin is None or len(ends) != 1 or stop in (origin, *ends):
            return None
        first = self._exchanged(action, dict.fromkeys(ends, stop), None)
        if first is None or first.duration_s > action.duration_s * self.share:
            return None
        facts = progressed(self.classified.problem.facts, actions[:position])
        varied = list(actions[:position])
        for step, names in [(first, {}), *((a, {origin: stop}) for a in actions[position:])]:
            fitting = self._fitting(step, names, facts)
            if fitting is None:
                return None
            facts = progressed(facts, (fitting,))
            varied.append(fitting)
        return tuple(varied)

    def _fitting(
        self, action: GroundAction, names: dict[str, str], facts: frozenset[Fact]
    ) -> GroundAction | None:
        """The action if it can be carried out, else its like with these names exchanged."""
        mine = set(action.agents)
        for candidate in (action, self._exchanged(action, names, facts)):
            if candidate is not None and all(
                fact in facts for fact in candidate.preconditions if mine.intersection(fact.args)
            ):
                return candidate
        return None

    def _exchanged(
        self, action: GroundAction, names: dict[str, str], facts: frozenset[Fact] | None
    ) -> GroundAction | None:
        """An action of the same tag with arguments exchanged, that the facts about its agent allow (None: any)."""
        base = self.classified.knowledge_base
        problem = self.classified.problem
        wanted = {name: names.get(value, value) for name, value in action.arguments.items()}
        for op in base.operators_by_tag.get(action.tag, ()):
            binding = binding_of(op, {**wanted, **op.chosen} if facts is not None else wanted)
            if binding is None or base.misfit(op, binding, problem.objects) is not None:
                continue
            found = ground(op, binding, problem, base)
            if found is None:
                continue
            agent = found.agents[0]
            static = [fact for fact in found.preconditions if not self.classified.is_fluent(fact)]
            own = [
                fact for fact in found.preconditions if self.classified.is_fluent(fact) and agent in fact.args
            ]
            if problem.facts.issuperset(static) and (facts is None or facts.issuperset(own)):
                return found
        return None


def with_stops(fragments: Sequence[Sequenced], stops: Stops) -> tuple[Sequenced, ...]:
    """The fragments and their variants."""
    varied = {str(list(map(str, v))): v for fragment in fragments for v in stops.variants(fragment)}
    return (*fragments, *varied.values())


def with_near_stops(fragments: Sequence[Sequence[Sequenced]], stops: Stops) -> list[tuple[Sequenced, ...]]:
    """The tasks' fragments, and variants of each task's first one that clear busy places early.

    A place is busy if the first fragments of several tasks leave it.
    """
    leaving = Counter(place for first, *_ in fragments for place in stops.places(first))
    busy = {place for place, count in leaving.items() if count > 1}
    return [(*some, *stops.near_variants(some[0], busy)) for some in fragments]
