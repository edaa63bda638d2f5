"""Reads a unified-planning problem as knowledge base and planning problem.

What fits: typed (durative) actions with literals as conditions and effects, durations and costs of static
functions. Negative conditions become complementary predicates, which the actions maintain.

A durative action is taken as a plan-net action: conditions hold from its start to its end, deletes happen at
its start, effects at its end. That asks for no less than the original does, so plans found are plans of the
original; plans in which one action needs another to run meanwhile are not found. An agent does one action at
a time: an action's agents are its parameters of the types given, else its first parameter.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any

from planner.errors import Unsupported
from planner.fact import Fact
from planner.interchange.foreign.actions import PYTHON_KEYWORDS, ActionReader, Condition, ReadAction
from planner.interchange.foreign.features import check_problem_features
from planner.interchange.pddl.names import Names
from planner.knowledge import (
    ActionSpec,
    KnowledgeBase,
    KnowledgeBaseFile,
    ParameterSpec,
    PredicateSpec,
    TypeSpec,
)
from planner.knowledge.change import DISTANCE, DURATION
from planner.knowledge.expression import DURATION_SCALE
from planner.knowledge.literal import Literal
from planner.knowledge.schema import RELATION, TIME
from planner.problem.interface import PlanningProblem

MAX_COMPLEMENTS = 200_000
DURATION_OF_ACTION = f"{DURATION[0]}()"
RESERVED = frozenset({*PYTHON_KEYWORDS, TIME, RELATION, DURATION_SCALE, DURATION[0], DISTANCE[0]})
PERFORMER = "performer"
"""Stands in as the agent of actions without parameters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadProblem:
    """The result of reading. `actions` maps our tags to the actions read, `objects` our names to
    unified-planning's objects. Only if it `is_exact`, having no plan proves the same of the original.
    """

    knowledge_base: KnowledgeBase
    problem: PlanningProblem
    actions: Mapping[str, ReadAction]
    objects: Mapping[str, Any]
    is_exact: bool


def read_up_problem(
    up_problem: Any, *, agents: Collection[str] = (), costs_as_energy: bool = False
) -> ReadProblem:
    """The knowledge base and the problem of a `unified_planning.model.Problem`.

    :param agents: the types of agents, as the problem names them.
    :param costs_as_energy: each action's energy is its cost, so that `Objective.ENERGY` is the least total cost.
    :raises Unsupported: for what does not fit, naming the feature, the action and a workaround.
    """
    return _Reader(up_problem, agents, costs_as_energy).read()


class _Reader:
    """Reads one problem."""

    def __init__(self, up_problem: Any, agents: Collection[str], costs_as_energy: bool) -> None:
        self._up = up_problem
        self._costs_as_energy = costs_as_energy
        self._agents = agents
        self._types = Names((kind.name for kind in up_problem.user_types), reserved=RESERVED)
        self._fluents = Names((fluent.name for fluent in up_problem.fluents), reserved=RESERVED)
        self._tags = Names((action.name for action in up_problem.actions), reserved=())
        self._objects = Names((item.name for item in up_problem.all_objects), reserved=())
        self._complements: dict[str, str] = {}
        unknown = sorted(set(agents) - {kind.name for kind in up_problem.user_types})
        if unknown:
            known = ", ".join(sorted(kind.name for kind in up_problem.user_types))
            raise Unsupported(f"agents: there is no type {', '.join(unknown)}; choices: {known}")

    def read(self) -> ReadProblem:
        reader = ActionReader(self._fluents, self._objects)
        read = [reader.read(action, self._cost(action)) for action in self._up.actions]
        goals = [c for goal in self._up.goals for c in reader.conditions(goal, None, "the goal")]
        check_problem_features(self._up)
        needs = [*goals, *(condition for action in read for condition in action.conditions)]
        negated = sorted({need.literal.predicate for need in needs if need.negated})
        self._complements = {name: self._fluents.add(f"not_{name}") for name in negated}
        specs = [spec for action in read if (spec := self._spec(action)) is not None]
        if not specs:
            raise Unsupported("no action has an effect that a goal or condition could use")
        constants = {name for action in read for name in action.constants}
        file = KnowledgeBaseFile(
            types=dict(self._type_specs(constants)),
            functions={name: tuple(kinds.values()) for name, kinds in self._signatures(of_numbers=True)},
            predicates=dict(self._predicate_specs()),
            actions=tuple(specs),
        )
        return ReadProblem(
            knowledge_base=KnowledgeBase(file),
            problem=self._problem(constants, [self._wanted(goal) for goal in goals]),
            actions={self._tag(action.up_action): action for action in read},
            objects={self._objects[item.name]: item for item in self._up.all_objects},
            is_exact=not any(
                hasattr(action.up_action, "duration") or [*self._kept_apart(action)] for action in read
            ),
        )

    def _cost(self, up_action: Any) -> Any:
        costs = [metric for metric in self._up.quality_metrics if metric.is_minimize_action_costs()]
        return costs[0].get_action_cost(up_action) if costs else None

    def _tag(self, up_action: Any) -> str:
        return self._tags[up_action.name].upper()

    def _type_specs(self, constants: Collection[str]) -> Iterator[tuple[str, TypeSpec]]:
        for kind in self._up.user_types:
            named = [self._objects[o.name] for o in self._up.all_objects if o.type == kind]
            parent = self._types[kind.father.name] if kind.father else None
            values = tuple(name for name in named if name in constants)
            yield self._types[kind.name], TypeSpec(parent=parent, values=values)
        if any(not action.parameters for action in self._up.actions):
            yield self._types.add(PERFORMER), TypeSpec()

    def _signatures(self, *, of_numbers: bool) -> Iterator[tuple[str, dict[str, str]]]:
        for fluent in self._up.fluents:
            if fluent.type.is_bool_type() != of_numbers:
                names = Names((p.name for p in fluent.signature), reserved=())
                kinds = {names[p.name]: self._types[p.type.name] for p in fluent.signature}
                yield self._fluents[fluent.name], kinds

    def _predicate_specs(self) -> Iterator[tuple[str, PredicateSpec]]:
        for name, kinds in self._signatures(of_numbers=False):
            yield name, PredicateSpec(arguments=kinds)
            if name in self._complements:
                yield self._complements[name], PredicateSpec(arguments=kinds)

    def _spec(self, read: ReadAction) -> ActionSpec | None:
        """The plan-net action; None for one that adds nothing."""
        ended = [literal for literal in read.deletes if literal not in read.adds]
        # What a durative action deletes at its start and brings about again at its end keeps others out meanwhile.
        deletes = list(read.deletes) if hasattr(read.up_action, "duration") else list(ended)
        distinct = [*read.distinct, *self._kept_apart(read)]
        adds = [*read.adds, *(self._complement(literal) for literal in ended if self._is_watched(literal))]
        deletes += [self._complement(literal) for literal in read.adds if self._is_watched(literal)]
        if not adds:
            return None
        parameters = {name: self._types[p.type.name] for name, p in read.up_parameters.items()}
        parameters = parameters or {PERFORMER: self._types.add(PERFORMER)}
        tag = self._tag(read.up_action)
        slots = ", ".join(f"{{{name}}}" for name in parameters)
        return ActionSpec(
            identifier=self._up.actions.index(read.up_action) + 1,
            name=tag,
            parameters=tuple(ParameterSpec(name=name, type=kind) for name, kind in parameters.items()),
            agents=tuple(self._agents_of(read)) or tuple(parameters)[:1],
            distinct=tuple(dict.fromkeys(distinct)),
            preconditions=tuple(dict.fromkeys(str(self._need(c)) for c in read.conditions)),
            delete=tuple(dict.fromkeys(map(str, deletes))),
            intended_effects=tuple(dict.fromkeys(map(str, adds))),
            other_effects=(),
            duration=read.duration,
            energy=DURATION_OF_ACTION if self._costs_as_energy else "0",
            description=f"{tag} {slots}",
        )

    def _agents_of(self, read: ReadAction) -> Iterator[str]:
        for name, parameter in read.up_parameters.items():
            if {kind.name for kind in parameter.type.ancestors} & set(self._agents):
                yield name

    def _is_watched(self, literal: Literal) -> bool:
        return literal.predicate in self._complements

    def _complement(self, literal: Literal) -> Literal:
        return Literal(self._complements[literal.predicate], literal.terms)

    def _need(self, condition: Condition) -> Literal:
        return self._complement(condition.literal) if condition.negated else condition.literal

    def _wanted(self, goal: Condition) -> Fact:
        literal = self._need(goal)
        return Fact(literal.predicate, literal.terms)

    def _kept_apart(self, read: ReadAction) -> Iterator[tuple[str, str]]:
        """Parameters that must differ lest an action add and delete one fact, which its complement could not follow.

        Our choice: of such pairs of literals the first two parameters that differ, which loses the cases in which
        only others do.
        """
        for added, deleted in product(read.adds, read.deletes):
            if added.predicate == deleted.predicate and self._is_watched(added) and added != deleted:
                pairs = zip(added.terms, deleted.terms, strict=True)
                unlike = [pair for pair in pairs if pair[0] != pair[1]]
                if all(set(pair) <= read.up_parameters.keys() for pair in unlike):
                    yield unlike[0]

    def _problem(self, constants: Collection[str], goals: list[Fact]) -> PlanningProblem:
        objects = {self._objects[item.name]: self._types[item.type.name] for item in self._up.all_objects}
        objects = {name: kind for name, kind in objects.items() if name not in constants}
        if PERFORMER in self._types:
            objects[self._objects.add(PERFORMER)] = self._types[PERFORMER]
        facts = set()
        functions = {}
        for fact, value in self._initial():
            if value.is_bool_constant():
                if value.bool_constant_value():
                    facts.add(fact)
            else:
                functions[fact.predicate, fact.args] = float(value.constant_value())
        facts |= {fact for name in self._complements for fact in self._absent(name, facts)}
        return PlanningProblem(
            objects=objects, facts=frozenset(facts), goals=tuple(goals), functions=functions
        )

    def _initial(self) -> Iterator[tuple[Fact, Any]]:
        """The initial values; those that are false by default are left out."""
        default = self._up.fluents_defaults
        sparse = all(
            value.is_bool_constant() and not value.bool_constant_value() for value in default.values()
        )
        values = self._up.explicit_initial_values if sparse else self._up.initial_values
        for expression, value in values.items():
            args = tuple(self._objects[part.object().name] for part in expression.args)
            yield Fact(self._fluents[expression.fluent().name], args), value

    def _absent(self, predicate: str, facts: Collection[Fact]) -> Iterator[Fact]:
        """The complement's facts: where the predicate does not hold."""
        fluent = next(f for f in self._up.fluents if self._fluents[f.name] == predicate)
        choices = [[self._objects[o.name] for o in self._up.objects(p.type)] for p in fluent.signature]
        if prod(map(len, choices)) > MAX_COMPLEMENTS:
            raise Unsupported(
                f"negative conditions: not {fluent.name} would take {prod(map(len, choices))} facts; "
                "use a separate predicate for it"
            )
        for args in product(*choices):
            if Fact(predicate, args) not in facts:
                yield Fact(self._complements[predicate], args)
