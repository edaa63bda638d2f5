"""Simulated annealing over priorities, alternatives and recruitment (Kirkpatrick et al. 1983). Compiled (numba).

Goes on in chunks, between which the caller looks at the clock.
"""

import numpy as np

from planner.compiled import lean
from planner.engines.hierarchical.scheduling.decoder import IMPOSSIBLE, decode
from planner.engines.hierarchical.scheduling.decoder_state import FREE, LAST, NONE, board_for
from planner.engines.hierarchical.scheduling.model import AHEAD, BACK, NEAR, PUSH, Choice, Floats, Model

HOT = 1.0
"""The temperature at the start, as a share of what a leg costs on average."""
COLD = 0.025
"""… and at the end."""
CRITICAL = 0.7
"""The share of moves that are about a leg on the critical path."""


class Annealing:
    """A search from one choice on; `best` and `best_cost` only ever get better."""

    def __init__(self, model: Model, choice: Choice, cost: float, weights: Floats, *, seed: int) -> None:
        self.best = choice
        self.best_cost = cost
        self._model = model
        self._weights = weights
        self._here = _copy(choice)
        self._here_cost = cost
        self._random = np.random.default_rng(seed)
        self._board = board_for(model)
        self._trial = _copy(choice)
        self._critical = np.empty_like(self._board.steps)
        # No trial, so that whoever looks at the clock from here on sees nothing of what may have to be compiled.
        self._tried(_copy(choice), 1.0, 0, 0)

    def go_on(self, trials: int, share: float) -> bool:
        """Make this many trials, cooled down by the share of the whole that is over; True if the best became better."""
        legs = max(1, len(self.best.order))
        temperature = max(1.0, self.best_cost) / legs * HOT * (COLD / HOT) ** share
        best = _copy(self.best)
        seed = int(self._random.integers(2**31 - 1))
        self._here_cost, best_cost = self._tried(best, temperature, trials, seed)
        better = bool(best_cost < self.best_cost)
        self.best = best
        self.best_cost = best_cost
        return better

    def _tried(self, best: Choice, temperature: float, trials: int, seed: int) -> tuple[float, float]:
        costs: tuple[float, float] = _anneal(
            self._model,
            self._here,
            best,
            self._trial,
            self._critical,
            float(self._here_cost),
            float(self.best_cost),
            float(temperature),
            trials,
            self._weights,
            seed,
            self._board,
        )
        return costs


def _copy(choice: Choice) -> Choice:
    return Choice(*(array.copy() for array in choice))


@lean
def _assign(choice, other):  # type: ignore[no-untyped-def]
    for task in range(choice.alternative.shape[0]):
        choice.alternative[task] = other.alternative[task]
    for n in range(choice.order.shape[0]):
        choice.order[n] = other.order[n]
        choice.agent[n] = other.agent[n]
        choice.aside[n] = other.aside[n]


@lean
def _anneal(  # type: ignore[no-untyped-def]
    model, here, best, trial, critical, here_cost, best_cost, temperature, trials, weights, seed, board
):
    """Make the trials from `here` on; `here` and `best` are changed. Returns their costs."""
    if here.alternative.shape[0] == 0:
        return here_cost, best_cost
    np.random.seed(seed)
    _assign(trial, here)
    decode(model, here, weights, board)
    count = _critical_path(board, critical)
    for _ in range(trials):
        if count > 0 and np.random.random() < CRITICAL:
            _disturb_at(model, trial, critical[:count])
        else:
            _disturb(model, trial)
        cost, _, _ = decode(model, trial, weights, board)
        if cost <= here_cost or (
            cost < IMPOSSIBLE and np.random.random() < np.exp((here_cost - cost) / temperature)
        ):
            here_cost = cost
            count = _critical_path(board, critical)
            _assign(here, trial)
            if cost < best_cost:
                best_cost = cost
                _assign(best, trial)
        else:
            _assign(trial, here)
    return here_cost, best_cost


@lean
def _critical_path(board, critical):  # type: ignore[no-untyped-def]
    """Fill in the legs (task·K + leg) that the last one to end had to wait for, backwards; how many."""
    step = int(board.free[np.argmax(board.free[:, FREE]), LAST])
    count = 0
    while step >= 0:
        if count == 0 or critical[count - 1] != board.served[step]:
            critical[count] = board.served[step]
            count += 1
        step = board.cause[step]
    return count


@lean
def _disturb_at(model, choice, critical):  # type: ignore[no-untyped-def]
    """One move of a leg on the critical path: before the one it waits for, or another agent, stop or alternative."""
    n = np.random.randint(critical.shape[0])
    place = critical[n]
    kind = np.random.random()
    if kind < 0.45:
        start = _position(choice.order, place)
        if n + 1 < critical.shape[0]:
            end = _position(choice.order, critical[n + 1])
        else:
            end = np.random.randint(choice.order.shape[0])
        _shift(choice.order, start, end)
    elif kind < 0.75:
        _recruit(model, choice, place)
    elif kind < 0.9:
        _stop_elsewhere(choice, place)
    else:
        _vary(model, choice, place // model.widest)


@lean
def _disturb(model, choice):  # type: ignore[no-untyped-def]
    """One random move: another place in the order, an exchange, another alternative or another agent."""
    kind = np.random.random()
    order = choice.order
    count = order.shape[0]
    if kind < 0.15:
        _vary(model, choice, np.random.randint(choice.alternative.shape[0]))
    elif kind < 0.22:
        _stop_elsewhere(choice, np.random.randint(count))
    elif kind < 0.5:
        _recruit(model, choice, np.random.randint(count))
        if np.random.random() < 0.5:
            _shift(order, np.random.randint(count), np.random.randint(count))
    elif kind < 0.65:
        one = np.random.randint(count)
        other = np.random.randint(count)
        order[one], order[other] = order[other], order[one]
    else:
        start = np.random.randint(count)
        reach = max(2, count // 4) if np.random.random() < 0.7 else count
        _shift(order, start, min(count - 1, max(0, start + np.random.randint(-reach, reach + 1))))


@lean
def _vary(model, choice, task):  # type: ignore[no-untyped-def]
    choices = model.task_first[task + 1] - model.task_first[task]
    if choices > 1:
        choice.alternative[task] = np.random.randint(choices)
        for place in range(task * model.widest, (task + 1) * model.widest):
            choice.agent[place] = NONE


@lean
def _stop_elsewhere(choice, place):  # type: ignore[no-untyped-def]
    kind = np.random.randint(4)
    if kind < 2:
        choice.aside[place] ^= AHEAD if kind == 0 else PUSH
    else:
        now = choice.aside[place] & (BACK | NEAR)
        choice.aside[place] += (now + np.random.randint(1, 3)) % 3 - now


@lean
def _recruit(model, choice, place):  # type: ignore[no-untyped-def]
    """Give a leg to another agent of the class, or to whoever can begin first."""
    task = place // model.widest
    choice.agent[place] = NONE
    chosen = model.task_first[task] + choice.alternative[task]
    leg = model.leg_first[chosen] + place % model.widest
    if leg < model.leg_first[chosen + 1] and np.random.random() < 0.9:
        kind = model.slot_class[model.slot_first[leg]]
        members = model.member_first[kind]
        many = model.member_first[kind + 1] - members
        choice.agent[place] = model.members[members + np.random.randint(many)]


@lean
def _position(order, place):  # type: ignore[no-untyped-def]
    for n in range(order.shape[0]):
        if order[n] == place:
            return n
    return 0


@lean
def _shift(order, start, end):  # type: ignore[no-untyped-def]
    moved = order[start]
    step = 1 if end > start else -1
    while start != end:
        order[start] = order[start + step]
        start += step
    order[end] = moved
