"""Index of a planning problem: classes of agents, facts by object, the graph of static facts."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from planner.fact import Fact
from planner.knowledge import KnowledgeBase, Operator
from planner.problem.duration_table import duration_parameters
from planner.problem.interface import PlanningProblem
from planner.problem.robot_classes import ANYONE, OWN, AgentClasses
from planner.problem.zones import ground

Node = str | int
"""A node of the static graph: an object, or the number of a kind of agents."""
Shape = frozenset[tuple[str, ...]]
FEW = 2
"""A relation to at most this many objects includes them (a sample's place, an agent's area, its camera)."""


class WorldIndex:
    """Look-ups in one problem. Agents of one class (`AgentClasses`) are called of one *kind*."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self.knowledge_base = knowledge_base
        self.problem = problem
        self.objects = problem.objects
        self.fluents = knowledge_base.fluents
        self.rows: Mapping[str, set[tuple[str, ...]]] = defaultdict(set)
        self._fluent_facts: dict[str, list[Fact]] = defaultdict(list)
        self._static_facts: dict[str, list[Fact]] = defaultdict(list)
        for fact in problem.facts:
            self.rows[fact.predicate].add(fact.args)
            of = self._fluent_facts if fact.predicate in self.fluents else self._static_facts
            for arg in fact.args:
                if arg in self.objects:
                    of[arg].append(fact)
        predicates = knowledge_base.predicates
        self.on_ways = sorted(
            {arg for fact in problem.facts if predicates[fact.predicate].on_ways for arg in fact.args}
        )
        """The places between others."""
        self._holes: dict[tuple[str, int], Mapping[tuple[str, ...], list[str]]] = {}
        self._shapes: dict[str, Shape] = {}
        self._distances: dict[frozenset[Node], Mapping[Node, int]] = {}
        self._seconds: dict[str, dict[tuple[str, ...], float | None]] = defaultdict(dict)

    def fluent_facts(self, name: str) -> list[Fact]:
        return self._fluent_facts.get(name, [])

    def linked_by_fluents(self, name: str) -> tuple[str, ...]:
        """The objects that fluent facts tie this one to, each relation to few."""
        return self._tied(name, self.fluent_facts(name))

    def linked_by_static_facts(self, name: str) -> tuple[str, ...]:
        """The objects other than agents that static facts tie this one to, each relation to few."""
        return tuple(o for o in self._tied(name, self._static_facts.get(name, ())) if o not in self.agents)

    def _tied(self, name: str, facts: Iterable[Fact]) -> tuple[str, ...]:
        ties: dict[tuple[str, int, str], dict[str, None]] = defaultdict(dict)
        for fact in sorted(facts):
            for arg in fact.args:
                if arg != name and arg in self.objects:
                    ties[fact.predicate, fact.args.index(name), self.objects[arg]][arg] = None
        few = (others for others in ties.values() if len(others) <= FEW)
        return tuple(dict.fromkeys(other for others in few for other in others))

    def values(self, predicate: str, args: tuple[str, ...], hole: int) -> list[str]:
        """What stands at position `hole` in the facts that are otherwise like `args`."""
        table = self._holes.get((predicate, hole))
        if table is None:
            table = defaultdict(list)
            for row in sorted(self.rows.get(predicate, ())):
                table[row[:hole] + row[hole + 1 :]].append(row[hole])
            self._holes[predicate, hole] = table
        return table.get(args[:hole] + args[hole + 1 :], [])

    @cached_property
    def of_type(self) -> Mapping[str, tuple[str, ...]]:
        """The objects of each type, those of its sub-types included."""
        file = self.knowledge_base.file
        return {
            kind: tuple(sorted(name for name, own in self.objects.items() if file.is_a(own, kind)))
            for kind in file.types
        }

    @cached_property
    def members_of_type(self) -> Mapping[str, frozenset[str]]:
        return {kind: frozenset(names) for kind, names in self.of_type.items()}

    def seconds(self, op: Operator, args: Sequence[str]) -> float | None:
        """The operator's duration with these arguments in its parameters' order; None where undefined or not
        possible. Agents of a kind take the same time, so it is worked out for their first."""
        if len(op.agents) > 1 and self.problem.crossings:
            binding = dict(zip(op.parameters, args, strict=True))
            if ground(op, binding, self.problem, self.knowledge_base) is None:
                return None
        places = self._timed[op.name]
        values = tuple([self._representatives.get(args[place], args[place]) for place in places])
        known = self._seconds[op.name]
        if values not in known:
            names = tuple(op.parameters)
            timed = {names[place]: value for place, value in zip(places, values, strict=True)}
            known[values] = op.duration_s(timed, self.problem.functions)
        return known[values]

    @cached_property
    def _timed(self) -> Mapping[str, tuple[int, ...]]:
        """For each operator the places of the parameters that its duration depends on."""
        timed = {op.name: duration_parameters(op) for op in self.knowledge_base.operators}
        return {
            op.name: tuple(place for place, name in enumerate(op.parameters) if name in timed[op.name])
            for op in self.knowledge_base.operators
        }

    @cached_property
    def _representatives(self) -> Mapping[str, str]:
        return {agent: self.members[kind][0] for agent, kind in self.kind_of.items()}

    @cached_property
    def _classes(self) -> AgentClasses:
        return AgentClasses(self.knowledge_base, self.problem)

    @cached_property
    def agents(self) -> frozenset[str]:
        return frozenset(self._classes.agents)

    @cached_property
    def _in_the_open(self) -> frozenset[str]:
        """The objects of which no static fact speaks, of types of which static facts say who comes to them."""
        known = self._static_facts.keys() | self.agents
        facts = (fact for agent in self.agents for fact in self._static_facts.get(agent, ()))
        tied = {self.objects[arg] for fact in facts for arg in fact.args if arg in self.objects}
        return frozenset(name for name, kind in self.objects.items() if kind in tied and name not in known)

    @cached_property
    def kind_of(self) -> Mapping[str, int]:
        """The number of each agent's kind."""
        return {agent: self._classes.number(agent) for agent in self._classes.agents}

    @cached_property
    def members(self) -> Mapping[int, tuple[str, ...]]:
        """The agents of each kind, those first whose state is the commonest (so that they are free, as a
        rule)."""
        groups: dict[int, list[str]] = defaultdict(list)
        for agent, number in self.kind_of.items():
            groups[number].append(agent)
        ranked: dict[int, tuple[str, ...]] = {}
        for number, group in groups.items():
            common = Counter(self.shape(agent) for agent in group)
            ranked[number] = tuple(sorted(group, key=lambda agent: (-common[self.shape(agent)], agent)))
        return ranked

    def shape(self, name: str) -> Shape:
        """What the fluent facts say of an object, the other objects named by type only."""
        if name not in self._shapes:
            self._shapes[name] = frozenset(
                (fact.predicate, *(ANYONE if arg == name else self.type_word(arg) for arg in fact.args))
                for fact in self.fluent_facts(name)
            )
        return self._shapes[name]

    def type_word(self, arg: str) -> str:
        """An object's type, marked if it belongs to one agent alone; constants as they are."""
        kind = self.objects.get(arg)
        return arg if kind is None else f"{OWN} {kind}" if arg in self._classes.own else f"a {kind}"

    @cached_property
    def profiles(self) -> Mapping[int, tuple[str, ...]]:
        """What each kind of agents can do, in words that fit other worlds too."""
        return {
            number: (
                self.objects[group[0]],
                *sorted(
                    {
                        " ".join(
                            (
                                fact.predicate,
                                *(
                                    "?" if arg == group[0] else self.objects.get(arg, arg)
                                    for arg in fact.args
                                ),
                            )
                        )
                        for fact in self._static_facts.get(group[0], ())
                    }
                ),
            )
            for number, group in self.members.items()
        }

    @cached_property
    def _graph(self) -> Mapping[Node, frozenset[Node]]:
        """The static graph: objects that a static fact names together, agents of a kind as one node. Objects
        of which no static fact speaks are connected by the functions that name them. Not so places in the open: these
        have a distance from everywhere, and would be between any two places.
        """
        edges: dict[Node, set[Node]] = defaultdict(set)
        known = {*self._static_facts, *self._in_the_open}
        leaders = {group[0] for group in self.members.values()}
        rows = [
            args for predicate, table in self.rows.items() if predicate not in self.fluents for args in table
        ]
        rows += [args for _, args in self.problem.functions if len(args) > 1 and not known.issuperset(args)]
        for args in rows:
            named = [arg for arg in args if arg in self.objects]
            if len(named) > 1 and (leaders.issuperset(self.agents.intersection(named)) or not leaders):
                nodes = {self.node(arg) for arg in named}
                for node in nodes:
                    edges[node] |= nodes
        # An agent's own places hang on its kind, whichever member it is.
        for name in self._classes.own:
            owner = {
                self.node(arg)
                for fact in self._static_facts.get(name, ())
                for arg in fact.args
                if arg in self.agents
            }
            edges[name] |= owner
            for node in owner:
                edges[node].add(name)
        return {node: frozenset(others - {node}) for node, others in edges.items()}

    def node(self, name: str) -> Node:
        return self.kind_of.get(name, name)

    def neighbours(self, node: Node) -> frozenset[Node]:
        return self._graph.get(node, frozenset())

    def distances(self, node: Node) -> Mapping[Node, int]:
        """Steps in the static graph from a node to all it is connected with; shared among nodes with the same
        neighbours, so a node's distance to itself reads 2."""
        start = self.neighbours(node)
        if start not in self._distances:
            reached: dict[Node, int] = dict.fromkeys(start, 1)
            fringe: Iterable[Node] = start
            while fringe:
                fringe = {n for near in fringe for n in self.neighbours(near)} - reached.keys()
                depth = max(reached.values()) + 1
                reached |= dict.fromkeys(fringe, depth)
            self._distances[start] = reached
        return self._distances[start]

    def distance(self, one: Node, other: Node) -> int | None:
        return 0 if one == other else self.distances(one).get(other)
