"""Simulated annealing over priorities, alternatives and recruitment (Kirkpatrick et al. 1983). Compiled (numba).

Goes on in chunks, between which the caller looks at the clock.
"""

import numpy as np

from planner.hierarchical.compiled import kernel
from planner.hierarchical.decoder import IMPOSSIBLE, decode
from planner.hierarchical.model import Choice, Floats, Model
from planner.hierarchical.schedule import outputs

HOT = 0.25
"""The temperature at the start, as a share of the cost."""
COLD = 0.002
"""… and at the end."""


class Annealing:
    """A search from one choice on; `best` and `best_cost` only ever get better."""

    def __init__(self, model: Model, choice: Choice, cost: float, weights: Floats, *, seed: int) -> None:
        self.best, self.best_cost = choice, cost
        self._model, self._weights = model, weights
        self._here, self._here_cost = choice, cost
        self._random = np.random.default_rng(seed)
        self._steps, self._team = outputs(model)

    def go_on(self, trials: int, share: float) -> bool:
        """Make this many trials, cooled down by the share of the whole that is over; True if the best became better."""
        temperature = max(1.0, self.best_cost) * HOT * (COLD / HOT) ** share
        order, alternative, agent, aside = (array.copy() for array in self._here)
        best = tuple(array.copy() for array in self.best)
        here_cost, best_cost = _anneal(
            self._model,
            order,
            alternative,
            agent,
            aside,
            *best,
            self._here_cost,
            self.best_cost,
            temperature,
            trials,
            self._weights,
            self._random.integers(2**31 - 1),
            self._steps,
            self._team,
        )
        better = best_cost < self.best_cost
        self._here, self._here_cost = Choice(order, alternative, agent, aside), here_cost
        self.best, self.best_cost = Choice(*best), best_cost
        return bool(better)


@kernel
def _anneal(  # type: ignore[no-untyped-def]
    model,
    order,
    alternative,
    agent,
    aside,
    best_order,
    best_alternative,
    best_agent,
    best_aside,
    here_cost,
    best_cost,
    temperature,
    trials,
    weights,
    seed,
    steps,
    team,
):
    np.random.seed(seed)
    count, tasks = order.shape[0], alternative.shape[0]
    stuck = np.zeros(1, np.int32)
    at_end = model.agent_start.copy()
    taken = agent.copy()
    old_order, old_alternative = order.copy(), alternative.copy()
    old_agent, old_aside = agent.copy(), aside.copy()
    for _ in range(trials if tasks > 0 else 0):
        _disturb(model, order, alternative, agent, aside, count, tasks)
        cost, _, _ = decode(
            model, order, alternative, agent, aside, weights, steps, team, stuck, at_end, taken
        )
        if cost <= here_cost or (
            cost < IMPOSSIBLE and np.random.random() < np.exp((here_cost - cost) / temperature)
        ):
            here_cost = cost
            old_order[:], old_alternative[:], old_agent[:], old_aside[:] = order, alternative, agent, aside
            if cost < best_cost:
                best_cost = cost
                best_order[:], best_alternative[:], best_agent[:], best_aside[:] = (
                    order,
                    alternative,
                    agent,
                    aside,
                )
        else:
            order[:], alternative[:], agent[:], aside[:] = old_order, old_alternative, old_agent, old_aside
    return here_cost, best_cost


@kernel
def _disturb(model, order, alternative, agent, aside, count, tasks):  # type: ignore[no-untyped-def]
    """One random move: another place in the order, an exchange, another alternative or another agent."""
    kind = np.random.random()
    task = np.random.randint(tasks)
    choices = model.task_first[task + 1] - model.task_first[task]
    if kind < 0.15 and choices > 1:
        alternative[task] = np.random.randint(choices)
        agent[task * model.widest : (task + 1) * model.widest] = -1
    elif kind < 0.22:
        leg = np.random.randint(agent.shape[0])
        aside[leg] = (aside[leg] + np.random.randint(1, 3)) % 3
    elif kind < 0.5:
        leg = np.random.randint(agent.shape[0])
        if agent[leg] >= 0 and np.random.random() < 0.9:
            members = model.member_first[model.agent_class[agent[leg]]]
            many = model.member_first[model.agent_class[agent[leg]] + 1] - members
            agent[leg] = model.members[members + np.random.randint(many)]
        else:
            agent[leg] = -1
        if np.random.random() < 0.5:
            _shift(order, np.random.randint(count), np.random.randint(count))
    elif kind < 0.65:
        one, other = np.random.randint(count), np.random.randint(count)
        order[one], order[other] = order[other], order[one]
    else:
        start = np.random.randint(count)
        reach = max(2, count // 4) if np.random.random() < 0.7 else count
        _shift(order, start, min(count - 1, max(0, start + np.random.randint(-reach, reach + 1))))


@kernel
def _shift(order, start, end):  # type: ignore[no-untyped-def]
    moved = order[start]
    step = 1 if end > start else -1
    while start != end:
        order[start] = order[start + step]
        start += step
    order[end] = moved
