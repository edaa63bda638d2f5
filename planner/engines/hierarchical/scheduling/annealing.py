"""Simulated annealing over priorities, alternatives and recruitment (Kirkpatrick et al. 1983). Compiled (numba).

Runs in chunks, between which the caller reads the clock.
"""

import numpy as np

from planner.compiled import inlined, lean
from planner.engines.hierarchical.scheduling.decoder import IMPOSSIBLE, decode
from planner.engines.hierarchical.scheduling.decoder_state import FREE, LAST, NONE, decoder_state_for
from planner.engines.hierarchical.scheduling.model import (
    AHEAD,
    BACK,
    NEAR,
    PUSH,
    STRICT,
    Choice,
    Floats,
    Model,
)


class Schedule:
    """A decoded choice: its steps with their agents in an order they can be carried out.

    `settled`: the choice with each leg given to the agent that took it. It may make another schedule: an agent that is
    chosen waits for what is in its way, while otherwise one that can go at once takes the leg.
    """

    def __init__(self, model: Model, choice: Choice, weights: Floats) -> None:
        state = decoder_state_for(model)
        state.taken[:] = choice.agent
        decisive, cost, length, makespan = decode(model, choice, weights, np.inf, state)
        self.choice = choice
        self.settled = choice._replace(agent=state.taken)
        self.decisive = float(decisive)
        self.cost = float(cost)
        self.makespan_s = float(makespan)
        self.steps = state.steps[:length]
        self.team = state.step_agents[:length]
        self.configurations = state.configuration
        self.missing = int(state.missing_fact[0])

    @property
    def is_possible(self) -> bool:
        return self.cost < IMPOSSIBLE

    @property
    def merit(self) -> tuple[float, float]:
        """The least is the best."""
        return self.decisive, self.cost


INITIAL_TEMPERATURE = 1.0
"""The temperature at the start of a round, as a share of what a leg costs on average."""
FINAL_TEMPERATURE = 0.025
"""… and at its end."""
FIRST_ROUND = 32
"""Trials of the first round for each leg of a choice; each further round has as many as all before it."""
CHUNK_WORK = 4000
"""Trials times legs of a chunk: some milliseconds."""
MIN_CHUNK = 8
CRITICAL_SHARE = 0.7
"""The share of moves that are about a leg on the critical path."""


class Annealing:
    """A search from one choice on, in rounds that each begin from the best choice and are cooled down.

    What a number of trials finds does not depend on how many follow: a longer search begins with the shorter one.
    `best` only ever gets better.
    """

    def __init__(self, model: Model, schedule: Schedule, weights: Floats, *, seed: int) -> None:
        self.best = schedule.choice
        self.trials = 0
        """Made so far."""
        self._decisive = schedule.decisive
        self._best_cost = schedule.cost
        self._model = model
        self._weights = weights
        self._here = _copy(schedule.choice)
        self._here_cost = schedule.cost
        self._random = np.random.default_rng(seed)
        self._state = decoder_state_for(model)
        self._trial = _copy(schedule.choice)
        self._critical = np.empty_like(self._state.steps)
        legs = max(1, len(self.best.order))
        self._chunk = max(MIN_CHUNK, CHUNK_WORK // legs)
        self._begun = 0
        self._ends = FIRST_ROUND * legs
        # Zero trials: compile now, so that compilation is not part of any time measured later.
        self._run_trials(_copy(schedule.choice), 1.0, 0, 0)

    def go_on(self, most: int) -> bool:
        """Make the next trials, at most so many; True if the best became better.

        Fewer than a chunk has are its first ones, after which the search ends.
        """
        before = self._decisive, self._best_cost
        if self.trials >= self._ends:
            self._begun = self.trials
            self._ends = 2 * self.trials
            self._simplify()
            self._here = _copy(self.best)
            self._here_cost = self._best_cost
        share = (self.trials - self._begun) / (self._ends - self._begun)
        temperature = (
            max(1.0, self._best_cost)
            / max(1, len(self.best.order))
            * INITIAL_TEMPERATURE
            * (FINAL_TEMPERATURE / INITIAL_TEMPERATURE) ** share
        )
        best = _copy(self.best)
        seed = int(self._random.integers(2**31 - 1))
        self._here_cost, self._decisive, self._best_cost = self._run_trials(
            best, temperature, min(most, self._chunk), seed
        )
        self.trials += self._chunk
        self.best = best
        return (self._decisive, self._best_cost) < before

    def _simplify(self) -> None:
        """Let each task take its first, quickest alternative if that is as good: what others add may be redundant."""
        for task in np.flatnonzero(self.best.alternative).tolist():
            alternative = self.best.alternative.copy()
            alternative[task] = 0
            simpler = Schedule(self._model, self.best._replace(alternative=alternative), self._weights)
            if simpler.decisive <= self._decisive:
                self.best = simpler.choice
                self._decisive = simpler.decisive
                self._best_cost = simpler.cost

    def _run_trials(
        self, best: Choice, temperature: float, trials: int, seed: int
    ) -> tuple[float, float, float]:
        costs: tuple[float, float, float] = _anneal(
            self._model,
            self._here,
            best,
            self._trial,
            self._critical,
            float(self._here_cost),
            float(self._decisive),
            float(self._best_cost),
            float(temperature),
            trials,
            self._weights,
            seed,
            self._state,
        )
        return costs


def _copy(choice: Choice) -> Choice:
    return Choice(*(array.copy() for array in choice))


@lean
def _copy_into(choice, other):  # type: ignore[no-untyped-def]
    for task in range(choice.alternative.shape[0]):
        choice.alternative[task] = other.alternative[task]
    for n in range(choice.order.shape[0]):
        choice.order[n] = other.order[n]
        choice.agent[n] = other.agent[n]
        choice.stops[n] = other.stops[n]


@inlined
def _is_same(choice, other):  # type: ignore[no-untyped-def]
    for task in range(choice.alternative.shape[0]):
        if choice.alternative[task] != other.alternative[task]:
            return False
    for n in range(choice.order.shape[0]):
        if (
            choice.order[n] != other.order[n]
            or choice.agent[n] != other.agent[n]
            or choice.stops[n] != other.stops[n]
        ):
            return False
    return True


@lean
def _anneal(  # type: ignore[no-untyped-def]
    model,
    here,
    best,
    trial,
    critical,
    here_cost,
    best_decisive,
    best_cost,
    temperature,
    trials,
    weights,
    seed,
    state,
):
    """Make the trials from `here` on; `here` and `best` are changed. Returns the cost of `here` and the costs of `best`
    without and with what breaks ties."""
    if here.alternative.shape[0] == 0:
        return here_cost, best_decisive, best_cost
    np.random.seed(seed)
    _copy_into(trial, here)
    decode(model, here, weights, np.inf, state)
    count = _critical_path(state, critical)
    for _ in range(trials):
        if count > 0 and np.random.random() < CRITICAL_SHARE:
            _move_critical_leg(model, trial, critical[:count])
        else:
            _random_move(model, trial)
        most = here_cost - temperature * np.log(np.random.random())
        if _is_same(here, trial):
            continue
        decisive, cost, _, _ = decode(model, trial, weights, most, state)
        if cost <= here_cost or (cost < IMPOSSIBLE and cost <= most):
            here_cost = cost
            count = _critical_path(state, critical)
            _copy_into(here, trial)
            if decisive < best_decisive or (decisive == best_decisive and cost < best_cost):
                best_decisive = decisive
                best_cost = cost
                _copy_into(best, trial)
        else:
            _copy_into(trial, here)
    return here_cost, best_decisive, best_cost


@lean
def _critical_path(state, critical):  # type: ignore[no-untyped-def]
    """Fill in the legs (task·K + leg) that the last one to end had to wait for, backwards; how many."""
    step = int(state.free[np.argmax(state.free[:, FREE]), LAST])
    count = 0
    while step >= 0:
        if count == 0 or critical[count - 1] != state.step_leg[step]:
            critical[count] = state.step_leg[step]
            count += 1
        step = state.cause[step]
    return count


@lean
def _move_critical_leg(model, choice, critical):  # type: ignore[no-untyped-def]
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
        _change_agent(model, choice, place)
    elif kind < 0.9:
        _change_stop(choice, place)
    else:
        _change_alternative(model, choice, place // model.max_legs)


@lean
def _random_move(model, choice):  # type: ignore[no-untyped-def]
    """One random move: another place in the order, an exchange, another alternative or another agent."""
    kind = np.random.random()
    order = choice.order
    count = order.shape[0]
    if kind < 0.15:
        _change_alternative(model, choice, np.random.randint(choice.alternative.shape[0]))
    elif kind < 0.22:
        _change_stop(choice, np.random.randint(count))
    elif kind < 0.5:
        _change_agent(model, choice, np.random.randint(count))
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
def _change_alternative(model, choice, task):  # type: ignore[no-untyped-def]
    choices = model.task_first[task + 1] - model.task_first[task]
    if choices > 1:
        choice.alternative[task] = np.random.randint(choices)
        for place in range(task * model.max_legs, (task + 1) * model.max_legs):
            choice.agent[place] = NONE


@lean
def _change_stop(choice, place):  # type: ignore[no-untyped-def]
    kind = np.random.randint(4)
    if choice.stops[place] & STRICT and kind > 0:
        choice.stops[place] -= STRICT
    elif kind < 2:
        choice.stops[place] ^= AHEAD if kind == 0 else PUSH
    else:
        now = choice.stops[place] & (BACK | NEAR)
        choice.stops[place] += (now + np.random.randint(1, 3)) % 3 - now


@lean
def _change_agent(model, choice, place):  # type: ignore[no-untyped-def]
    """Give a leg to another agent of the class, or to whoever can begin first."""
    task = place // model.max_legs
    choice.agent[place] = NONE
    chosen = model.task_first[task] + choice.alternative[task]
    leg = model.leg_first[chosen] + place % model.max_legs
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
