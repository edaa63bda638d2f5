"""A proven lower bound of the makespan of every plan-net of a problem.

Every plan-net takes each thing that has a goal along a path of its states (edges: `Network.thing_edges`, here called
moves), and each agent along a path of its configurations (`Network.agent_edges`). The bound is the greatest of three:

1. *Critical path.* A move starts only after the moves before it on the thing's path have ended and its agents can have
   reached the configurations it needs; the shortest such path is a bound for each thing.
2. *Work.* Give every configuration X a potential p(X) with p(Y) - p(X) <= d for every edge X -> Y of d seconds. Along
   an agent's path the differences add up to that of its ends, so an agent spends at least p(last) - p(first) less the
   differences p(exit) - p(entry) of its moves outside of moves. With these differences charged to the moves (none
   becomes negative), each thing costs its cheapest path, whichever agents carry it. Moves of different things are
   different actions (the cost of an action that moves several is divided among them), so the costs add up. If k agents
   do all the work of a set of agents, the makespan is at least a k-th of the costs plus, for each of the k, the time
   before its first move (until it and a thing can be there) and after its last (until that thing is at its goal).
   The least over k is a bound. Any potential gives one; ours is the dual of the assignment of paths' ends to starts.
3. *Agents' goals.* An agent needs at least the shortest path to the configuration that is its goal.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from planner.bounds.network import Network
from planner.bounds.paths import FAR, Graph, Ints, duals, shortest
from planner.bounds.world import MILLISECONDS, NotModelled, World
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningProblem
from planner.problem.robot_classes import AgentClasses


def lower_bound_s(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> float:
    """A makespan in seconds that no plan-net undercuts; 0 where nothing is proven."""
    if any(fact.predicate in knowledge_base.under_way for fact in problem.facts):
        return 0.0
    try:
        network = _network(knowledge_base, problem)
        bound_s = _Bounds(network, problem).best() / MILLISECONDS
    except NotModelled:
        return 0.0
    _last[:] = [network]
    return bound_s


_last: list[Network] = []
"""The network of the bound before; not in here while it is used, as its nodes are numbered on demand."""


def _network(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> Network:
    """The problem's network: that of the bound before, which is taken, as far as it is made of the same."""
    classes = AgentClasses(knowledge_base, problem)
    kept = None
    with suppress(IndexError):  # there is none yet, or another thread has it
        kept = _last.pop()
        if kept.world.is_of(knowledge_base, problem, classes):
            return kept
    return Network(World(knowledge_base, problem, classes), like=kept)


MAX_CLASSES = 4
"""Maximum number of agent classes for which the work bound is computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Way:
    """A thing's shortest path: start state, goal states (any of these), edges, milliseconds."""

    start: int
    goals: Ints
    edges: tuple[int, ...]
    span: int


class _Bounds:
    def __init__(self, network: Network, problem: PlanningProblem) -> None:
        self.network = network
        self.problem = problem
        world = network.world
        self.representatives = world.representatives
        self.stands = {agent: network.configuration(agent, world.said(agent)) for agent in world.agents}
        self.members = {
            one: [a for a in world.agents if world.representative[a] == one] for one in self.representatives
        }
        goals: dict[str, list[list[int]]] = {}
        for goal in dict.fromkeys(problem.goals):
            for thing in world.things.intersection(goal.args):
                states = network.goal_states(thing, goal)
                if states is not None:
                    goals.setdefault(thing, []).append(states)
        self._start = {}
        for thing in sorted(goals):
            facts = world.said(thing)
            held = {arg for fact in facts for arg in fact.args if arg in world.representative}
            self._start[thing] = network.state(thing, [*facts, *(f for one in held for f in world.said(one))])
        self._goals = {thing: sorted(set(some[0]).intersection(*some)) for thing, some in goals.items()}
        thing_edges = network.thing_edges
        agent_edges = network.agent_edges
        self.thing_edges = thing_edges
        self._thing_graph = Graph.of(thing_edges.before, thing_edges.after, len(network.states))
        agent_graph = Graph.of(agent_edges.before, agent_edges.after, len(network.configurations))
        self._agent_graph = agent_graph.timed(agent_edges.spans)
        self._reached: dict[tuple[int, ...], Ints] = {}
        owners = {representative: number for number, representative in enumerate(self.representatives)}
        self._class_of = np.array([owners[str(key[0])] for key in network.configurations.numbers], np.int64)

    def best(self) -> int:
        """Milliseconds."""
        found = [0, *(way.span for way in self.ways.values()), *self._agents_goals()]
        busiest = sorted((one for one in self._jobs if self._jobs[one]), key=self._load, reverse=True)[
            :MAX_CLASSES
        ]
        potentials = {representative: self._potential(representative) for representative in busiest}
        for representative, potential in potentials.items():
            found.append(self._work([representative], potential))
        if 1 < len(potentials) < MAX_CLASSES:
            found.append(self._work(busiest, np.sum(list(potentials.values()), axis=0)))
        return max(found)

    def _load(self, representative: int) -> float:
        """Estimate of how long the shortest paths occupy each agent of the class."""
        thing_edges = self.thing_edges
        edges = [edge for way in self.ways.values() for edge in way.edges]
        mine = (self._class_of[thing_edges.entries[:, edges]] == representative) & (
            thing_edges.entries[:, edges] >= 0
        )
        return float(thing_edges.kept[:, edges][mine].sum()) / len(
            self.members[self.representatives[representative]]
        )

    def _arrivals(self, agent: str) -> Ints:
        """The earliest time at which the agent can be in each configuration."""
        return self._from(self.stands[agent])

    def _from(self, *configurations: int) -> Ints:
        """The time from the nearest of these configurations to each configuration."""
        if configurations not in self._reached:
            starts = np.array(configurations, np.int64)
            self._reached[configurations], _ = shortest(self._agent_graph, starts)
        return self._reached[configurations]

    @cached_property
    def _released(self) -> Graph:
        """The moves, each from the earliest time on at which its agents can be ready."""
        anyone = self._from(*set(self.stands.values()))
        first = np.append(anyone, 0)  # entry -1: no agent
        releases = first[self.thing_edges.entries].max(axis=0, initial=0)
        return self._thing_graph.timed(self.thing_edges.spans, releases)

    @cached_property
    def ways(self) -> Mapping[str, _Way]:
        """The shortest path of each thing that must move."""
        found = {}
        graph = self._released
        for thing, goals in self._goals.items():
            start = self._start[thing]
            ends = np.array(goals, np.int64)
            if start in goals or not goals:
                continue
            times, edges = shortest(graph, np.array([start]), ends)
            end = int(ends[np.argmin(times[ends])])
            if times[end] < FAR:
                path = tuple(self._path(edges, end))
                found[thing] = _Way(start=start, goals=ends, edges=path, span=int(times[end]))
        return found

    def _path(self, edges: Ints, end: int) -> Sequence[int]:
        path: list[int] = []
        while edges[end] >= 0:
            path.append(int(edges[end]))
            end = int(self.thing_edges.before[edges[end]])
        return path[::-1]

    @cached_property
    def _jobs(self) -> Mapping[int, list[tuple[int, int]]]:
        """By class its jobs on the shortest paths: the configurations they start and end in."""
        jobs: dict[int, list[tuple[int, int]]] = {number: [] for number in range(len(self.representatives))}
        for way in self.ways.values():
            open_job: dict[int, int] = {}
            for edge in way.edges:
                for entry, left in zip(
                    self.thing_edges.entries[:, edge], self.thing_edges.exits[:, edge], strict=True
                ):
                    if entry >= 0:
                        mine = jobs[int(self._class_of[entry])]
                        if open_job.get(int(entry)) is not None:
                            begun = open_job.pop(int(entry))
                            mine.remove((begun, int(entry)))
                        else:
                            begun = int(entry)
                        mine.append((begun, int(left)))
                        open_job[int(left)] = begun
        return jobs

    def _potential(self, representative: int) -> Ints:
        """A potential of the configurations of a class, 0 on all others."""
        jobs = self._jobs[representative]
        members = self.members[self.representatives[representative]]
        rows = [left for _, left in jobs] + [self.stands[agent] for agent in members]
        columns = [entry for entry, _ in jobs]
        from_here = {row: self._from(row) for row in set(rows)}
        costs = np.zeros((len(rows), len(rows)), np.int64)
        for number, row in enumerate(rows):
            costs[number, : len(columns)] = from_here[row][columns]
        prices, ends = duals(costs)
        least = np.full(len(self._class_of), FAR, np.int64)
        for number, row in enumerate(rows):
            least = np.minimum(least, from_here[row] - prices[number])
        reached = least[least < FAR // 2]
        potential = np.clip(least, ends[len(columns) :].max(), reached.max(initial=0))
        return np.where(self._class_of == representative, potential, 0)

    def _work(self, classes: Sequence[int], potential: Ints) -> int:
        """The bound by the work of the agents of some classes."""
        thing_edges = self.thing_edges
        mine = (thing_edges.entries >= 0) & np.isin(self._class_of[thing_edges.entries], classes)
        charges = thing_edges.kept + potential[thing_edges.entries] - potential[thing_edges.exits]
        costs = np.where(mine, charges, 0).sum(axis=0) // thing_edges.things
        graph = self._thing_graph.timed(costs)
        work = 0
        for way in self.ways.values():
            if mine[:, way.edges].any():
                times, _ = shortest(graph, np.array([way.start]), way.goals)
                work += int(times[way.goals].min())
        if not work:
            return 0
        more = np.sort(np.array(list(self._margins(classes, mine, potential)), np.int64))
        shares = (work + np.cumsum(more)) // np.arange(1, len(more) + 1)
        return int(shares.min())

    def _margins(self, classes: Sequence[int], mine: NDArray[np.bool_], potential: Ints) -> Iterator[int]:
        """For each agent the time before its first move and after its last, less the potentials' difference."""
        for number in classes:
            nodes = np.flatnonzero(self._class_of == number)
            tail = int((potential + self._tails)[nodes].min())
            for agent in self.members[self.representatives[number]]:
                begin = np.maximum(self._arrivals(agent), self._heads) - potential
                yield int(begin[nodes].min()) + tail

    @cached_property
    def _heads(self) -> Ints:
        """For each configuration the earliest start of a move that starts in it."""
        starts = np.array([way.start for way in self.ways.values()], np.int64)
        times, _ = shortest(self._released, starts)
        return self._least(self.thing_edges.entries, times[self.thing_edges.before])

    @cached_property
    def _tails(self) -> Ints:
        """For each configuration the least rest of the path of a thing whose move ends in it."""
        thing_edges = self.thing_edges
        back = Graph.of(thing_edges.after, thing_edges.before, len(self._thing_graph.first) - 1)
        goals = np.unique(np.concatenate([way.goals for way in self.ways.values()]))
        times, _ = shortest(back.timed(thing_edges.spans), goals)
        return self._least(thing_edges.exits, times[thing_edges.after])

    def _least(self, at: Ints, values: Ints) -> Ints:
        """By configuration the least value of the moves that have it in `at`."""
        least = np.full(len(self._class_of) + 1, FAR, np.int64)
        for row in at:
            np.minimum.at(least, row, values)
        return least[:-1]

    def _agents_goals(self) -> Iterator[int]:
        for goal in self.problem.goals:
            for agent in self.stands.keys() & set(goal.args):
                states = self.network.configurations_with(agent, goal)
                if states:
                    yield int(self._arrivals(agent)[states].min())
