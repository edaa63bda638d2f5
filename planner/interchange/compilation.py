"""From a planning problem to unified-planning's model, and from its operators back to ground actions.

Only intended effects achieve an operator's goal (MACTA §5, table 3): where a goal's predicate also occurs
among other effects, the goal is put to a twin fluent that only intended effects add and that every delete of
the fact removes. Costs are durations in tenths of a second, rounded.

unified-planning takes seconds to import, so it is imported when first needed. Its plan validator only works
in its one global environment, which threads must not fill at the same time: whoever works on its objects
holds `UNIFIED_PLANNING_LOCK`. (Expressions there are kept for good but by content, so the same world adds
nothing twice.)
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from threading import RLock
from typing import Any

from planner.errors import InvalidPlan
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase, Operator
from planner.knowledge.literal import Literal
from planner.problem.duration_table import duration_parameters, duration_table
from planner.problem.interface import PlanningProblem

COST_PER_SECOND = 10
UNIFIED_PLANNING_LOCK = RLock()


@dataclass(frozen=True, slots=True, kw_only=True)
class CompiledProblem:
    """A problem in unified-planning's form. `up_problem` is a `unified_planning.model.Problem`."""

    knowledge_base: KnowledgeBase
    problem: PlanningProblem
    up_problem: Any

    def ground(self, operator_name: str, objects: Sequence[str]) -> GroundAction:
        """The ground action for an operator of the compiled problem and its objects, as named there.

        :raises InvalidPlan: if there is no such operator or it has no duration there.
        """
        op = next((op for op in self.knowledge_base.operators if up_operator(op) == operator_name), None)
        if op is None or len(objects) != len(op.parameters):
            raise InvalidPlan(f"no operator {operator_name}({', '.join(objects)})")
        binding = {name: value[2:] for name, value in zip(op.parameters, objects, strict=True)}
        action = op.ground(binding, self.problem.functions)
        if action is None:
            raise InvalidPlan(f"{operator_name}({', '.join(objects)}) has no duration")
        return action


# One prefix a kind of name, since unified-planning has one namespace for all of them.
def up_operator(op: Operator) -> str:
    return f"a_{op.name}"


def up_object(name: str) -> str:
    return f"o_{name}"


def up_constant(name: str) -> str:
    return f"c_{name.lower()}"


def twin_predicates(knowledge_base: KnowledgeBase, goals: Sequence[Fact]) -> frozenset[str]:
    """The goals' predicates that also occur among other effects."""
    others = {literal.predicate for op in knowledge_base.operators for literal in op.other_effects}
    return frozenset(goal.predicate for goal in goals if goal.predicate in others)


def compile_problem(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> CompiledProblem:
    """The problem in unified-planning's form: lifted, typed, with action costs."""
    with UNIFIED_PLANNING_LOCK:
        up_problem = Compiler(knowledge_base, problem).run()
    return CompiledProblem(knowledge_base=knowledge_base, problem=problem, up_problem=up_problem)


class Compiler:
    """Builds one unified-planning problem: instantaneous actions with costs.

    The methods from `_new_action` to `_minimise` say what an action is made of; other kinds override them.
    """

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        from unified_planning.environment import get_environment
        from unified_planning.model import Problem

        self._base = knowledge_base
        self._problem = problem
        self._environment = get_environment()
        self._types = self._environment.type_manager
        self._expressions = self._environment.expression_manager
        self._up = Problem("macta", self._environment)
        self._objects: dict[str, Any] = {}
        self._fluents: dict[str, Any] = {}
        self._twins = twin_predicates(knowledge_base, problem.goals)

    def run(self) -> Any:
        self._add_objects()
        for name, predicate in self._base.predicates.items():
            self._add_fluent(f"p_{name}", predicate.arguments)
            if name in self._twins:
                self._add_fluent(f"i_{name}", predicate.arguments)
        for fact in sorted(self._problem.facts):
            self._up.set_initial_value(self._of_fact("p", fact), True)
            if fact in self._problem.goals and fact.predicate in self._twins:
                self._up.set_initial_value(self._of_fact("i", fact), True)
        costs = dict(map(self._add_operator, self._base.operators))
        for goal in self._problem.goals:
            self._up.add_goal(self._of_fact("i" if goal.predicate in self._twins else "p", goal))
        self._minimise(costs)
        return self._up

    def _type(self, name: str) -> Any:
        parent = self._base.file.types[name].parent
        return self._types.UserType(f"t_{name}", self._type(parent) if parent else None)

    def _add_objects(self) -> None:
        for name, kind in self._base.constants.items():
            self._objects[name] = self._up.add_object(up_constant(name), self._type(kind))
        for name, kind in sorted(self._problem.objects.items()):
            self._objects[name] = self._up.add_object(up_object(name), self._type(kind))

    def _add_fluent(self, name: str, arguments: Mapping[str, str], kind: Any = None) -> Any:
        from unified_planning.model import Fluent

        signature = {argument: self._type(type_name) for argument, type_name in arguments.items()}
        fluent = Fluent(name, kind or self._types.BoolType(), environment=self._environment, **signature)
        self._fluents[name] = self._up.add_fluent(fluent, default_initial_value=0 if kind else False)
        return fluent

    def _of_fact(self, prefix: str, fact: Fact) -> Any:
        arguments = [self._objects[value] for value in fact.args]
        return self._expressions.FluentExp(self._fluents[f"{prefix}_{fact.predicate}"], arguments)

    def _add_operator(self, op: Operator) -> tuple[Any, Any]:
        parameters = {f"x_{name}": self._type(kind) for name, kind in op.parameters.items()}
        action = self._new_action(up_operator(op), parameters)

        def of(prefix: str, literal: Literal) -> Any:
            terms = [
                self._objects[t] if t not in op.parameters else action.parameter(f"x_{t}")
                for t in literal.terms
            ]
            return self._expressions.FluentExp(self._fluents[f"{prefix}_{literal.predicate}"], terms)

        for literal in op.preconditions:
            changes = literal.predicate in self._base.fluents and literal not in op.deletes
            self._need(action, of("p", literal), lasting=changes)
        for one, other in op.distinct:
            pair = [action.parameter(f"x_{name}") for name in (one, other)]
            self._need(action, self._expressions.Not(self._expressions.Equals(*pair)), lasting=False)
        effects = dict.fromkeys(op.intended_effects + op.other_effects)
        for literal in op.deletes:
            self._delete(action, of("p", literal), restored=literal in effects)
            if literal.predicate in self._twins:
                self._delete(action, of("i", literal), restored=literal in op.intended_effects)
        for literal in effects:
            self._add(action, of("p", literal))
        for literal in op.intended_effects:
            if literal.predicate in self._twins:
                self._add(action, of("i", literal))
        cost = self._cost(op, action)
        self._up.add_action(action)
        return action, cost

    def _new_action(self, name: str, parameters: Mapping[str, Any]) -> Any:
        from unified_planning.model import InstantaneousAction

        return InstantaneousAction(name, _env=self._environment, **parameters)

    def _need(self, action: Any, condition: Any, *, lasting: bool) -> None:
        """:param lasting: to the action's end; else at its start, for what then ends or never changes."""
        action.add_precondition(condition)

    def _delete(self, action: Any, fluent: Any, *, restored: bool) -> None:
        """:param restored: the action's own effects bring it about again."""
        if not restored:
            action.add_effect(fluent, False)

    def _add(self, action: Any, fluent: Any) -> None:
        action.add_effect(fluent, True)

    def _cost(self, op: Operator, action: Any) -> Any:
        """The action's cost: a number, or a static function of the parameters its duration depends on."""
        used = duration_parameters(op)
        if not used:
            return self._expressions.Int(_tenths(op.duration_s({}, self._problem.functions) or 0.0))
        signature = {name: op.parameters[name] for name in used}
        defined = self._add_fluent(f"d_{op.name}", signature)
        cost = self._add_fluent(f"k_{op.name}", signature, self._types.IntType())
        for row, seconds in duration_table(op, self._problem, self._base):
            arguments = [self._objects[name] for name in row]
            self._up.set_initial_value(self._expressions.FluentExp(defined, arguments), True)
            self._up.set_initial_value(self._expressions.FluentExp(cost, arguments), _tenths(seconds))
        terms = [action.parameter(f"x_{name}") for name in used]
        self._need(action, self._expressions.FluentExp(defined, terms), lasting=False)
        return self._expressions.FluentExp(cost, terms)

    def _minimise(self, costs: Mapping[Any, Any]) -> None:
        from unified_planning.model.metrics import MinimizeActionCosts

        self._up.add_quality_metric(MinimizeActionCosts(dict(costs), environment=self._environment))


def _tenths(seconds: float) -> int:
    return max(1, round(seconds * COST_PER_SECOND))
