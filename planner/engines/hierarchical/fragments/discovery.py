"""Finds fragments by search: the first in increasingly large worlds, then others without its agents or operators.

Goals are proven unreachable by the delete relaxation of the world's symmetry quotient: whatever can be done in the
world can be done in the quotient, deletes ignored, if two objects with one representative may take part as two.
"""

from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from time import monotonic

from planner.engines.hierarchical.fragments.forward_search import search
from planner.engines.hierarchical.fragments.grounding import task_of
from planner.engines.hierarchical.fragments.heuristic import is_reachable
from planner.engines.hierarchical.fragments.relevance import LEVELS, goal_neighbourhood, small_world
from planner.engines.hierarchical.fragments.steps import Step, Task
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.fact import Fact
from planner.problem.interface import UNOBSERVED, PlanningProblem

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Discovery:
    """The solutions found, the first first; `is_proof`: there is none."""

    solutions: tuple[tuple[Step, ...], ...]
    is_proof: bool


def discover(
    index: WorldIndex,
    goals: Sequence[Fact],
    deadline: float,
    levels: int = ALL_LEVELS,
    stop: Callable[[], bool] = UNOBSERVED.should_stop,
) -> Discovery:
    """Solutions of these goals that differ in operators or kinds of agents.

    :param levels: how many worlds are searched, the smallest first; with fewer than all one solution is enough.
    :param stop: asked now and then; True ends the search as the deadline does.
    """
    if levels < ALL_LEVELS:
        return _first_solution(index, goals, deadline, levels, stop)
    doubted = False
    for permissive in (False, True):
        for level, task in _tasks(index, goals, permissive, deadline):
            if not is_reachable(task):
                if not doubted and is_out_of_reach(index, goals, deadline):
                    return Discovery(solutions=(), is_proof=True)
                doubted = True
                continue
            found = search(
                task, expansions=EXPANSIONS[level], deadline=deadline, permissive=permissive, stop=stop
            )
            if found.steps is not None:
                others = _others(index, goals, level, task, found.steps, deadline, stop)
                return Discovery(solutions=(found.steps, *others), is_proof=False)
            if level == LEVELS and found.exhausted:
                return Discovery(solutions=(), is_proof=True)
            if monotonic() > deadline or stop():
                return Discovery(solutions=(), is_proof=False)
    return Discovery(solutions=(), is_proof=False)


def _first_solution(
    index: WorldIndex, goals: Sequence[Fact], deadline: float, levels: int, stop: Callable[[], bool]
) -> Discovery:
    """The first solution in the smallest worlds."""
    for level, task in islice(_tasks(index, goals, False, deadline), levels):
        if is_reachable(task):
            found = search(task, expansions=EXPANSIONS[level], deadline=deadline, stop=stop)
            if found.steps is not None:
                return Discovery(solutions=(found.steps,), is_proof=False)
    return Discovery(solutions=(), is_proof=False)


def _tasks(
    index: WorldIndex, goals: Sequence[Fact], permissive: bool, deadline: float
) -> Iterator[tuple[int, Task]]:
    """The levels' tasks and, where all else failed, the whole world's, as far as they are small enough."""
    seen: set[frozenset[str]] = set()
    for level in range(LEVELS + permissive):
        whole = level == LEVELS
        world = frozenset(index.objects) if whole else small_world(index, goals, level)
        if world in seen and not whole:
            continue
        seen.add(world)
        task = task_of(index, world, goals, limit=MAX_STEPS, deadline=deadline)
        if task is not None:
            yield level, task


def _others(
    index: WorldIndex,
    goals: Sequence[Fact],
    level: int,
    task: Task,
    first: tuple[Step, ...],
    deadline: float,
    stop: Callable[[], bool],
) -> Iterator[tuple[Step, ...]]:
    """Solutions without an operator or a kind of agents of those before, as far as they are new."""
    named = {arg for goal in goals for arg in goal.args}
    shapes = {_shape(index, first)}
    tried: set[frozenset[Variant | int]] = set()
    queue: deque[frozenset[Variant | int]] = deque(_left_out(index, named, frozenset(), first))
    left = SEARCHES
    while queue and left > 0 and monotonic() < deadline and not stop():
        without = queue.popleft()
        if without in tried:
            continue
        tried.add(without)
        other = _without(index, goals, level, task, without, deadline)
        if other is None or not is_reachable(other):
            continue
        left -= 1
        steps = search(other, expansions=OTHERS, deadline=deadline, stop=stop).steps
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
    deadline: float,
) -> Task | None:
    kinds = [item for item in without if isinstance(item, int)]
    if kinds:
        world = small_world(index, goals, min(level, LEVELS - 1), kinds)
        wider = task_of(index, world, goals, limit=MAX_STEPS, deadline=deadline)
        if wider is None:
            return None
        task = wider
    return task.without([item for item in without if not isinstance(item, int)])


def _shape(index: WorldIndex, steps: Sequence[Step]) -> frozenset[tuple[object, int]]:
    """The solution's operators and kinds of agents, with how often each occurs."""
    used = Counter((step.op.name, *(index.kind_of[agent] for agent in step.agents)) for step in steps)
    return frozenset(used.items())


MAX_QUOTIENT_STEPS = 20_000
"""Maximum number of ground steps of the quotient."""


def is_out_of_reach(index: WorldIndex, goals: Sequence[Fact], deadline: float) -> bool:
    """True if it is proven that no sequence of actions reaches the goals."""
    stands_for = _representatives(index, goals)
    counts: dict[str, int] = {}
    for leader in stands_for.values():
        counts[leader] = counts.get(leader, 0) + 1
    quotient = WorldIndex(index.knowledge_base, _quotient(index.problem, stands_for))
    task = task_of(
        quotient,
        frozenset(counts),
        goals,
        limit=MAX_QUOTIENT_STEPS,
        deadline=deadline,
        many=frozenset(leader for leader, count in counts.items() if count > 1),
    )
    return task is not None and not is_reachable(task)


def _representatives(index: WorldIndex, goals: Sequence[Fact]) -> Mapping[str, str]:
    """For each object the one that stands for it: agents by what they can do and which of the goals' objects
    they have to do with, others by which of these agents have to do with them and what is said of them; the
    goals' objects and those next to them stand for themselves."""
    own = {arg for goal in goals for arg in goal.args}
    own |= {name for name in goal_neighbourhood(index, goals, 2) if name not in index.agents}
    sorts = {kind: (profile, index.neighbours(kind) & own) for kind, profile in index.profiles.items()}
    leaders: dict[Hashable, str] = {}

    def key(name: str) -> Hashable:
        if name in own:
            return name
        if name in index.agents:
            return sorts[index.kind_of[name]]
        near = frozenset(sorts.get(node, node) for node in index.neighbours(name))  # type: ignore[arg-type]
        return index.objects[name], near, index.shape(name)

    return {name: leaders.setdefault(key(name), name) for name in sorted(index.objects)}


def _quotient(problem: PlanningProblem, stands_for: Mapping[str, str]) -> PlanningProblem:
    def led(args: tuple[str, ...]) -> tuple[str, ...]:
        return tuple([stands_for.get(arg, arg) for arg in args])

    return PlanningProblem(
        objects={leader: problem.objects[leader] for leader in stands_for.values()},
        facts=frozenset(Fact(fact.predicate, led(fact.args)) for fact in problem.facts),
        goals=problem.goals,
        functions={(name, led(args)): value for (name, args), value in problem.functions.items()},
    )
