"""The delete relaxation of a task: what could be reached, by how many steps, if nothing were ever undone.

The estimate is the set-additive one (Keyder and Geffner 2008): each fact has a relaxed plan of its own, in which
a step counts once. Of two of equal length the one whose steps build more on one another is taken, since what
builds on one another is likelier to hold at the same time; then the quicker one. Facts chosen one by one bring in
steps that others of the plan make needless; they are taken out again, the last first.
"""

from dataclasses import dataclass
from heapq import heappop, heappush

from planner.engines.hierarchical.fragments.steps import Task, bits

UNREACHED = float("inf")
SAME = 1e-9


def is_reachable(task: Task) -> bool:
    """False if no sequence of steps reaches the goals, not even without deletes."""
    state = task.initial
    waiting = list(task.steps)
    while state & task.goal != task.goal:
        later = []
        for step in waiting:
            if state & step.needs == step.needs:
                state |= step.adds
            else:
                later.append(step)
        if len(later) == len(waiting):
            return False
        waiting = later
    return True


@dataclass(frozen=True, slots=True)
class RelaxedPlan:
    """A relaxed plan's cost (inf if there is none), its steps by their own relaxed plans' lengths, and the steps
    that can be carried out at once."""

    cost: float
    steps: tuple[int, ...]
    applicable: tuple[int, ...]


class Relaxed:
    """Of each fact reached from a state its relaxed plan: length, steps (a mask of their numbers), depth, duration."""

    def __init__(self, task: Task, state: int) -> None:
        self.task = task
        self.state = state
        self.lengths = [-1] * task.width
        self.plans = [0] * task.width
        self.depths = [0.0] * task.width
        self.spans = [0.0] * task.width
        self.heap: list[tuple[int, int]] = []
        for bit in bits(state):
            self.lengths[bit] = 0
            self.heap.append((0, bit))
        self.begun: dict[int, int] = {}
        self.missing = task.goal & ~state
        self._reach()

    def _reach(self) -> None:
        """Facts in the order of their plans' lengths until the goals are among them."""
        task = self.task
        lengths = self.lengths
        heap = self.heap
        waiting = list(task.counts)
        wanted_by = task.wanted_by
        settled = [False] * task.width
        for number, wanted in enumerate(waiting):
            if not wanted:
                self._begin(number)
        while heap and self.missing:
            length, bit = heappop(heap)
            if settled[bit] or length > lengths[bit]:
                continue
            settled[bit] = True
            self.missing &= ~(1 << bit)
            for number in wanted_by[bit]:
                waiting[number] -= 1
                if not waiting[number]:
                    self._begin(number)

    def _begin(self, number: int) -> None:
        """Carry out a step all of whose needs are reached."""
        task = self.task
        lengths = self.lengths
        plans = self.plans
        depths = self.depths
        spans = self.spans
        plan = 1 << number
        depth = 0.0
        span = 0.0
        for bit in task.needing[number]:
            plan |= plans[bit]
            depth += depths[bit]
            span = max(span, spans[bit])
        length = plan.bit_count()
        depth = 1.0 + depth / (task.counts[number] or 1)
        span += task.steps[number].cost
        self.begun[number] = length
        for bit in task.adding[number]:
            known = lengths[bit]
            if known < 0 or length < known:
                heappush(self.heap, (length, bit))
            elif length > known or (-depth, span) >= (SAME - depths[bit], spans[bit]):
                continue
            lengths[bit] = length
            plans[bit] = plan
            depths[bit] = depth
            spans[bit] = span

    def plan(self) -> RelaxedPlan:
        """A short relaxed plan from the state to the goals."""
        now = tuple(number for number, length in self.begun.items() if length == 1)
        if self.missing:
            return RelaxedPlan(UNREACHED, (), now)
        mask = 0
        for bit in bits(self.task.goal):
            mask |= self.plans[bit]
        numbers = self._needed(sorted(bits(mask), key=lambda number: (self.begun[number], number)))
        return RelaxedPlan(sum(self.task.steps[number].cost for number in numbers), numbers, now)

    def _needed(self, numbers: list[int]) -> tuple[int, ...]:
        """The plan's steps without those, and what builds on them, that it can do without."""
        position = len(numbers) - 1
        while position >= 0:
            fewer = self._carried_out(numbers[:position] + numbers[position + 1 :])
            if fewer is not None:
                numbers = fewer
            position = min(position, len(numbers)) - 1
        return tuple(numbers)

    def _carried_out(self, numbers: list[int]) -> list[int] | None:
        """Those of the steps whose needs the ones before them meet; None if they do not reach the goals."""
        steps = self.task.steps
        state = self.state
        done = []
        for number in numbers:
            step = steps[number]
            if state & step.needs == step.needs:
                state |= step.adds
                done.append(number)
        return done if state & self.task.goal == self.task.goal else None
