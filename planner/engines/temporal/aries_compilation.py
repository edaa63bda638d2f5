"""A planning problem in unified-planning's form with durative actions, for Aries.

Conditions hold from an action's start to its end unless it deletes them, deletes happen at its start, effects at its
end: the plan-net's own semantics. Durations are tenths of a second, in whole numbers: a number, or a static function
of the parameters that the duration depends on. Operators and objects are named as in the PDDL of the same problem.

Only intended effects achieve a goal (MACTA §5, table 3): where a goal's predicate also occurs among other effects, the
goal is on a twin fluent that only intended effects add and every delete of the fact removes.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from unified_planning.environment import get_environment
from unified_planning.model import (
    ClosedTimeInterval,
    DurativeAction,
    EndTiming,
    Fluent,
    Problem,
    StartTiming,
)
from unified_planning.model.metrics import MinimizeMakespan

from planner.fact import Fact
from planner.interchange.pddl import Form, Vocabulary
from planner.interchange.stated_zones import StatedZones
from planner.knowledge import KnowledgeBase, Operator
from planner.problem.duration_table import duration_parameters, duration_table
from planner.problem.interface import PlanningProblem

TENTHS = 10


class AriesCompiler:
    """Builds one unified-planning problem: lifted, typed, durative, with the makespan to minimise."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        stated = StatedZones(knowledge_base, problem)
        self._base = knowledge_base = stated.knowledge_base
        self._problem = problem = stated.problem
        self._words = Vocabulary(knowledge_base, Form.TEMPORAL)
        environment = get_environment()
        self._types = environment.type_manager
        self._expressions = environment.expression_manager
        self._up = Problem("macta", environment)
        self._objects: dict[str, Any] = {}
        self._fluents: dict[str, Any] = {}
        others = {literal.predicate for op in knowledge_base.operators for literal in op.other_effects}
        self._twins = others.intersection(goal.predicate for goal in problem.goals)

    def run(self) -> Any:
        """The `unified_planning.model.Problem`."""
        for name, kind in (*self._base.constants.items(), *sorted(self._problem.objects.items())):
            self._objects[name] = self._up.add_object(self._words.objects.add(name), self._type(kind))
        # What holds between phases has all arguments of an action, and each value is listed; no whole action reads it.
        unread = self._base.under_way
        for name, predicate in self._base.predicates.items():
            if name in unread:
                continue
            self._add_fluent(f"p_{name}", predicate.arguments)
            if name in self._twins:
                self._add_fluent(f"i_{name}", predicate.arguments)
        for fact in sorted(fact for fact in self._problem.facts if fact.predicate not in unread):
            self._up.set_initial_value(self._of_fact("p", fact), True)
            if fact in self._problem.goals and fact.predicate in self._twins:
                self._up.set_initial_value(self._of_fact("i", fact), True)
        for op in self._base.operators:
            self._add_operator(op)
        for goal in self._problem.goals:
            self._up.add_goal(self._of_fact("i" if goal.predicate in self._twins else "p", goal))
        self._up.add_quality_metric(MinimizeMakespan())
        return self._up

    def _type(self, name: str) -> Any:
        parent = self._base.file.types[name].parent
        return self._types.UserType(f"t_{name}", self._type(parent) if parent else None)

    def _add_fluent(self, name: str, arguments: Mapping[str, str], kind: Any = None) -> None:
        signature = {argument: self._type(type_name) for argument, type_name in arguments.items()}
        fluent = Fluent(name, kind or self._types.BoolType(), **signature)
        self._fluents[name] = self._up.add_fluent(fluent, default_initial_value=0 if kind else False)

    def _of_fact(self, prefix: str, fact: Fact) -> Any:
        return self._term(f"{prefix}_{fact.predicate}", (self._objects[value] for value in fact.args))

    def _term(self, fluent: str, arguments: Iterable[Any]) -> Any:
        return self._expressions.FluentExp(self._fluents[fluent], list(arguments))

    def _add_operator(self, op: Operator) -> None:
        parameters = {f"x_{name}": self._type(kind) for name, kind in op.parameters.items()}
        action = DurativeAction(self._words.operators[op.name], **parameters)
        terms: dict[str, Any] = {name: action.parameter(f"x_{name}") for name in op.parameters}
        terms = {**self._objects, **terms}
        start = StartTiming()
        end = EndTiming()
        for literal in op.preconditions:
            changes = literal.predicate in self._base.fluents and literal not in op.deletes
            condition = self._term(f"p_{literal.predicate}", (terms[t] for t in literal.terms))
            action.add_condition(ClosedTimeInterval(start, end) if changes else start, condition)
        for one, other in op.distinct:
            same = self._expressions.Equals(terms[one], terms[other])
            action.add_condition(start, self._expressions.Not(same))
        effects = dict.fromkeys(op.intended_effects + op.other_effects)
        for timing, prefix, literals, value in (
            (start, "p", op.deletes, False),
            (start, "i", op.deletes, False),
            (end, "p", effects, True),
            (end, "i", op.intended_effects, True),
        ):
            for literal in literals:
                if prefix == "p" or literal.predicate in self._twins:
                    fluent = self._term(f"{prefix}_{literal.predicate}", (terms[t] for t in literal.terms))
                    action.add_effect(timing, fluent, value)
        self._set_duration(op, action, terms)
        self._up.add_action(action)

    def _set_duration(self, op: Operator, action: Any, terms: Mapping[str, Any]) -> None:
        used = duration_parameters(op)
        if not used:
            action.set_fixed_duration(_tenths(op.duration_s({}, self._problem.functions) or 0.0))
            return
        signature = {name: op.parameters[name] for name in used}
        self._add_fluent(f"d_{op.name}", signature)
        self._add_fluent(f"k_{op.name}", signature, self._types.IntType())
        for row, seconds in duration_table(op, self._problem, self._base):
            arguments = [self._objects[name] for name in row]
            self._up.set_initial_value(self._term(f"d_{op.name}", arguments), True)
            self._up.set_initial_value(self._term(f"k_{op.name}", arguments), _tenths(seconds))
        of_parameters = [terms[name] for name in used]
        action.add_condition(StartTiming(), self._term(f"d_{op.name}", of_parameters))
        action.set_fixed_duration(self._term(f"k_{op.name}", of_parameters))


def _tenths(seconds: float) -> int:
    return max(1, round(seconds * TENTHS))
