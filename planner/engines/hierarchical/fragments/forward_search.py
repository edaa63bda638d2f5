"""Forward search in a small world: best first, by total and by remaining cost in turn, with look-ahead.

Each state's relaxed plan is also carried out as far as it goes and the state it leads to tried next (YAHSP,
Vidal 2004), which solves most goals without branching. A step is there for its intended effects (MACTA §5,
table 3), so each step has the obligation that one of them is used; a path on which an obligation cannot be met is
dropped.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count

from planner.engines.hierarchical.fragments.action_elimination import is_intended, merged, needed
from planner.engines.hierarchical.fragments.heuristic import UNREACHED, Relaxed
from planner.engines.hierarchical.fragments.steps import Step, Task

Obligations = frozenset[tuple[tuple[str, ...], int, int, int]]
"""Of each step not used yet: its agents and its intended, way-making and other effects, as masks."""
POLISH = 12
"""After the first solution the search continues for this many expansions plus as many as it took."""


@dataclass(frozen=True, slots=True)
class _Node:
    state: int
    obligations: Obligations
    cost: float
    parent: "_Node | None" = None
    by: tuple[int, ...] = ()

    def path(self) -> Iterator[int]:
        if self.parent is not None:
            yield from self.parent.path()
        yield from self.by


def search(
    task: Task, *, expansions: int, is_over: Callable[[], bool], permissive: bool = False
) -> tuple[Step, ...] | None:
    """A cheap solution in which every step is needed and intended; None if none was found.

    :param is_over: asked now and then; True ends the search.
    :param permissive: include paths on which a step's other effect is used before an intended one, or on which an
        agent makes way for itself.
    """
    return _Search(task, expansions, is_over, permissive).run()


class _Search:
    def __init__(self, task: Task, expansions: int, is_over: Callable[[], bool], permissive: bool) -> None:
        self.task = task
        self.left = expansions
        self.is_over = is_over
        self.permissive = permissive
        self.costs: dict[tuple[int, Obligations], float] = {}
        self.by_total: list[tuple[float, int, _Node]] = []
        self.by_rest: list[tuple[float, int, _Node]] = []
        self.best: tuple[Step, ...] | None = None
        self.best_cost = UNREACHED
        self.expanded = 0
        self.ties = count()

    def run(self) -> tuple[Step, ...] | None:
        root = _Node(self.task.initial, frozenset(), 0.0)
        if root.state & self.task.goal == self.task.goal:
            return ()
        self.costs[root.state, root.obligations] = 0.0
        self._push(root, 0.0, 0.0)
        closed: set[_Key] = set()
        while self.left > 0 and (node := self._next()) is not None:
            key = node.state, node.obligations
            if self.costs[key] < node.cost or (*key, node.cost) in closed or node.cost >= self.best_cost:
                continue
            closed.add((*key, node.cost))
            if self.expanded % 16 == 15 and self.is_over():
                break
            self.left -= 1
            self.expanded += 1
            self._expand(node)
        return self.best

    def _next(self) -> _Node | None:
        """The most promising node by total cost and, before the first solution, by remaining cost in turn."""
        greedy = self.best is None and self.expanded % 2 and self.by_rest
        queue = self.by_rest if greedy else self.by_total
        return heappop(queue)[2] if queue else None

    def _push(self, node: _Node, total: float, rest: float) -> None:
        tie = next(self.ties)
        heappush(self.by_total, (total, tie, node))
        if self.best is None:
            heappush(self.by_rest, (rest, tie, node))

    def _expand(self, node: _Node) -> None:
        relaxed = Relaxed(self.task, node.state).plan()
        if node.cost + relaxed.cost >= self.best_cost or relaxed.cost == UNREACHED:
            return
        ahead = self._ahead(node, relaxed.steps)
        if ahead is not None:
            self._add(ahead, 0.0, 0.0)
        for number in relaxed.applicable:
            child = self._after(node, number)
            if child is not None:
                detour = 0.0 if number in relaxed.steps else self.task.steps[number].cost
                rest = relaxed.cost + detour
                self._add(child, node.cost + rest, rest)

    def _ahead(self, node: _Node, relaxed: Sequence[int]) -> _Node | None:
        """Where the relaxed plan leads: its steps that can be carried out, in order, round after round."""
        waiting = list(relaxed)
        at = node
        while waiting:
            later = []
            for number in waiting:
                needs = self.task.steps[number].needs
                after = self._after(at, number) if at.state & needs == needs else None
                if after is None:
                    later.append(number)
                else:
                    at = after
            if len(later) == len(waiting):
                break
            waiting = later
        done = tuple(at.path())[len(tuple(node.path())) :]
        return _Node(at.state, at.obligations, at.cost, node, done) if len(done) > 1 else None

    def _after(self, node: _Node, number: int) -> _Node | None:
        """The node after a step; None if some step's obligation can then not be met any longer."""
        step = self.task.steps[number]
        obligations = set()
        for agents, intended, ways, aside in node.obligations:
            if step.needs & intended or (step.needs & ways and (self.permissive or step.agents != agents)):
                continue
            kept = intended & ~step.removes, ways & ~step.removes, aside & ~step.removes
            used_aside = step.needs & aside and not self.permissive
            if used_aside or not (kept[0] or (kept[1] and self.permissive)):
                return None
            obligations.add((agents, *kept))
        standing = node.state & ~step.removes
        fresh = step.adds & ~standing
        if not fresh & step.justifying:
            return None
        if not fresh & step.justifying & self.task.goal:
            intended = fresh & step.intended
            ways = fresh & step.justifying & ~intended
            obligations.add((step.agents, intended, ways, fresh & ~step.justifying))
        return _Node(standing | step.adds, frozenset(obligations), node.cost + step.cost, node, (number,))

    def _add(self, node: _Node, total: float, rest: float) -> None:
        key = node.state, node.obligations
        if node.cost >= self.costs.get(key, UNREACHED):
            return
        self.costs[key] = node.cost
        if node.state & self.task.goal == self.task.goal:
            self._solved([self.task.steps[number] for number in node.path()])
        self._push(node, total, rest)

    def _solved(self, path: Sequence[Step]) -> None:
        steps = merged(self.task, needed(self.task, path))
        cost = sum(step.cost for step in steps)
        if cost < self.best_cost and is_intended(self.task, steps):
            if self.best is None:
                self.left = min(self.left, POLISH + self.expanded)
            self.best = steps
            self.best_cost = cost


_Key = tuple[int, Obligations, float]
