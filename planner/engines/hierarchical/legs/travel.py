"""Numbers the configurations that agents can reach in any schedule, and the ways between them."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence

from planner.engines.hierarchical.legs.leg import ClassifiedProblem, Configuration
from planner.engines.hierarchical.legs.setups import AllSetups, Way
from planner.errors import OutOfTime
from planner.fact import Fact
from planner.knowledge import GroundAction

LEAVES = 4
"""Ways out of a configuration that are kept for making way: the quickest to places that nobody needs."""
NEAREST = 4
"""Number of places to which an agent may make way or stop, besides its initial position."""

ClassFacts = tuple[int, Configuration]
"""Facts about a class, stated of its first member."""


class Travel:
    """Numbers configurations, needs, effects and ways; `close` computes all that are reachable."""

    def __init__(self, classified: ClassifiedProblem) -> None:
        self._classes = classified.classes
        self._classified = classified
        self._setups = AllSetups(classified)
        self.configurations: dict[ClassFacts, int] = {}
        self.needs: dict[ClassFacts, int] = {}
        self.effects: dict[tuple[int, Configuration, Configuration], int] = {}
        self.ways: list[Way] = []
        self.ends: list[int] = []
        self.way: dict[tuple[int, int], int] = {}
        self.after: dict[tuple[int, int], int] = {}
        self.leaves: dict[str, list[tuple[int, int]]] = defaultdict(list)
        self.starts: dict[str, int] = {}
        self._class_facts: list[ClassFacts] = []
        self._retreats: set[tuple[str, int]] = set()
        self._left: set[tuple[str, int, Fact]] = set()
        self._stops: set[int] = set()
        self._needs_of: dict[int, list[int]] = defaultdict(list)
        self._effects_after: dict[int, set[int]] = defaultdict(set)
        for agent in self._classes.agents:
            facts = classified.configuration(agent, classified.problem.facts)
            self.starts[agent] = self._configuration(self._of_class(agent, facts))

    def need(self, agent: str, facts: Configuration) -> int:
        of_class = self._of_class(agent, facts)
        if of_class not in self.needs:
            self.needs[of_class] = len(self.needs)
            self._needs_of[of_class[0]].append(self.needs[of_class])
        return self.needs[of_class]

    def effect(self, agent: str, core: Sequence[GroundAction], need: int) -> int:
        """The number of what the core does to a configuration that has the need."""
        removed: set[Fact] = set()
        added: set[Fact] = set()
        for action in core:
            deletes = self._classified.configuration(agent, action.deletes)
            adds = self._classified.configuration(agent, action.effects)
            removed = (removed | deletes) - adds
            added = (added - deletes) | adds
        number, gone = self._of_class(agent, removed)
        _, come = self._of_class(agent, added)
        effect = self.effects.setdefault((number, gone, come), len(self.effects))
        self._effects_after[need].add(effect)
        return effect

    def close(self, is_over: Callable[[], bool] = lambda: False) -> None:
        """Follow every way and effect until no new configuration comes up.

        :raises OutOfTime: once `is_over()`; where places are far more than agents' needs there are too many ways.
        """
        needs = list(self.needs)
        effects = list(self.effects)
        waiting = {*self.starts.values(), *self.after.values(), *self._stops}
        seen = set(waiting)
        while waiting:
            here = waiting.pop()
            kind, facts = self._class_facts[here]
            for need in self._needs_of[kind]:
                if (here, need) not in self.way:
                    if is_over():
                        raise OutOfTime("the ways between tasks are too many")
                    way = self._setups.of_class(kind).way(facts, needs[need][1])
                    if way is None:
                        continue
                    self.way[here, need] = self._add(way, self._configuration((kind, way.end)))
                there = self.ends[self.way[here, need]]
                for effect in self._effects_after[need]:
                    if (there, effect) in self.after:
                        continue
                    _, gone, come = effects[effect]
                    after = self._configuration((kind, (self._class_facts[there][1] - gone) | come))
                    self.after[there, effect] = after
                    waiting |= {after} - seen
                    seen.add(after)
        self._retreat()

    def _retreat(self) -> None:
        """Ways back to each agent's initial position, for making way: nobody else is there unless planned."""
        ends = defaultdict(set)
        for here in self.after.values():
            ends[self._class_facts[here][0]].add(here)
        for agent, start in self.starts.items():
            for here in sorted(ends[self._classes.number(agent)]):
                if (agent, here) in self._retreats or here == start:
                    continue
                self._retreats.add((agent, here))
                way = self._setups.of_agent(agent).way(
                    self._of_agent(agent, here), self._of_agent(agent, start)
                )
                if way is not None and len(way.actions) == 1:
                    self.leaves[agent].append((here, self._add(way, start)))

    def leave(self, agent: str, configuration: int, fact: Fact, contended: frozenset[Fact]) -> bool:
        """Add ways by which the agent leaves a configuration and brings the fact about; True if there are new."""
        if (agent, configuration, fact) in self._left:
            return False
        self._left.add((agent, configuration, fact))
        here = self._of_agent(agent, configuration)
        found = [way for way in self._setups.of_agent(agent).steps(here) if fact in way.actions[0].effects]
        found.sort(
            key=lambda way: (not contended.isdisjoint(way.actions[0].deletes), way.actions[0].duration_s)
        )
        for way in found[:LEAVES]:
            end = self._configuration(self._of_class(agent, way.end))
            self._stops.add(end)
            self.leaves[agent].append((configuration, self._add(way, end)))
        return bool(found)

    def stop_near(self) -> None:
        """Let agents continue from the places nearest to where several legs end, to clear these early."""
        often = {here for here, count in Counter(self.after.values()).items() if count > 1}
        for here, ways in enumerate(self.nearest()):
            if here in often:
                self._stops |= {self.ends[way] for way in ways}

    def nearest(self) -> list[list[int]]:
        """For each configuration the quickest single steps out of it, among the ways to legs."""
        found: list[list[int]] = [[] for _ in self.configurations]
        for (here, _), way in self.way.items():
            if len(self.ways[way].actions) == 1:
                found[here].append(way)
        return [sorted(ways, key=self._span_s)[:NEAREST] for ways in found]

    def ahead(self) -> list[list[int]]:
        """For each need the others from which the quickest ways lead to it."""
        ends = {need: self.ends[way] for (_, need), way in self.way.items()}
        found: list[list[int]] = []
        for need in range(len(self.needs)):
            ways = {other: self.way.get((end, need)) for other, end in ends.items() if other != need}
            spans = {other: self._span_s(way) for other, way in ways.items() if way is not None}
            near = sorted((span, other) for other, span in spans.items() if span > 0.0)
            found.append([other for _, other in near[:NEAREST]])
        return found

    def _span_s(self, way: int) -> float:
        return sum(action.duration_s for action in self.ways[way].actions)

    def _of_agent(self, agent: str, configuration: int) -> Configuration:
        """The configuration, stated for one agent."""
        kind, facts = self._class_facts[configuration]
        first = self._classes.members[kind][0]
        return frozenset(fact.renamed({first: agent}) for fact in facts)

    def _of_class(self, agent: str, facts: Iterable[Fact]) -> ClassFacts:
        number = self._classes.number(agent)
        first = self._classes.members[number][0]
        if agent == first:
            return number, frozenset(facts)
        return number, frozenset(fact.renamed({agent: first}) for fact in facts)

    def _configuration(self, of_class: ClassFacts) -> int:
        if of_class not in self.configurations:
            self.configurations[of_class] = len(self.configurations)
            self._class_facts.append(of_class)
        return self.configurations[of_class]

    def _add(self, way: Way, end: int) -> int:
        self.ways.append(way)
        self.ends.append(end)
        return len(self.ways) - 1
