"""Which goals are planned together: a task each as far as they do not stand in each other's way.

Goals on the same thing are one task. If a goal can only be reached by moving what another goal is about (its place is
taken by a sample that is to go elsewhere), it is planned from the state in which that goal has been reached; goals that
block each other in a circle (two samples that change places) are one task. Where such tasks do not compose, for all of
them want the only spare place, say, they are chained: each is planned from where those before it lead.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import exp

from planner.engine import PlanningProblem
from planner.fact import Fact
from planner.hierarchical.building import NO_DEADLINE_S, Task
from planner.hierarchical.fragments import Fragment
from planner.hierarchical.legs import Vocabulary
from planner.knowledge import GroundAction
from planner.progression import progressed

PRIORITY_SCALE = 20.0
"""Priorities this far apart: a second of lateness counts e times as much."""

Goals = tuple[Fact, ...]
Find = Callable[[PlanningProblem, Goals], Sequence[Fragment]]
"""The fragments that reach these goals from a problem's facts, quickest first; none if none was found."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unmet:
    """Goals for which no fragment was found."""

    goals: Goals


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Tasks that work one after the other, and the actions of their first fragments in that order."""

    tasks: tuple[Task, ...]
    actions: tuple[GroundAction, ...]


class TaskFinder:
    """Splits a problem's goals into tasks and finds their fragments."""

    def __init__(self, problem: PlanningProblem, words: Vocabulary, find: Find) -> None:
        self._problem, self._words, self._find = problem, words, find
        self._found: dict[Goals, list[Fragment]] = {}
        self._all = self._groups()

    def tasks(self) -> tuple[Task, ...] | Unmet:
        """The tasks, or goals that cannot be reached alone."""
        waiting = [goals for goals in self._all if self._is_open(goals, self._problem.facts)]
        settled: list[Goals] = []
        while waiting:
            progress = False
            for goals in list(waiting):
                fragments, blockers = self._look(goals, settled, waiting)
                if fragments:
                    self._found[goals] = fragments
                    settled.append(goals)
                    waiting.remove(goals)
                    progress = True
                elif blockers is None:
                    return Unmet(goals=goals)
            if not progress and (merged := self._merged(waiting, settled)) is not None:
                waiting = merged
            elif not progress:
                return Unmet(goals=waiting[0])
        return tuple(self._task(goals, self._found[goals]) for goals in settled)

    def chain(self) -> Chain | None:
        """The tasks one after the other, None if they do not work in the order looked at: those first that leave
        the others' things alone; what was reached is never touched again."""
        facts = self._problem.facts
        tasks: dict[Goals, Task] = {}
        actions: list[GroundAction] = []
        while waiting := [g for g in self._all if self._is_open(g, facts) and g not in tasks]:
            settled = [goals for goals in self._all if goals in tasks]
            chosen = self._next(replace(self._problem, facts=facts), waiting, settled)
            if chosen is None:
                return None
            goals, fragments = chosen
            tasks[goals] = self._task(goals, fragments)
            actions += fragments[0].actions
            facts = progressed(facts, fragments[0].actions)
        if not facts.issuperset(self._problem.goals):
            return None
        return Chain(tasks=tuple(tasks.values()), actions=tuple(actions))

    def _next(
        self, posed: PlanningProblem, waiting: Sequence[Goals], settled: Sequence[Goals]
    ) -> tuple[Goals, list[Fragment]] | None:
        """The first of the waiting tasks that moves nothing of the others, else the one that moves least."""
        best: tuple[int, Goals, list[Fragment]] | None = None
        for goals in sorted(waiting, key=self._is_posture):
            open_ones = [other for other in self._all if other != goals and other not in settled]
            found = [f for f in self._find(posed, goals) if not self._moved(f, settled)]
            least = min((len(self._moved(f, open_ones)) for f in found), default=None)
            if least is None or (best is not None and best[0] <= least):
                continue
            best = least, goals, [f for f in found if len(self._moved(f, open_ones)) == least]
            if least == 0:
                break
        return best[1:] if best else None

    def _look(
        self, goals: Goals, settled: Sequence[Goals], waiting: Sequence[Goals]
    ) -> tuple[list[Fragment], set[Goals] | None]:
        """Fragments that leave the other tasks' things alone, else the tasks in their way (None: no fragment)."""
        found = list(self._find(self._problem, goals))
        kept = [o for o in self._all if not self._is_open(o, self._problem.facts)]
        others = [other for other in (*kept, *settled, *waiting) if other != goals]
        free = [fragment for fragment in found if not self._moved(fragment, others)]
        if free or not found:
            return free, None
        blockers = min((self._moved(fragment, others) for fragment in found), key=len)
        if not blockers.issubset(settled):
            return [], blockers
        after = self._after([other for other in settled if other in blockers])
        if after is None:
            return [], blockers
        later = self._find(replace(self._problem, facts=after), goals)
        return [fragment for fragment in later if not self._moved(fragment, others)], blockers

    def _after(self, done: Sequence[Goals]) -> frozenset[Fact] | None:
        """The facts once these tasks are done one after the other."""
        facts = self._problem.facts
        for goals in done:
            found = self._find(replace(self._problem, facts=facts), goals)
            if not found:
                return None
            facts = progressed(facts, found[0].actions)
        return facts

    def _merged(self, waiting: list[Goals], settled: Sequence[Goals]) -> list[Goals] | None:
        """The waiting tasks with one of them and those in its way made one; None if that is no change."""
        for goals in waiting:
            _, blockers = self._look(goals, settled, waiting)
            together = [other for other in waiting if other in (blockers or ())]
            if together:
                rest = [other for other in waiting if other != goals and other not in together]
                return [(*goals, *(goal for other in together for goal in other)), *rest]
        return None

    def _moved(self, fragment: Fragment, others: Iterable[Goals]) -> set[Goals]:
        """The other tasks whose things the fragment changes."""
        touched = {
            arg
            for action in fragment.actions
            for fact in (*action.deletes, *action.effects)
            for arg in self._words.themes.intersection(fact.args)
        }
        return {other for other in others if not touched.isdisjoint(self._things(other))}

    def _things(self, goals: Goals) -> set[str]:
        return {arg for goal in goals for arg in goal.args if arg in self._words.themes}

    def _groups(self) -> list[Goals]:
        """The goals, those on the same thing or the same agents' configuration together."""
        groups: list[tuple[set[str], list[Fact]]] = []
        for goal in dict.fromkeys(self._problem.goals):
            things = self._things((goal,))
            if self._words.is_configuration(goal):
                things = set(self._words.agents_of(goal))
            same = [group for group in groups if not group[0].isdisjoint(things)]
            groups = [group for group in groups if group not in same]
            goals = [g for group in same for g in group[1]]
            groups.append((things.union(*(group[0] for group in same)), [*goals, goal]))
        return [tuple(goals) for _, goals in groups]

    def _is_open(self, goals: Goals, facts: frozenset[Fact]) -> bool:
        """True if something is to be done: agents may have to come back where they are now."""
        return self._is_posture(goals) or not facts.issuperset(goals)

    def _is_posture(self, goals: Goals) -> bool:
        return any(self._words.is_configuration(goal) for goal in goals)

    def _task(self, goals: Goals, fragments: Iterable[Fragment]) -> Task:
        problem = self._problem
        return Task(
            goals=goals,
            fragments=tuple(fragment.actions for fragment in fragments),
            deadline_s=min(problem.deadlines_s.get(goal, NO_DEADLINE_S) for goal in goals),
            weight=exp(max(problem.priorities.get(goal, 0) for goal in goals) / PRIORITY_SCALE),
        )
