"""Finds fragments by search: the first in increasingly large worlds, then others without its agents or operators.

Where a small world's delete relaxation does not reach the goals, and neither does that of the whole problem, the
search ends.
"""

from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice

from planner.engines.hierarchical.fragments.forward_search import search
from planner.engines.hierarchical.fragments.grounding import task_of
from planner.engines.hierarchical.fragments.heuristic import is_reachable
from planner.engines.hierarchical.fragments.relevance import LEVELS, small_world
from planner.engines.hierarchical.fragments.steps import Step, Task
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.fact import Fact
from planner.problem.interface import UNOBSERVED
from planner.relaxation import unreachable_goals

EXPANSIONS = (200, 2000, 8000, 100_000)
"""Maximum number of expansions at each level; the last is the whole world."""
OTHERS = 150
"""Maximum number of expansions for each further solution."""
SEARCHES = 8
"""Maximum number of searches for further solutions."""
ALL_LEVELS = LEVELS + 1
MAX_STEPS = 30_000
"""Maximum number of ground steps of a world that is searched."""


Variant = tuple[str, int]
"""An action's name and how many agents take part."""


def discover(
    index: WorldIndex,
    goals: Sequence[Fact],
    levels: int = ALL_LEVELS,
    is_over: Callable[[], bool] = UNOBSERVED.should_stop,
) -> tuple[tuple[Step, ...], ...]:
    """Solutions of these goals that differ in operators or kinds of agents, in order of discovery.

    :param levels: how many worlds are searched, the smallest first; with fewer than all one solution is enough.
    :param is_over: asked now and then; True ends the search.
    """
    if levels < ALL_LEVELS:
        return _first_solution(index, goals, levels, is_over)
    doubted = False
    for permissive in (False, True):
        for level, task in _tasks(index, goals, permissive, is_over):
            if not is_reachable(task):
                if not doubted and unreachable_goals(
                    index.knowledge_base, replace(index.problem, goals=tuple(goals))
                ):
                    return ()
                doubted = True
                continue
            found = search(task, expansions=EXPANSIONS[level], permissive=permissive, is_over=is_over)
            if found is not None:
                return (found, *_others(index, goals, level, task, found, is_over))
            if is_over():
                return ()
    return ()


def _first_solution(
    index: WorldIndex, goals: Sequence[Fact], levels: int, is_over: Callable[[], bool]
) -> tuple[tuple[Step, ...], ...]:
    """The first solution in the smallest worlds."""
    for level, task in islice(_tasks(index, goals, False, is_over), levels):
        if is_reachable(task):
            found = search(task, expansions=EXPANSIONS[level], is_over=is_over)
            if found is not None:
                return (found,)
    return ()


def _tasks(
    index: WorldIndex, goals: Sequence[Fact], permissive: bool, is_over: Callable[[], bool]
) -> Iterator[tuple[int, Task]]:
    """The levels' tasks and, where all else failed, the whole world's, as far as they are small enough."""
    seen: set[frozenset[str]] = set()
    for level in range(LEVELS + permissive):
        whole = level == LEVELS
        world = frozenset(index.objects) if whole else small_world(index, goals, level)
        if world in seen and not whole:
            continue
        seen.add(world)
        task = task_of(index, world, goals, limit=MAX_STEPS, is_over=is_over)
        if task is not None:
            yield level, task


def _others(
    index: WorldIndex,
    goals: Sequence[Fact],
    level: int,
    task: Task,
    first: tuple[Step, ...],
    is_over: Callable[[], bool],
) -> Iterator[tuple[Step, ...]]:
    """Solutions without an operator or a kind of agents of those before, as far as they are new."""
    named = {arg for goal in goals for arg in goal.args}
    shapes = {_shape(index, first)}
    tried: set[frozenset[Variant | int]] = set()
    queue: deque[frozenset[Variant | int]] = deque(_left_out(index, named, frozenset(), first))
    left = SEARCHES
    while queue and left > 0 and not is_over():
        without = queue.popleft()
        if without in tried:
            continue
        tried.add(without)
        other = _without(index, goals, level, task, without, is_over)
        if other is None or not is_reachable(other):
            continue
        left -= 1
        steps = search(other, expansions=OTHERS, is_over=is_over)
        if steps is not None and _shape(index, steps) not in shapes:
            shapes.add(_shape(index, steps))
            queue.extend(_left_out(index, named, without, steps))
            yield steps


def _left_out(
    index: WorldIndex, named: set[str], before: frozenset[Variant | int], steps: Sequence[Step]
) -> list[frozenset[Variant | int]]:
    """One operator or kind of agents more to do without: each of a solution's, the kinds first."""
    kinds = {index.kind_of[agent]: None for step in steps for agent in step.agents if agent not in named}
    items: tuple[Variant | int, ...] = (*kinds, *dict.fromkeys(step.variant for step in steps))
    return [before | frozenset([item]) for item in items]


def _without(
    index: WorldIndex,
    goals: Sequence[Fact],
    level: int,
    task: Task,
    without: frozenset[Variant | int],
    is_over: Callable[[], bool],
) -> Task | None:
    kinds = [item for item in without if isinstance(item, int)]
    if kinds:
        world = small_world(index, goals, min(level, LEVELS - 1), kinds)
        if world <= task.objects:
            task = task.among(world)
        elif (other := task_of(index, world, goals, limit=MAX_STEPS, is_over=is_over)) is not None:
            task = other
        else:
            return None
    return task.without([item for item in without if not isinstance(item, int)])


def _shape(index: WorldIndex, steps: Sequence[Step]) -> frozenset[tuple[object, int]]:
    """The solution's operators and kinds of agents, with how often each occurs."""
    used = Counter((step.op.name, *(index.kind_of[agent] for agent in step.agents)) for step in steps)
    return frozenset(used.items())
