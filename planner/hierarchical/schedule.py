"""A decoded choice."""

import numpy as np

from planner.hierarchical.decoder import IMPOSSIBLE, decode
from planner.hierarchical.model import MOST_AGENTS, Choice, Floats, Ints, Model
from planner.hierarchical.placing import ANYTHING


class Schedule:
    """A decoded choice (`choice`: as it was taken): its steps with their agents in an order they can be carried out."""

    def __init__(self, model: Model, choice: Choice, weights: Floats) -> None:
        steps, team = outputs(model)
        stuck = np.full(1, ANYTHING, np.int32)
        self.configurations = model.agent_start.copy()
        taken = choice.agent.copy()
        cost, length, makespan = decode(
            model, *choice, weights, steps, team, stuck, self.configurations, taken
        )
        self.choice = choice._replace(agent=taken)
        self.cost, self.makespan_s = float(cost), float(makespan)
        self.steps, self.team = steps[:length], team[:length]
        self.missing = int(stuck[0])

    @property
    def is_possible(self) -> bool:
        return self.cost < IMPOSSIBLE


def outputs(model: Model) -> tuple[Ints, Ints]:
    """Room for the longest schedule there can be."""
    return np.empty(model.most_steps, np.int32), np.zeros((model.most_steps, MOST_AGENTS), np.int32)
