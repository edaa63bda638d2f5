"""A good first choice by dispatching: always the leg that can begin first, by the alternative that ends soonest.

It looks at agents, their travel and the order of a task's legs only; the decoder then accounts for places.
"""

import numpy as np

from planner.engines.hierarchical.scheduling.model import UNREACHABLE, Choice, Model

FOR_REST = 0.5
"""How much a second of work still to come in its task counts for taking a leg early."""
NEVER_S = 1e15


class Dispatcher:
    """Makes choices for one model."""

    def __init__(self, model: Model) -> None:
        self._model = model
        steps = np.concatenate([[0.0], np.cumsum(model.step_span_s[model.core_steps])])
        work = np.diff(steps[model.core_first])
        total = np.concatenate([[0.0], np.cumsum(work)])
        leg_end = np.repeat(model.leg_first[1:], np.diff(model.leg_first))
        self._work = work
        self._rest = total[leg_end] - total[: len(work)]
        self._task_of = np.repeat(np.arange(len(model.task_deadline_s)), np.diff(model.task_first))
        spans = np.concatenate([model.way_span_s, [NEVER_S]])
        self._span = spans[np.where(model.way == UNREACHABLE, len(spans) - 1, model.way)]

    def choice(self, noise_s: float, random: np.random.Generator) -> Choice:
        """A choice; the noise makes it stray from the rule."""
        model = self._model
        tasks = len(model.task_deadline_s)
        done = np.zeros(tasks, np.int32)
        ready = np.zeros(tasks)
        free = np.zeros(len(model.agent_class))
        configuration = model.agent_start.copy()
        arrival = free[:, None] + self._span[configuration]
        chosen = np.full(tasks, -1, np.int32)
        open_ = np.diff(model.leg_first) > 0
        jitter_s = random.random(len(self._task_of)) * noise_s
        order: list[int] = []
        while open_.any():
            candidates = np.flatnonzero(open_)
            task = self._task_of[candidates]
            legs = model.leg_first[candidates] + done[task]
            slots = model.slot_first[legs]
            start = np.maximum(self._soonest(arrival, slots), ready[task])
            best = int(np.argmin(start + jitter_s[candidates] - FOR_REST * self._rest[legs]))
            alternative = candidates[best]
            leg = legs[best]
            slot = slots[best]
            agent = self._agent(arrival, slot)
            end = start[best] + self._work[leg]
            if start[best] < NEVER_S:
                way = model.way[configuration[agent], model.slot_need[slot]]
                configuration[agent] = model.after[model.way_end[way], model.slot_effect[slot]]
                free[agent] = end
                arrival[agent] = end + self._span[configuration[agent]]
            here = task[best]
            order.append(here * model.max_legs + done[here])
            ready[here], done[here] = end, done[here] + 1
            if chosen[here] < 0:
                chosen[here] = alternative - model.task_first[here]
                open_[model.task_first[here] : model.task_first[here + 1]] = False
                open_[alternative] = True
            if leg + 1 == model.leg_first[alternative + 1]:
                open_[alternative] = False
        return self._whole(order, chosen)

    def _soonest(self, arrival: np.ndarray, slots: np.ndarray) -> np.ndarray:
        """For each slot when its first possible agent arrives."""
        model = self._model
        soonest = np.empty(len(slots))
        for kind in np.unique(model.slot_class[slots]):
            of_kind = model.slot_class[slots] == kind
            members = model.members[model.member_first[kind] : model.member_first[kind + 1]]
            soonest[of_kind] = arrival[members].min(axis=0)[model.slot_need[slots[of_kind]]]
        bound = model.slot_agent[slots]
        held = bound >= 0
        soonest[held] = arrival[bound[held], model.slot_need[slots[held]]]
        return soonest

    def _agent(self, arrival: np.ndarray, slot: int) -> int:
        model = self._model
        if model.slot_agent[slot] >= 0:
            return int(model.slot_agent[slot])
        kind = model.slot_class[slot]
        members = model.members[model.member_first[kind] : model.member_first[kind + 1]]
        return int(members[np.argmin(arrival[members, model.slot_need[slot]])])

    def _whole(self, order: list[int], chosen: np.ndarray) -> Choice:
        """The choice with the legs that only other alternatives have at its end."""
        size = len(chosen) * self._model.max_legs
        rest = np.setdiff1d(np.arange(size), order)
        return Choice.of(
            np.concatenate([order, rest]).astype(np.int32),
            np.maximum(chosen, 0).astype(np.int32),
        )
