"""The PDDL names of a knowledge base's types, predicates, functions, operators and objects."""

from collections.abc import Iterable, Iterator, Mapping
from enum import StrEnum

from planner.interchange.pddl.names import Names
from planner.knowledge import KnowledgeBase, Operator, Phase
from planner.knowledge.literal import Literal
from planner.problem.duration_table import duration_parameters


class Form(StrEnum):
    """The kind of PDDL."""

    TEMPORAL = "temporal"
    """PDDL 2.1: durative actions, makespan."""
    NUMERIC = "numeric"
    """The same with the numbers that plans keep within limits (`planner.interchange.pddl.numbers`)."""
    CLASSICAL = "classical"
    """Instantaneous actions with costs."""


class Vocabulary:
    """The names of one knowledge base in one form; problems add their objects."""

    def __init__(
        self,
        knowledge_base: KnowledgeBase,
        form: Form,
        *,
        is_simplified: bool = False,
        has_phases: bool = False,
    ) -> None:
        """
        :param is_simplified: for planners that cannot do more: durations as tables, nothing keeps agents to one
            action at a time (the plan-net orders their actions).
        :param has_phases: True: phases are durative actions. Else actions stay whole, which asks for no less: their
            conditions hold throughout, and what they bring about comes at their end.
        """
        self.base = knowledge_base
        self.is_temporal = form is not Form.CLASSICAL
        self.has_numbers = form is Form.NUMERIC
        self.is_simplified = is_simplified
        self.types = Names(knowledge_base.file.types)
        self.steps = knowledge_base.steps if has_phases and self.is_temporal else knowledge_base.operators
        self.operators = Names(op.name for op in self.steps)
        self._words = Names((*knowledge_base.predicates, *knowledge_base.file.functions))
        self.objects = Names(knowledge_base.constants, (self.types, self.operators, self._words))
        self.twins = {effect.predicate for op in knowledge_base.operators for effect in op.other_effects}

    def word(self, name: str, kind: str = "") -> str:
        """A predicate's or function's name; with a kind, the name of an auxiliary one."""
        return self._words.add(f"{kind}_{name}") if kind else self._words.add(name)

    def atom(self, word: str, terms: Iterable[str], op: Operator | None = None) -> str:
        """`(word ?parameter object …)`; parameters are those of the operator."""
        open_terms = op.parameters if op else {}
        written = [f"?{term}" if term in open_terms else self.objects[term] for term in terms]
        return f"({' '.join([word, *written])})"

    def literal(self, literal: Literal, op: Operator) -> str:
        return self.atom(self.word(literal.predicate), literal.terms, op)

    def twin(self, literal: Literal, op: Operator) -> str:
        return self.atom(self.word(literal.predicate, "intended"), literal.terms, op)

    def declared(self, word: str, arguments: Mapping[str, str]) -> str:
        """`(word ?argument - type …)`"""
        return (
            " ".join([f"({word}", *(f"?{name} - {self.types[kind]}" for name, kind in arguments.items())])
            + ")"
        )

    def is_tabled(self, op: Operator) -> bool:
        """True if the operator's cost or duration is a table: all costs are, and durations of teams and phases."""
        return isinstance(op, Phase) or (
            bool(duration_parameters(op))
            and (not self.is_temporal or self.is_simplified or len(op.members) > 1)
        )

    def measured(self, op: Operator) -> dict[str, str]:
        """The parameters of the operator's measure, with their types."""
        used = duration_parameters(op) if self.is_tabled(op) else ()
        return {name: op.parameters[name] for name in used}

    def measure(self, op: Operator) -> str:
        """The function for the operator's cost, its duration, or the factor of its duration."""
        kind = "cost" if not self.is_temporal else "duration" if self.is_tabled(op) else "scale"
        return self.word(op.name, kind)

    def guards(self, op: Operator) -> Iterator[str]:
        """The atoms which state that the functions the operator needs have values."""
        if self.is_tabled(op):
            yield self.atom(self.word(op.name, "defined"), self.measured(op), op)
        elif self.is_temporal:
            for name, terms in op.duration.calls:
                alias = op.members[0]
                if terms:
                    yield self.atom(self.word(name, "defined"), [alias.get(t, t) for t in terms], op)

    def agent_types(self) -> list[str]:
        """The types of agents that are `idle` between actions, none of them a subtype of another."""
        kinds = self.base.agent_types if self.is_temporal and not self.is_simplified else frozenset()
        return sorted(k for k in kinds if not any(o != k and self.base.file.is_a(k, o) for o in kinds))

    def idle(self, agent: str, op: Operator) -> str:
        """`(idle_robot ?agent)`, by the most general agent type."""
        kind = next(k for k in self.agent_types() if self.base.file.is_a(op.parameters[agent], k))
        return self.atom(self.word(kind, "idle"), (agent,), op)
