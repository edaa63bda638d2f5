"""Splits a problem's goals into tasks, one each unless they block each other.

Goals on the same thing are one task. If a goal can only be reached by moving what another goal is about (its place is
taken by a sample with another goal), the tasks make way for each other (`blocking`) or, if they cannot, are merged.
Tasks that do not compose are chained: each is planned from the facts after those before it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import exp

from planner.engines.hierarchical.blocking import BlockingTasks, FindFragments
from planner.engines.hierarchical.fragments.fragment import Fragment
from planner.engines.hierarchical.legs.goal_groups import Goals, Group, Groups
from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.engines.hierarchical.rearrangement import Rearrangement
from planner.engines.hierarchical.scheduling_problem import NO_DEADLINE_S, Move, Task
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.progression import progressed

PRIORITY_SCALE = 20.0
"""A priority difference of this size weighs a second of lateness e times as much."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unmet:
    """Goals for which no fragment was found."""

    goals: Goals


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Tasks in an order in which they can be carried out, and the actions of their first fragments."""

    tasks: tuple[Task, ...]
    actions: tuple[GroundAction, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Arranged:
    """Tasks, and moves in an order in which they can be carried out."""

    tasks: tuple[Task, ...]
    moves: tuple[Move, ...]


class TaskFinder:
    """Splits a problem's goals into tasks and finds their fragments."""

    def __init__(self, classified: ClassifiedProblem, find: FindFragments, *, resumes: bool = False) -> None:
        """:param resumes: see `PlanningRequest`."""
        self._problem = classified.problem
        self._classified = classified
        self._groups = Groups(classified)
        self._find = find
        self.interacts = False
        """Some tasks are known to block each other."""
        self._blocking = BlockingTasks(classified, self._groups, find, resumes=resumes)

    def rearranged(self) -> Arranged | None:
        """The tasks ordered by the rooms that their things leave and take up; None if there is no such order, or
        nothing in the way."""
        found = Rearrangement(self._classified, self._groups, self._find).found()
        if found is None:
            return None
        self.interacts = True
        return Arranged(
            tasks=tuple(self._task(group, ways) for group, ways in found.ways.items()),
            moves=tuple(found.moves),
        )

    def tasks(self) -> tuple[Task, ...] | Unmet:
        """The tasks, or goals that cannot be reached alone."""
        groups = list(self._groups.wanted)
        while True:
            found = self._blocking.ways(groups)
            if not isinstance(found, list):
                self.interacts |= self._blocking.has_blocking
                return tuple(self._task(group, ways) for group, ways in found.items())
            if len(found) == 1:
                return Unmet(goals=found[0].goals)
            self.interacts = True
            groups = [Group.of(found), *(group for group in groups if group not in found)]

    def chain(self) -> Chain | None:
        """The tasks in sequence, those first that leave the others' things alone; reached goals are not touched
        again. None if they cannot be carried out in this order."""
        facts = self._problem.facts
        groups = self._groups
        tasks: dict[Group, Task] = {}
        actions: list[GroundAction] = []
        while waiting := [g for g in groups.wanted if groups.is_open(g, facts) and g not in tasks]:
            chosen = self._next(facts, waiting, tuple(tasks))
            if chosen is None:
                return None
            group, fragments = chosen
            tasks[group] = self._task(group, fragments)
            actions += fragments[0].actions
            facts = progressed(facts, fragments[0].actions)
        if not facts.issuperset(self._problem.goals):
            return None
        return Chain(tasks=tuple(tasks.values()), actions=tuple(actions))

    def _next(
        self, facts: frozenset[Fact], waiting: Sequence[Group], settled: Sequence[Group]
    ) -> tuple[Group, list[Fragment]] | None:
        """The first of the waiting tasks that moves nothing of the others, else the one that moves least."""
        moved = self._groups.moved
        best: tuple[int, Group, list[Fragment]] | None = None
        for group in sorted(waiting, key=self._groups.is_final_configuration):
            rest = [other for other in self._groups.wanted if other != group and other not in settled]
            found = [f for f in self._find(facts, group.goals) if not moved(f.actions, settled)]
            least = min((len(moved(f.actions, rest)) for f in found), default=None)
            if least is None or (best is not None and best[0] <= least):
                continue
            best = least, group, [f for f in found if len(moved(f.actions, rest)) == least]
            if least == 0:
                break
        return best[1:] if best else None

    def _task(self, group: Group, fragments: Iterable[Fragment]) -> Task:
        problem = self._problem
        goals = group.goals
        return Task(
            goals=goals,
            fragments=tuple(fragment.actions for fragment in fragments),
            deadline_s=min(
                (problem.deadlines_s.get(goal, NO_DEADLINE_S) for goal in goals), default=NO_DEADLINE_S
            ),
            weight=exp(max((problem.priorities.get(goal, 0) for goal in goals), default=0) / PRIORITY_SCALE),
        )
