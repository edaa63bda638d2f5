"""Removes unneeded steps from a solution (action elimination, Nakhost & Müller 2010) and merges detours."""

from collections.abc import Sequence

from planner.engines.hierarchical.fragments.steps import Step, Task, bits


def is_intended(task: Task, steps: Sequence[Step]) -> bool:
    """True if each step has a use among its justifying effects."""
    return all(used & step.justifying for step, used in zip(steps, uses(task, steps), strict=True))


def needed(task: Task, steps: Sequence[Step]) -> tuple[Step, ...]:
    """The steps that the goals need: each other one is removed with all that then lack a condition."""
    kept = list(steps)
    position = 0
    while position < len(kept):
        state = task.initial
        trial = []
        for number, step in enumerate(kept):
            if number != position and state & step.needs == step.needs:
                state = state & ~step.removes | step.adds
                trial.append(step)
        if state & task.goal == task.goal:
            kept = trial
        else:
            position += 1
    return tuple(kept)


def merged(task: Task, steps: Sequence[Step]) -> tuple[Step, ...]:
    """The steps without detours: two of one operator and agents are replaced by one where one will do."""
    kept = list(steps)
    for late in range(len(kept) - 1, 0, -1):
        for early in range(late):
            one = kept[early]
            other = kept[late]
            if one.op is not other.op or one.agents != other.agents:
                continue
            trials = (
                [*kept[:early], *kept[early + 1 : late], step, *kept[late + 1 :]]
                for step in task.steps
                if step.op is one.op and step.cost < one.cost + other.cost and step.agents == one.agents
            )
            better = next((trial for trial in trials if solves(task, trial)), None)
            if better is not None:
                return merged(task, needed(task, better))
    return tuple(kept)


def solves(task: Task, steps: Sequence[Step]) -> bool:
    """True if the steps can be carried out in this order and reach the goals."""
    state = task.initial
    for step in steps:
        if state & step.needs != step.needs:
            return False
        state = state & ~step.removes | step.adds
    return state & task.goal == task.goal


def uses(task: Task, steps: Sequence[Step]) -> list[int]:
    """For each step which of its effects later steps or the goals use (as the causal links will: from
    the earliest producer after the last delete)."""
    producers: dict[int, int] = {}
    standing = task.initial
    used = [0] * len(steps)
    for number, step in enumerate(steps):
        for bit in bits(step.needs):
            if bit in producers:
                used[producers[bit]] |= 1 << bit
        standing &= ~step.removes
        for bit in bits(step.removes):
            producers.pop(bit, None)
        for bit in bits(step.adds & ~standing):
            producers[bit] = number
        standing |= step.adds
    for bit in bits(task.goal):
        if bit in producers:
            used[producers[bit]] |= 1 << bit
    return used
