"""Removes detours: replaces two actions of the same robots by one that suffices.

Engines that do not distinguish intended from other effects go from a to b to c, or carry a sample along just to get
somewhere. Later actions may need new arguments: they name where their robot came from.
"""

from collections.abc import Iterator, Sequence
from itertools import product

from planner.errors import KnowledgeBaseError
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.progression import apply_action
from planner.problem.interface import PlanningProblem
from planner.problem.zones import ground_action

LONGEST = 600
"""Maximum length of a sequence to shorten: the work grows with its square."""


def without_detours(
    sequence: Sequence[GroundAction], problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> tuple[GroundAction, ...]:
    """The sequence with every pair replaced that one action of the same kind, in less time, can stand for.

    The goals are reached as before, by intended effects. A sequence that does not reach them stays as it is.
    """
    return _Shortening(problem, knowledge_base).run(sequence)


class _Shortening:
    def __init__(self, problem: PlanningProblem, knowledge_base: KnowledgeBase) -> None:
        self._problem = problem
        self._base = knowledge_base
        self._actions: dict[tuple[str, tuple[tuple[str, str], ...]], GroundAction | None] = {}
        """By kind and arguments: the same few are tried in many places of the sequence."""

    def run(self, sequence: Sequence[GroundAction]) -> tuple[GroundAction, ...]:
        kept = list(sequence)
        early = 0
        while early < len(kept) <= LONGEST:
            shorter = self._shorter(kept, early)
            if shorter is None:
                early += 1
            else:
                kept = shorter
                early = 0
        return tuple(kept)

    def _shorter(self, kept: list[GroundAction], early: int) -> list[GroundAction] | None:
        one = kept[early]
        agents = set(one.agents)
        late = next((n for n in range(early + 1, len(kept)) if agents & set(kept[n].agents)), None)
        if late is None or kept[late].tag != one.tag or kept[late].agents != one.agents:
            return None
        between = kept[early + 1 : late]
        after = kept[late + 1 :]
        for merged in self._merged(one, kept[late]):
            for middle in ([*between, merged], [merged, *between]):
                trial = self._replayed([*kept[:early], *middle, *after])
                if trial is not None:
                    return trial
        return None

    def _merged(self, one: GroundAction, other: GroundAction) -> Iterator[GroundAction]:
        """The actions of the same kind with arguments from both that take less time than the two."""
        choices = [
            dict.fromkeys((value, other.arguments.get(name, value))) for name, value in one.arguments.items()
        ]
        for values in product(*choices):
            action = self._action(one, dict(zip(one.arguments, values, strict=True)))
            if action is not None and action.duration_s < one.duration_s + other.duration_s:
                yield action

    def _replayed(self, trial: Sequence[GroundAction]) -> list[GroundAction] | None:
        """The trial, actions bound again where they must be; None if it does not reach the goals."""
        state = set(self._problem.facts)
        achieved = set(self._problem.facts)
        replayed = []
        for planned in trial:
            action = next(
                (fit for fit in self._bindings(planned, state) if state.issuperset(fit.preconditions)), None
            )
            if action is None:
                return None
            apply_action(action, state, achieved)
            replayed.append(action)
        return replayed if achieved.issuperset(self._problem.goals) else None

    def _bindings(self, action: GroundAction, state: set[Fact]) -> Iterator[GroundAction]:
        """The action, then others of its kind for the same effect that its first missing condition suggests."""
        yield action
        missing = next((fact for fact in action.preconditions if fact not in state), None)
        if missing is None:
            return
        for literal in self._base.actions[action.tag].literals("preconditions"):
            if literal.predicate != missing.predicate:
                continue
            for fact in sorted(fact for fact in state if fact.predicate == missing.predicate):
                bound = zip(literal.terms, fact.args, strict=True)
                arguments = {term: value for term, value in bound if term in action.arguments}
                other = self._action(action, {**action.arguments, **arguments})
                if other is not None and set(other.intended_effects) == set(action.intended_effects):
                    yield other

    def _action(self, like: GroundAction, arguments: dict[str, str]) -> GroundAction | None:
        """The action of the same kind and agents with these arguments, if there is one."""
        key = like.tag, tuple(arguments.items())
        if key not in self._actions:
            self._actions[key] = self._grounded(like, arguments)
        action = self._actions[key]
        return action if action is not None and action.agents == like.agents else None

    def _grounded(self, like: GroundAction, arguments: dict[str, str]) -> GroundAction | None:
        problem = self._problem
        free = [p for p in self._base.actions[like.tag].parameters if p.name in arguments and not p.values]
        if len({(p.type, arguments[p.name]) for p in free}) < len(free):
            return None  # parameters of one type are bound to different objects
        try:
            return ground_action(like.tag, arguments, problem, self._base)
        except KnowledgeBaseError:
            return None
