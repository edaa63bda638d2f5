"""Independent validation: unified-planning's plan validator on a linearisation of the plan-net.

Each action is ground again from its name and arguments by the knowledge base, so a plan-net with other conditions or
effects is rejected. Static conditions are looked up at once; the rest is put to unified-planning as ground actions over
propositions, one a fact: evaluating a fluent's arguments, all constants, would be a third of its work.

The validator's work grows with the square of a plan's length, so it gets the plan in stretches. Each starts from
the facts that the stretch before was to end with, and these are goals there beside the plan's own. Conditions
are all positive, so what can be done from these facts can be done from any state that holds more of them:
stretches that are each valid make a valid plan.

Sequences have no times, so that numbers are left out: `planner.problem.number_courses` checks them, and other
validators do from the PDDL of `planner.interchange.pddl.numbers`.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from planner.errors import KnowledgeBaseError
from planner.fact import Fact
from planner.interchange.up_import import import_unified_planning
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import PlanNet
from planner.plan_nets.validation import linearisation
from planner.problem.interface import PlanningProblem
from planner.problem.zones import ground_action

STRETCH = 50

HOLDS = "p"
ACHIEVED = "i"
"""The twin of a goal's fact: held since an intended effect brought it about."""
Atom = tuple[str, Fact]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Step:
    """A ground action without its static conditions."""

    name: str
    needs: tuple[Atom, ...]
    deletes: tuple[Atom, ...]
    adds: tuple[Atom, ...]


def up_fault(knowledge_base: KnowledgeBase, problem: PlanningProblem, plan_net: PlanNet) -> str | None:
    """What the knowledge base or `SequentialPlanValidator` finds wrong, or None."""
    try:
        steps = list(_steps(knowledge_base, problem, plan_net))
    except KnowledgeBaseError as error:
        return str(error)
    state: set[Atom] = {(HOLDS, fact) for fact in problem.facts}
    state |= {(ACHIEVED, goal) for goal in plan_net.goals if goal in problem.facts}
    final = [(ACHIEVED, goal) for goal in plan_net.goals]
    with UNIFIED_PLANNING_LOCK:
        for first in range(0, max(1, len(steps)), STRETCH):
            stretch = steps[first : first + STRETCH]
            last = first + STRETCH >= len(steps)
            touched = {atom for step in stretch for atom in (*step.needs, *step.deletes, *step.adds)}
            touched |= set(final) if last else set()
            before = state & touched
            for step in stretch:
                state.difference_update(step.deletes)
                state.update(step.adds)
            wanted = {*(state & touched), *(final if last else ())}
            fault = _Stretch(touched).fault(sorted(before), stretch, sorted(wanted))
            if fault is not None:
                return fault
    return None


def _steps(knowledge_base: KnowledgeBase, problem: PlanningProblem, plan_net: PlanNet) -> Iterator[_Step]:
    """:raises KnowledgeBaseError: if an action is not what the knowledge base makes of its arguments, or a
    static condition does not hold."""
    fluents = knowledge_base.fluents
    goals = frozenset(plan_net.goals)
    for action in linearisation(plan_net):
        name = f"{action.id}_{action.tag.lower()}"
        own = ground_action(action.tag, action.arguments, problem, knowledge_base, phase=action.phase)
        for slot in ("agents", "preconditions", "deletes", "intended_effects", "other_effects"):
            if set(getattr(own, slot)) != set(getattr(action, slot)):
                raise KnowledgeBaseError(f"{name}: its {slot} are not those of {own}")
        for fact in own.preconditions:
            if fact.predicate not in fluents and fact not in problem.facts:
                raise KnowledgeBaseError(f"{name} needs {fact}, which never holds")
        yield _Step(
            name=name,
            needs=tuple((HOLDS, fact) for fact in own.preconditions if fact.predicate in fluents),
            deletes=_atoms(own.deletes, goals.intersection(own.deletes)),
            adds=_atoms(own.effects, goals.intersection(own.intended_effects)),
        )


def _atoms(facts: Iterable[Fact], goals: Iterable[Fact]) -> tuple[Atom, ...]:
    return (*((HOLDS, fact) for fact in facts), *((ACHIEVED, goal) for goal in sorted(goals)))


class _Stretch:
    """A stretch of the plan as a propositional problem of unified-planning's, with no more than it touches."""

    def __init__(self, touched: Iterable[Atom]) -> None:
        import_unified_planning()
        from unified_planning.environment import get_environment
        from unified_planning.model import Fluent

        self._environment = get_environment()
        self._up = _strips(self._environment)
        self._atoms = {}
        for mark, fact in sorted(touched):
            fluent = Fluent(f"{mark}_{fact}", environment=self._environment)
            self._up.add_fluent(fluent, default_initial_value=False)
            self._atoms[mark, fact] = self._environment.expression_manager.FluentExp(fluent)

    def fault(self, before: Sequence[Atom], steps: Sequence[_Step], wanted: Sequence[Atom]) -> str | None:
        """The validator's objection to the steps from `before` to `wanted`."""
        from unified_planning.engines.plan_validator import SequentialPlanValidator
        from unified_planning.engines.results import ValidationResultStatus
        from unified_planning.plans import ActionInstance, SequentialPlan

        for atom in before:
            self._up.set_initial_value(self._atoms[atom], True)
        for atom in wanted:
            self._up.add_goal(self._atoms[atom])
        actions = [self._action(step) for step in steps]
        validator = SequentialPlanValidator()
        validator.skip_checks = True  # of the problem's kind, known by construction
        result = validator.validate(self._up, SequentialPlan([ActionInstance(a, ()) for a in actions]))
        if result.status is ValidationResultStatus.VALID:
            return None
        said = "; ".join(message.message for message in result.log_messages or ())
        return said or "the validator rejects the plan"

    def _action(self, step: _Step) -> Any:
        from unified_planning.model import InstantaneousAction

        action = InstantaneousAction(step.name)
        for atom in step.needs:
            action.add_precondition(self._atoms[atom])
        for atom in step.deletes:
            if atom not in step.adds:
                action.add_effect(self._atoms[atom], False)
        for atom in dict.fromkeys(step.adds):
            action.add_effect(self._atoms[atom], True)
        self._up.add_action(action)
        return action


def _strips(environment: Any) -> Any:
    """A problem with the fixed kind typed STRIPS, which is else computed at each access."""
    from unified_planning.model import Problem, ProblemKind

    kind = ProblemKind({"ACTION_BASED", "FLAT_TYPING", "HIERARCHICAL_TYPING"})

    class Strips(Problem):  # type: ignore[misc]
        @property
        def kind(self) -> Any:
            return kind.clone()

    return Strips("stretch", environment)
