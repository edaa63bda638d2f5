"""Fragments: sequences of actions that reach some goals by themselves from the present facts (MACTA §6).

Found by search from the knowledge base, lifted, and bound to all goals of the same shape by a join over the
facts, so that most goals need no search of their own. Lifted fragments can be kept across problems: every binding is
checked against the facts of its own problem.
"""

from collections import Counter
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

from planner.engines.hierarchical.fragments.binding import Bound, join
from planner.engines.hierarchical.fragments.discovery import ALL_LEVELS, discover
from planner.engines.hierarchical.fragments.lifting import LiftedFragment, lift, signature
from planner.engines.hierarchical.fragments.steps import Step
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase, Operator
from planner.problem.interface import UNOBSERVED, PlanningProblem
from planner.problem.zones import ground


@dataclass(frozen=True, slots=True, kw_only=True)
class Fragment:
    """Actions that reach the goals from the problem's facts in this order; each is needed and intended."""

    goals: tuple[Fact, ...]
    actions: tuple[GroundAction, ...]

    @property
    def duration_s(self) -> float:
        """The sum of the actions' durations."""
        return sum(action.duration_s for action in self.actions)


class Fragments:
    """The lifted fragments learnt with one knowledge base, by the shape of goals."""

    def __init__(self, knowledge_base: KnowledgeBase) -> None:
        self.knowledge_base = knowledge_base
        self.known: dict[Hashable, tuple[LiftedFragment, ...]] = {}

    def of(self, problem: PlanningProblem) -> "ProblemFragments":
        """The fragments of one problem."""
        return ProblemFragments(self, problem)


class ProblemFragments:
    """The fragments of one problem's goals."""

    def __init__(self, fragments: Fragments, problem: PlanningProblem) -> None:
        self.problem = problem
        self._learnt = fragments.known
        self._index = WorldIndex(fragments.knowledge_base, problem)
        self._actions: dict[tuple[str, tuple[str, ...]], GroundAction] = {}

    def alternatives(
        self,
        goals: tuple[Fact, ...],
        *,
        limit: int = 12,
        levels: int = ALL_LEVELS,
        is_over: Callable[[], bool] = UNOBSERVED.should_stop,
    ) -> tuple[Fragment, ...]:
        """Fragments for these goals together, the least sum of durations first; () if none was found.

        They differ in operators, in kinds of agents or in the places used, not in which agent of a kind.

        :param levels: how wide a world is searched; 0: none, only fragments learnt from any goals are used.
        :param is_over: asked now and then; True ends the search.
        """
        goals = tuple(dict.fromkeys(goals))
        if self.problem.facts.issuperset(goals):
            return (Fragment(goals=goals, actions=()),)
        shape = signature(self._index, goals), levels
        known = self._learnt.get(shape, ())
        bound = self._bound(known if levels else self._learnt_of(goals), goals)
        solutions: Sequence[tuple[Step, ...]] = ()
        if not bound and levels and not is_over():
            solutions = discover(self._index, goals, levels, is_over)
            fresh = tuple(lift(self._index, goals, steps) for steps in solutions)
            self._learnt[shape] = tuple(dict.fromkeys((*known, *fresh)))
            bound = self._bound(fresh, goals)
        chosen = undominated(self._index, bound)[:limit]
        if chosen:
            return tuple(self._fragment(goals, each.steps) for each in chosen)
        ranked = sorted(solutions, key=lambda steps: sum(step.cost for step in steps))
        return tuple(
            self._fragment(goals, [(step.op, step.args) for step in steps]) for steps in ranked[:limit]
        )

    def _learnt_of(self, goals: Sequence[Fact]) -> tuple[LiftedFragment, ...]:
        """What was learnt for goals of these predicates, whatever their shape."""
        wanted = [goal.predicate for goal in goals]
        learnt = dict.fromkeys(fragment for known in self._learnt.values() for fragment in known)
        return tuple(f for f in learnt if [pattern.predicate for pattern in f.goals] == wanted)

    def _bound(self, lifted: Sequence[LiftedFragment], goals: Sequence[Fact]) -> list[Bound]:
        return [bound for fragment in lifted for bound in join(self._index, fragment, goals)]

    def _fragment(
        self, goals: tuple[Fact, ...], steps: Sequence[tuple[Operator, tuple[str, ...]]]
    ) -> Fragment:
        return Fragment(goals=goals, actions=tuple(self._action(op, args) for op, args in steps))

    def _action(self, op: Operator, args: tuple[str, ...]) -> GroundAction:
        key = op.name, args
        if key not in self._actions:
            action = ground(
                op, dict(zip(op.parameters, args, strict=True)), self.problem, self._index.knowledge_base
            )
            assert action is not None, f"{op.name}{args} has no duration"
            self._actions[key] = action
        return self._actions[key]


def undominated(index: WorldIndex, bound: Sequence[Bound]) -> list[Bound]:
    """By cost, each set of steps once, without those that only add agents and operators to a cheaper one."""
    kept: dict[frozenset[tuple[str, tuple[str, ...]]], tuple[Bound, Counter[object]]] = {}
    for each in sorted(bound, key=lambda each: each.cost):
        steps = frozenset((op.name, args) for op, args in each.steps)
        if steps in kept:
            continue
        used: Counter[object] = Counter((op.spec.name, len(op.agents)) for op, _ in each.steps)
        used.update({(index.kind_of[agent],): 1 for agent in each.agents})
        if not any(other < used for _, other in kept.values()):
            kept[steps] = each, used
    return [each for each, _ in kept.values()]
