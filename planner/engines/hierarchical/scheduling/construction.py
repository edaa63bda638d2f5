"""Good first choices that account for places: of all legs that can be next, always the one that is best by a rule.

Each is tried on the timelines, as the decoder places it. The rule is drawn at random for each choice, since none is the
best for every problem: a greedy randomised construction (Feo and Resende 1995). Compiled (numba).
"""

from collections.abc import Sequence

import numpy as np

from planner.compiled import inlined, lean
from planner.engines.hierarchical.scheduling.decoder import LEGS, PLACES, WAITS_FOR, clear, make_way
from planner.engines.hierarchical.scheduling.decoder_state import NONE, decoder_state_for
from planner.engines.hierarchical.scheduling.model import NEAR, PUSH, Choice, Floats, Model
from planner.engines.hierarchical.scheduling.placement import place_leg, take_back

FOR_WORK = (1.0, 1.5, 2.0)
"""Seconds by which a leg may end later for each second that it takes: with 1 the leg that begins first comes next."""
FOR_REST = (-0.2, 0.0, 0.0)
"""… and for each second of work that comes after it in its task."""
LEAST_NOISE_S, MOST_NOISE_S = 5.0, 100.0
"""The noise on when a task's legs end: the bounds of its largest value."""
STOPS = (0, NEAR, PUSH, NEAR | PUSH)
"""Where all agents stop on their ways."""

DONE = LEGS
"""The state's `waiting` is by task here: in this row how many legs are placed, in the others what its next leg is and
waits for."""


class Constructor:
    """Makes choices for one model."""

    def __init__(self, model: Model, comes_last: Sequence[bool] = ()) -> None:
        """:param comes_last: of each task, if its legs are placed after those of all others."""
        self._model = model
        self._comes_last = np.array(comes_last or [False] * len(model.task_deadline_s))
        self._state = decoder_state_for(model)
        until = np.concatenate([[0.0], np.cumsum(model.step_span_s[model.core_steps])])[model.core_first]
        last = np.repeat(model.leg_first[1:], np.diff(model.leg_first))
        self._work_s: Floats = np.diff(until)
        """Of each leg, without its ways."""
        self._rest_s: Floats = until[last] - until[1:]
        """Of the legs of its task that come after each leg."""

    def choice(self, random: np.random.Generator) -> Choice:
        """A choice by a rule drawn at random; the legs for which there was no place come last."""
        tasks = len(self._model.task_deadline_s)
        legs = np.arange(tasks * self._model.max_legs, dtype=np.int32)
        choice = Choice.of(legs.copy(), np.zeros(tasks, np.int32))
        choice.stops[:] = random.choice(STOPS)
        most_s = LEAST_NOISE_S * (MOST_NOISE_S / LEAST_NOISE_S) ** random.random()
        placed = _construct(
            self._model,
            random.choice(FOR_WORK) * self._work_s + random.choice(FOR_REST) * self._rest_s,
            random.random(len(self._model.leg_first) - 1) * most_s,
            self._comes_last,
            choice,
            self._state,
        )
        choice.order[placed:] = np.setdiff1d(legs, choice.order[:placed])
        return choice


@lean
def _place(model, state, leg, place, stops, length):  # type: ignore[no-untyped-def]
    """As `place_leg`, by whoever can begin first; not inlined, since compiling that takes long."""
    return place_leg(model, state, leg, place, NONE, stops, False, length)


@lean
def _construct(model, worth_s, noise_s, comes_last, choice, state):  # type: ignore[no-untyped-def]
    """Fill in the order and the alternatives of a choice; how many legs were placed.

    :param worth_s: (L,) by how much later each leg may end than others.
    :param noise_s: (M,) added to when the legs of each alternative end.
    :param comes_last: (T,) whether a task's legs are placed after those of all others.
    """
    clear(model, state)
    done = state.waiting[DONE]
    waits_for = state.waiting[WAITS_FOR]
    places = state.waiting[PLACES]
    tasks = choice.alternative.shape[0]
    others = 0
    for task in range(tasks):
        done[task] = 0
        places[task] = task * model.max_legs
        others += 0 if comes_last[task] else 1
    placed = 0
    length = 0
    ways_made = 0
    while True:
        task, alternative = _best(
            model, worth_s, noise_s, comes_last, others, choice, done, waits_for, length, state
        )
        if task != NONE:
            choice.alternative[task] = alternative - model.task_first[task]
            place = int(task * model.max_legs + done[task])
            leg = int(model.leg_first[alternative] + done[task])
            length, _ = _place(model, state, leg, place, choice.stops[place], int(length))
            choice.order[placed] = place
            placed += 1
            done[task] += 1
            if leg + 1 == model.leg_first[alternative + 1] and not comes_last[task]:
                others -= 1
            continue
        now = make_way(model, state, choice.stops, waits_for[:tasks], places, length)
        ways_made += 1
        if now < 0 or ways_made > 2 * tasks:
            return placed
        length = now


@inlined
def _best(model, worth_s, noise_s, comes_last, others, choice, done, waits_for, length, state):  # type: ignore[no-untyped-def]
    """The task whose next leg is best, with its alternative; NONE if none can be placed."""
    best = NONE
    best_alternative = NONE
    best_s = np.inf
    for task in range(choice.alternative.shape[0]):
        waits_for[task] = NONE
        if comes_last[task] and others > 0:
            continue
        first = model.task_first[task]
        last = model.task_first[task + 1]
        if done[task] > 0:
            first += choice.alternative[task]
            last = first + 1
        place = int(task * model.max_legs + done[task])
        for alternative in range(first, last):
            leg = int(model.leg_first[alternative] + done[task])
            if leg >= model.leg_first[alternative + 1]:
                continue
            now, end = _place(model, state, leg, place, choice.stops[place], int(length))
            if now < 0:
                waits_for[task] = int(end)
                continue
            take_back(model, state, leg)
            if end + noise_s[alternative] - worth_s[leg] < best_s:
                best = task
                best_alternative = alternative
                best_s = end + noise_s[alternative] - worth_s[leg]
    return best, best_alternative
